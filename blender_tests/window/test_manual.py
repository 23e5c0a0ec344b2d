# SPDX-License-Identifier: GPL-3.0-or-later
"""What the manual shows: each test plays a part of it and takes its pictures, named manual_*.

`make screenshots` puts them into docs/manual.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from scenes import key_of
from window import Window

FOX = "Fox"
PACKAGE = Path(__file__).resolve().parents[2] / "build" / "package"


def test_from_installing_to_the_first_drag_in_six_clicks(ui: Window) -> Iterator[None]:
    bpy.ops.wm.read_homefile(use_factory_startup=True)  # with its cube
    yield 0.2
    pictures = []

    def picture() -> None:
        pictures.append(ui.picture(f"first_{len(pictures) + 1}", ring=True))

    clicks = 1  # on OK; here it is installed already
    yield from drop_zip(ui)
    ui.move(ui.pointer[0] - 61, ui.pointer[1] - 92)
    yield 0.1
    picture()
    ui.tap("ESC")
    yield 0.2
    yield from open_panel(ui)
    clicks += 1
    picture()
    for operator in ("open_sample", "bind"):
        yield from ui.find_button(f"bpy.ops.tug.{operator}")
        picture()
        ui.tap("LEFTMOUSE")
        yield 0.5
        clicks += 1
    yield from ui.wait_until(lambda: bpy.data.objects[FOX].tug.bound)
    before = key_of(FOX)
    ui.point_at(bpy.data.objects["Head"])
    yield 0.2
    picture()
    ui.press("LEFTMOUSE")
    clicks += 1
    yield from ui.travel(-20, 70)
    yield 0.2
    picture()
    ui.release("LEFTMOUSE")
    yield
    assert np.abs(key_of(FOX) - before).max() > 0.1
    assert clicks <= 6
    ui.strip("manual_first_drag", pictures, columns=3)


def test_the_tutorial(ui: Window) -> Iterator[None]:
    yield from open_panel(ui)
    with ui.context():
        bpy.ops.tug.open_sample()
    yield 0.2
    with ui.context():
        bpy.ops.tug.bind("INVOKE_DEFAULT")
    yield from ui.wait_until(lambda: bpy.data.objects[FOX].tug.bound)
    yield from ui.frame_all()
    ui.picture("manual_panel", only=ui.side("UI"))
    for name, dx, dy in (("Tail", -60, 30), ("Front Paw.L", -90, 70)):
        ui.point_at(bpy.data.objects[name])
        yield 0.1
        yield from ui.drag(dx, dy)
    ui.point_at_view()
    yield 0.1
    ui.picture("manual_pose")

    bpy.context.window_manager.tug_colours = "EXAMPLES"
    ui.area.tag_redraw()
    yield 0.3
    ui.picture("manual_colours")
    bpy.context.window_manager.tug_colours = "NONE"

    scene = bpy.context.scene
    scene.frame_end = 40
    for frame, key in ((1, "Sitting"), (20, "Pouncing"), (40, "Sitting")):
        scene.frame_set(frame)
        with ui.context():
            bpy.ops.tug.pose_from_key(key=key)
            bpy.ops.tug.keyframe_handles()
        yield 0.1
    scene.frame_set(11)
    for handle in bpy.data.objects[FOX].tug.handles:
        handle.empty.select_set(True)
    yield 0.3
    ui.picture("manual_animation")
    between = key_of(FOX)
    scene.frame_set(20)
    assert np.abs(key_of(FOX) - between).max() > 0.1


def drop_zip(ui: Window) -> Iterator[float]:
    """As if the zip had been dropped on the window, with the pointer on OK."""
    ui.point_at_view()
    yield 0.2
    (file,) = PACKAGE.glob("*.zip")
    with ui.context():
        bpy.ops.extensions.package_install_files("INVOKE_DEFAULT", url=str(file))
    yield 0.5


def open_panel(ui: Window) -> Iterator[float]:
    ui.point_at_view()
    ui.tap("N")
    yield 0.2
    yield from ui.open_tab("Tug")
    yield 0.2
