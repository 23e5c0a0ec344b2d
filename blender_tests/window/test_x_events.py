# SPDX-License-Identifier: GPL-3.0-or-later
"""Events from the X server instead of simulated ones: bursts of moves arrive merged, as from a
hand. The last test of a session: Blender does not simulate events any more."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import bpy
import numpy as np
from scenes import NAME, add_creature, key_of, pose_asked, shown
from window import Window

MOVES = 40


def test_a_handle_is_dragged_by_the_real_mouse(ui: Window) -> Iterator[None]:
    add_creature()
    yield from ui.frame_all()
    with ui.context():
        bpy.ops.wm.tool_set_by_id(name="tug.drag")
    ui.undo_base()
    yield
    before = shown(NAME)
    x, y = map(round, ui.pixels_of(bpy.data.objects["Tail"].matrix_world.translation))
    y = ui.window.height - 1 - y  # from the top
    bpy.app.use_event_simulate = False
    moves = [f"mousemove {x + n} {y - n}" for n in range(1, MOVES + 1)]
    yield from xdotool(ui, f"mousemove {x} {y}", "sleep 0.2", "mousedown 1", "sleep 0.2")
    yield from xdotool(ui, *moves)
    yield from xdotool(ui, "sleep 0.2", "mouseup 1")
    after = shown(NAME)
    assert np.abs(after - before).max() > 0.05
    np.testing.assert_array_equal(key_of(NAME), pose_asked(NAME))
    yield from xdotool(ui, "key ctrl+z")
    np.testing.assert_array_equal(shown(NAME), before)
    yield from xdotool(ui, "key ctrl+shift+z")
    np.testing.assert_array_equal(shown(NAME), after)


def xdotool(ui: Window, *commands: str) -> Iterator[float]:
    """Let it play while Blender goes on."""
    words = [word for command in commands for word in command.split()]
    process = subprocess.Popen(["xdotool", *words])
    yield from ui.wait_until(lambda: process.poll() is not None)
    assert process.returncode == 0
    for _ in range(10):
        yield 0.05
