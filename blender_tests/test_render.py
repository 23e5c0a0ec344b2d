# SPDX-License-Identifier: GPL-3.0-or-later
"""Live rigs in renders without a window, in each of Blender's engines."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import HANDLES, animate, bound_rig, expected, key

from addon import bake, handlers
from addon.rigging import rig, shape_keys

EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
ENGINES = ("CYCLES", "BLENDER_WORKBENCH", EEVEE)
FRAMES = (2, 4)
SIZE = 32
LAST = 5  # frame of the motion, which is fast enough to blur


def set_up(engine):
    """An animated rig, and a camera that sees all of it."""
    if engine != "CYCLES" and not bpy.app.binary_path:
        pytest.skip("not run: Blender as a module has no graphics here")
    obj = bound_rig()
    animate(obj, LAST)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 8
    camera.location, camera.rotation_euler = (1, -10, 2), (np.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera, scene.render.engine = camera, engine
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.5, 0.5, 0.5)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format = "PNG"
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.eevee.taa_render_samples = 1
    return obj


def rendered(folder, name):
    """The pictures of the frames, #FRAMES by rows by columns by 4."""
    scene, pictures = bpy.context.scene, []
    for frame in FRAMES:
        scene.frame_start = scene.frame_end = frame
        scene.render.filepath = str(folder / f"{name}-")
        bpy.ops.render.render(animation=True)
        image = bpy.data.images.load(str(folder / f"{name}-{frame:04}.png"))
        pictures.append(np.array(image.pixels).reshape(SIZE, SIZE, 4))
    return np.array(pictures)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_live_rig_renders_as_its_bake(engine, tmp_path):
    obj = set_up(engine)
    posed = rendered(tmp_path, "live")
    assert len(np.unique(posed[0])) > 3, "nothing is seen"
    assert (posed[0] != posed[1]).any(), "nothing moves"
    bake.bake(obj, FRAMES[0], FRAMES[-1], tmp_path / "tube.pc2")
    np.testing.assert_array_equal(posed, rendered(tmp_path, "baked"))


@pytest.mark.parametrize("engine", ("CYCLES", EEVEE))
def test_motion_blur_sees_the_poses_between_frames(engine, tmp_path):
    obj = set_up(engine)
    sharp = rendered(tmp_path, "sharp")
    render = bpy.context.scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, 1.0
    seen, right = {}, []

    def record(scene, depsgraph):
        shown = shape_keys.coordinates(key(obj, "Tug"))
        right.append(np.array_equal(shown, rig.positions(obj, depsgraph).astype(np.float32)))
        seen[scene.frame_current_final] = shown[HANDLES["Tip"]].copy()

    bpy.app.handlers.frame_change_post.append(record)
    try:
        blurred = rendered(tmp_path, "blurred")
    finally:
        bpy.app.handlers.frame_change_post.remove(record)
    between = [frame for frame in seen if frame != int(frame)]
    assert all(right)
    assert between, "no frames between frames were asked for"
    assert len({tuple(place) for place in seen.values()}) == len(seen)
    assert (blurred != sharp).any()


def test_after_a_render_the_viewport_shows_its_own_frame(tmp_path):
    obj = set_up("CYCLES")
    bpy.context.scene.frame_set(1)
    before = shape_keys.coordinates(key(obj, "Tug"))
    rendered(tmp_path, "live")
    bpy.context.scene.frame_set(1)
    np.testing.assert_array_equal(shape_keys.coordinates(key(obj, "Tug")), before)
    obj.tug.handles["Tip"].empty.location += Vector((0.1, 0, 0))
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(
        shape_keys.coordinates(key(obj, "Tug")), expected(obj).astype(np.float32)
    )


def test_while_it_renders_nothing_is_posed_for_the_viewport(tmp_path):
    """Which a window would do on another thread."""
    obj = set_up("CYCLES")
    tip = bpy.data.objects["Tip"]
    tip.animation_data_clear()
    seen = []

    def move(_scene):
        before = shape_keys.coordinates(key(obj, "Tug"))
        tip.location += Vector((0.1, 0, 0))
        bpy.context.view_layer.update()
        seen.append(np.array_equal(shape_keys.coordinates(key(obj, "Tug")), before))

    bpy.app.handlers.render_pre.append(move)
    try:
        rendered(tmp_path, "live")
    finally:
        bpy.app.handlers.render_pre.remove(move)
    assert seen == [True] * len(FRAMES)


def test_a_render_tells_of_live_rigs_in_a_window_only(tmp_path, monkeypatch):
    obj = set_up("CYCLES")
    scene = bpy.context.scene
    assert handlers.render_risk(scene) == ""
    monkeypatch.setattr(handlers.bpy, "app", Windowed())
    assert handlers.render_risk(scene).startswith("Tube would be posed while rendering: bake first")
    scene.render.use_lock_interface = True
    assert handlers.render_risk(scene) == ""
    scene.render.use_lock_interface = False
    bake.bake(obj, 1, 2, Path(tmp_path) / "tube.pc2")
    assert handlers.render_risk(scene) == ""


class Windowed:
    """What bpy.app says with a window."""

    background = False

    def __getattr__(self, name):
        return getattr(APP, name)


APP = bpy.app
