# SPDX-License-Identifier: GPL-3.0-or-later
"""The driver itself: Blender takes its events as an artist's, and its picture is seen."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from window import Window


def test_an_empty_is_grabbed_and_put_back(ui: Window) -> Iterator[None]:
    bpy.ops.object.empty_add()
    bpy.context.object.name = "Handle"
    yield from ui.frame_all()
    ui.undo_base()
    yield from ui.grab("Handle", 80, 40)
    ui.tap("RET")
    yield
    moved = bpy.data.objects["Handle"].location.copy()
    assert moved.length > 0.01
    yield from ui.undo()
    assert bpy.data.objects["Handle"].location.length == 0
    yield from ui.redo()
    assert bpy.data.objects["Handle"].location == moved
    yield from ui.grab("Handle", -30, 10)
    ui.tap("ESC")
    yield
    assert bpy.data.objects["Handle"].location == moved
    ui.picture("window")
