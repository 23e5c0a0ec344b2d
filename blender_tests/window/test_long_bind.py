# SPDX-License-Identifier: GPL-3.0-or-later
"""While a large mesh is bound the window answers, and Esc ends it.

The times go to long_bind.json beside the pictures, for `make bench`. They say little on a busy
machine, so the tests ask for far less.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from unittest import mock

import bpy
import numpy as np
from support import add_keys, add_mesh, state
from window import Window

from addon.rigging import rig

NAME = "Sheet"
SIDE = 317  # vertices along a side: 100,000 in all
HANDLES = 10
TICK = 0.01  # seconds
LONGEST = 20.0  # seconds, of one silence and from Esc to the end


def test_the_window_answers_during_a_long_bind(ui: Window) -> Iterator[None]:
    add_sheet()
    yield from ui.frame_all()
    drawing = Ticks()
    for _ in range(5):
        ui.area.tag_redraw()
        yield
    drawing.stop()
    ticks = Ticks()
    with timed(rig, "plan_bind", "finish_bind") as held:
        start_bind(ui)
        yield from ui.wait_until(lambda: bpy.data.objects[NAME].tug.bound, 100.0)
    ticks.stop()
    keep(
        ui,
        vertices=SIDE * SIDE,
        bind_seconds=ticks.seconds(),
        longest_silence=max(ticks.silences()),
        longest_held=max(held),
        silence_of_drawing=max(drawing.silences()),
    )
    assert len(ticks.times) > 5
    assert max(ticks.silences()) < LONGEST


def test_esc_ends_a_long_bind(ui: Window) -> Iterator[None]:
    add_sheet()
    yield from ui.frame_all()
    before = state(bpy.data.objects[NAME])
    start_bind(ui)
    yield 0.3
    pressed = time.monotonic()
    ui.tap("ESC")
    yield from ui.wait_until(lambda: not running())
    seconds = time.monotonic() - pressed
    keep(ui, esc_seconds=seconds)
    assert state(bpy.data.objects[NAME]) == before
    assert seconds < LONGEST


class Ticks:
    """When a timer of Blender's was called."""

    def __init__(self) -> None:
        self.times = [time.monotonic()]
        self.running = True
        bpy.app.timers.register(self._tick)

    def _tick(self) -> float | None:
        if not self.running:
            return None
        self.times.append(time.monotonic())
        return TICK

    def stop(self) -> None:
        self.times.append(time.monotonic())
        self.running = False

    def seconds(self) -> float:
        return self.times[-1] - self.times[0]

    def silences(self) -> np.ndarray:
        return np.diff(self.times)


@contextmanager
def timed(module: ModuleType, *names: str) -> Iterator[list[float]]:
    """The seconds of every call of these functions."""
    seconds: list[float] = []

    def watched(function: Callable) -> Callable:
        def call(*arguments: object) -> object:
            start = time.monotonic()
            try:
                return function(*arguments)
            finally:
                seconds.append(time.monotonic() - start)

        return call

    with ExitStack() as stack:
        for name in names:
            call = watched(getattr(module, name))
            stack.enter_context(mock.patch.object(module, name, call))
        yield seconds


def running() -> bool:
    """Whether a bind goes on in the window."""
    return any(
        op.bl_idname == "TUG_OT_bind"
        for op in bpy.context.window_manager.windows[0].modal_operators
    )


def start_bind(ui: Window) -> None:
    obj = bpy.data.objects[NAME]
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    with ui.context():
        bpy.ops.tug.bind("INVOKE_DEFAULT")


def add_sheet() -> None:
    """A square sheet with two shape keys and handles all over."""
    u, v = np.meshgrid(np.linspace(0, 4, SIDE), np.linspace(0, 4, SIDE), indexing="ij")
    flat = np.stack([u, v, 0 * u], axis=-1).reshape(-1, 3)
    wave = flat + [0, 0, 0.5] * np.sin(2 * flat[:, :1])
    bowl = flat + [0, 0, 0.1] * ((flat[:, :2] - 2) ** 2).sum(axis=1, keepdims=True)
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    corners = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    obj = add_mesh(NAME, flat, np.stack(corners, axis=-1).reshape(-1, 4).tolist())
    add_keys(obj, wave, bowl)
    for n, vertex in enumerate(np.linspace(0, len(flat) - 1, HANDLES, dtype=int)):
        rig.add_handle(obj, int(vertex), f"Handle {n}")


def keep(ui: Window, **measured: float) -> None:
    path = ui.pictures / "long_bind.json"
    known = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(json.dumps(known | measured))
