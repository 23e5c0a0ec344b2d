# SPDX-License-Identifier: GPL-3.0-or-later
"""An animation with a live rig is rendered in a window, on a thread of the render's own."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector
from scenes import add_creature, key_of
from window import Window

from addon import bake, handlers
from addon.rigging import rig

BODY, HANDLE = "Creature", "Tail"
FRAMES = 4
SIZE = 48


def animated(ui: Window) -> Iterator[None]:
    add_creature()
    empty = bpy.data.objects[HANDLE]
    for frame, offset in ((1, (0, 0, 0)), (FRAMES, (0.4, 0.3, 0.3))):
        empty.location += Vector(offset)
        empty.keyframe_insert("location", frame=frame)
    yield from ui.frame_all()
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.matrix_world = ui.view.view_matrix.inverted() @ Matrix.Translation((0, 0, 3))
    scene.collection.objects.link(camera)
    scene.camera, scene.frame_start, scene.frame_end = camera, 1, FRAMES
    scene.world = bpy.data.worlds.new("World")
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "PNG"
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 2, False
    bpy.context.preferences.view.render_display_type = "NONE"
    scene.frame_set(1)
    yield


def render(ui: Window, name: str) -> Iterator[None]:
    """As from the Render menu, while somebody goes on pulling at a handle that is not keyed."""
    scene = bpy.context.scene
    scene.render.filepath = str(ui.pictures / f"render-{name}-")
    with ui.context():
        bpy.ops.render.render("INVOKE_DEFAULT", animation=True)
    for _ in range(600):
        yield 0.05
        if not bpy.app.is_job_running("RENDER"):
            break
        bpy.data.objects["Head"].delta_rotation_euler.z += 0.01  # it matters to no pose
    assert not bpy.app.is_job_running("RENDER")
    yield 0.2


def pictures(ui: Window, name: str) -> np.ndarray:
    found = []
    for frame in range(1, FRAMES + 1):
        image = bpy.data.images.load(str(Path(ui.pictures) / f"render-{name}-{frame:04}.png"))
        found.append(np.array(image.pixels))
        bpy.data.images.remove(image)
    return np.array(found)


def test_live_rigs_render_as_their_bakes(ui: Window) -> Iterator[None]:
    """With and without a locked interface, with motion blur, and by another engine."""
    yield from animated(ui)
    scene = bpy.context.scene
    before = key_of(BODY)
    settings = {
        "locked": ("CYCLES", True, False),
        "free": ("CYCLES", False, False),
        "blurred": ("CYCLES", False, True),
        "workbench": ("BLENDER_WORKBENCH", False, False),
    }
    posed = {}
    for name, (engine, locked, blurred) in settings.items():
        scene.render.engine, scene.render.use_lock_interface = engine, locked
        scene.render.use_motion_blur = blurred
        assert bool(handlers.render_risk(scene)) != locked
        yield from render(ui, name)
        posed[name] = pictures(ui, name)
        assert (posed[name][0] != posed[name][-1]).any()
        np.testing.assert_array_equal(key_of(BODY), before)  # the frame of the viewport
    np.testing.assert_array_equal(posed["locked"], posed["free"])
    assert (posed["blurred"] != posed["free"]).any()
    bake.bake(bpy.data.objects[BODY], 1, FRAMES, ui.pictures / "creature.pc2")
    for name in ("free", "workbench"):
        scene.render.engine = settings[name][0]
        scene.render.use_motion_blur = False
        yield from render(ui, f"baked-{name}")
        np.testing.assert_array_equal(pictures(ui, f"baked-{name}"), posed[name])


def test_handles_pulled_while_it_renders_are_followed_afterwards(ui: Window) -> Iterator[None]:
    yield from animated(ui)
    with ui.context():
        bpy.ops.render.render("INVOKE_DEFAULT", animation=True)
    yield 0.02
    bpy.data.objects["Head"].location.z += 0.2
    for _ in range(600):
        yield 0.05
        if not bpy.app.is_job_running("RENDER"):
            break
    yield 0.2
    answer = rig.positions(bpy.data.objects[BODY], bpy.context.evaluated_depsgraph_get())
    np.testing.assert_array_equal(key_of(BODY), answer.astype(np.float32))


def test_the_thread_of_a_render_registers_no_timer(ui: Window) -> Iterator[None]:
    """Blender's list of timers has no lock, and its main thread walks it all the time."""
    yield from animated(ui)
    called, threads = [], []

    def note(_frame: object, event: str, function: object) -> None:
        if event == "c_call":
            called.append(function)

    def begin(*_: object) -> None:
        threads.append(threading.current_thread())
        sys.setprofile(note)

    def end(*_: object) -> None:
        sys.setprofile(None)

    ended = bpy.app.handlers.render_complete
    ended.insert(0, begin)
    ended.append(end)
    yield from render(ui, "noted")
    assert threads and threads[0] is not threading.main_thread()
    assert called and bpy.app.timers.register not in called
