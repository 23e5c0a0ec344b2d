# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles move by whatever moves an object in Blender."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import (
    HANDLES,
    add_armature,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    expected,
    pull_between,
)

from addon.rigging import rig

AWAY = Vector((0.3, -0.2, 0.4))


def add_empty(name, location=(0, 0, 0)):
    empty = bpy.data.objects.new(name, None)
    empty.location = location
    bpy.context.scene.collection.objects.link(empty)
    return empty


def parented(tip):
    tip.parent = add_empty("Parent", AWAY)


def constrained(tip):
    goal = add_empty("Goal", tip.location + AWAY)
    tip.constraints.new("COPY_LOCATION").target = goal


def keyed(tip):
    tip.keyframe_insert("location", frame=1)
    tip.location += AWAY
    tip.keyframe_insert("location", frame=5)
    bpy.context.scene.frame_set(5)


def driven(tip):
    source = add_empty("Source", AWAY)
    for axis, name in enumerate(("LOC_X", "LOC_Y", "LOC_Z")):
        driver = tip.driver_add("delta_location", axis).driver
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        variable.targets[0].id = source
        variable.targets[0].transform_type = name
        driver.expression = variable.name


def on_a_bone(tip):
    obj = add_armature(Bone=(tip.location, tip.location + AWAY))
    constraint = tip.constraints.new("COPY_LOCATION")
    constraint.target, constraint.subtarget, constraint.head_tail = obj, "Bone", 1.0


@pytest.mark.parametrize("moved", [parented, constrained, keyed, driven, on_a_bone])
def test_a_handle_moves_by(moved):
    obj = bound_rig()
    rest = evaluated(obj)[HANDLES["Tip"]]
    moved(bpy.data.objects["Tip"])
    bpy.context.view_layer.update()
    rig.solve(obj, depsgraph())
    np.testing.assert_allclose(evaluated(obj)[HANDLES["Tip"]], rest + AWAY, atol=1e-5)


def hidden(tip):
    tip.hide_set(True)


def disabled(tip):
    tip.hide_viewport = True


def disabled_in_renders(tip):
    tip.hide_render = True


def excluded(tip):
    layers = bpy.context.view_layer.layer_collection.children
    layers[tip.users_collection[0].name].exclude = True


@pytest.mark.parametrize("how", [hidden, disabled, disabled_in_renders, excluded])
@pytest.mark.parametrize("mode", ["VIEWPORT", "RENDER"])
def test_a_handle_that_cannot_be_seen_is_read_all_the_same(how, mode):
    obj = bound_rig()
    tip = bpy.data.objects["Tip"]
    for frame, offset in ((1, 0.0), (11, 1.0)):
        tip.location.z += offset
        tip.keyframe_insert("location", frame=frame)
    how(tip)
    heights = {}

    def record(scene, depsgraph):
        position = rig.positions(obj, depsgraph)[HANDLES["Tip"]]
        heights[depsgraph.mode] = position[2]

    scene = bpy.context.scene
    scene.frame_set(1)
    bpy.app.handlers.frame_change_post.append(record)
    try:
        if mode == "VIEWPORT":
            scene.frame_set(11)
        else:
            render(scene, frame=11)
    finally:
        bpy.app.handlers.frame_change_post.remove(record)
    assert heights[mode] == pytest.approx(5.0, abs=1e-5)


def render(scene, frame):
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.frame_start = scene.frame_end = frame
    scene.render.filepath = bpy.app.tempdir + "frame"
    bpy.ops.render.render(animation=True)


# How handles are held --------------------------------------------------------------------------


def test_a_handle_that_is_let_go_and_held_again_gives_the_poses_of_before():
    obj = bound_rig()
    pull_between(obj)
    bpy.data.objects["Middle"].location.x += 0.5
    bpy.context.view_layer.update()
    pinned, middle = evaluated(obj), obj.tug.handles["Middle"]
    poses = {}
    for hold, firmness in (("FREE", 1.0), ("SOFT", 0.1), ("SOFT", 10.0), ("PINNED", 1.0)):
        middle.hold, middle.firmness = hold, firmness
        bpy.context.view_layer.update()
        poses[hold, firmness] = evaluated(obj)
    np.testing.assert_array_equal(poses["PINNED", 1.0], pinned)
    target = np.array(bpy.data.objects["Middle"].location)
    missed = [np.linalg.norm(pose[HANDLES["Middle"]] - target) for pose in poses.values()]
    assert missed[0] > missed[1] > missed[2] > 1e-3 > missed[3]


def test_what_holds_a_handle_is_keyed_and_posed_at_each_frame():
    obj = bound_rig()
    pull_between(obj)
    bpy.data.objects["Middle"].location.x += 0.5
    middle = obj.tug.handles["Middle"]
    for frame, hold, firmness in ((1, "SOFT", 0.1), (11, "SOFT", 10.0), (12, "PINNED", 10.0)):
        middle.hold, middle.firmness = hold, firmness
        obj.keyframe_insert("tug.handles[1].hold", frame=frame)
        obj.keyframe_insert("tug.handles[1].firmness", frame=frame)
    missed = []
    for frame in (1, 6, 11, 12, 1):
        bpy.context.scene.frame_set(frame)
        assert_close(evaluated(obj), expected(obj))
        target = np.array(bpy.data.objects["Middle"].location)
        missed.append(np.linalg.norm(evaluated(obj)[HANDLES["Middle"]] - target))
    assert missed[0] > missed[1] > missed[2] > 1e-3 > missed[3]
    assert missed[0] == missed[4]
