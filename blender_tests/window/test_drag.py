# SPDX-License-Identifier: GPL-3.0-or-later
"""The drag tool: a handle is pulled by the mouse, and everything can be taken back."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np
from scenes import add_creature, key_of, shown
from window import Window

BODY, HANDLE = "Creature", "Tail"


def with_tool(ui: Window) -> Iterator[None]:
    """The creature, seen from the front, and the tool."""
    add_creature()
    yield from ui.frame_all()
    with ui.context():
        bpy.ops.wm.tool_set_by_id(name="tug.drag")
    yield
    ui.undo_base()


def at_handle(ui: Window) -> Iterator[None]:
    ui.point_at(bpy.data.objects[HANDLE])
    yield


def state() -> tuple[np.ndarray, np.ndarray, tuple[float, ...]]:
    return key_of(BODY), shown(BODY), tuple(bpy.data.objects[HANDLE].location)


def assert_same(now: tuple, before: tuple) -> None:
    for one, other in zip(now, before, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_drag_is_one_step_of_undo(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    states = [state()]
    for dx, dy in ((60, 40), (-30, 70)):
        yield from at_handle(ui)
        yield from ui.drag(dx, dy)
        states.append(state())
        assert np.abs(states[-1][0] - states[-2][0]).max() > 0.01
    for before in (states[1], states[0]):
        yield from ui.undo()
        assert_same(state(), before)
    for after in (states[1], states[2]):
        yield from ui.redo()
        assert_same(state(), after)
    ui.picture("drag")
