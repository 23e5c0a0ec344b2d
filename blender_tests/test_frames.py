# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh follows its handles from frame to frame."""

import bpy
import numpy as np
from support import HANDLES, animate, assert_close, bound_rig, evaluated, expected, in_mode

from addon import bake, handlers


def test_a_change_of_frame_poses_the_mesh():
    obj = bound_rig()
    animate(obj)
    poses = []
    for frame in (1, 7, 12):
        bpy.context.scene.frame_set(frame)
        assert_close(evaluated(obj), expected(obj))
        poses.append(evaluated(obj))
    assert np.abs(poses[2] - poses[1]).max() > 0.1
    assert np.abs(poses[1] - poses[0]).max() > 0.1


def test_the_pose_of_a_frame_does_not_depend_on_the_frame_before():
    obj = bound_rig()
    animate(obj)
    bpy.context.scene.frame_set(7)
    first = evaluated(obj)
    for frame in (12, 1, 30, 7):
        bpy.context.scene.frame_set(frame)
    np.testing.assert_array_equal(evaluated(obj), first)


def test_every_rig_of_the_scene_is_posed():
    rigs = [bound_rig("First", "first "), bound_rig("Second", "second ")]
    for obj in rigs:
        animate(obj)
    bpy.context.scene.frame_set(9)
    for obj in rigs:
        assert_close(evaluated(obj), expected(obj))


def test_a_linked_duplicate_shows_the_pose_of_the_original():
    obj = bound_rig()
    animate(obj)
    copy = obj.copy()
    copy.location.x += 10
    bpy.context.scene.collection.objects.link(copy)
    bpy.context.scene.frame_set(7)
    assert_close(evaluated(obj), expected(obj))
    assert_close(evaluated(copy), expected(obj))


def test_a_rig_that_cannot_be_posed_is_told_of_once_and_leaves_others_alone(capsys):
    broken, sound = bound_rig("Broken", "broken "), bound_rig("Sound", "sound ")
    animate(sound)
    bpy.data.objects.remove(bpy.data.objects["broken Tip"])
    capsys.readouterr()
    for frame in range(2, 9):
        bpy.context.scene.frame_set(frame)
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Tug: ")]
    assert len(told) == 1
    assert '"broken Tip" was deleted: bind it again' in told[0]
    assert told[0] == f"Tug: {handlers.problem(broken)}"
    assert handlers.problem(sound) == ""
    assert_close(evaluated(sound), expected(sound))


def test_a_problem_that_was_mended_is_forgotten():
    obj = bound_rig(dictionary="HANDLES")
    obj.vertex_groups["Tip"].name = "Top"
    bpy.context.scene.frame_set(2)
    assert '"Tip" was deleted or renamed' in handlers.problem(obj)
    obj.vertex_groups["Top"].name = "Tip"
    bpy.context.scene.frame_set(3)
    assert handlers.problem(obj) == ""


def test_a_mesh_in_edit_mode_waits():
    obj = bound_rig()
    animate(obj)
    with in_mode(obj, "EDIT"):
        bpy.context.scene.frame_set(12)
    assert handlers.problem(obj) == ""
    bpy.context.scene.frame_set(12)
    assert_close(evaluated(obj), expected(obj))


def test_a_baked_rig_is_not_solved(tmp_path):
    obj = bound_rig()
    animate(obj)
    bpy.context.scene.frame_set(1)
    bake.bake(obj, 1, 12, tmp_path / "tube.pc2")
    tip = obj.data.shape_keys.key_blocks["Tug"].points[HANDLES["Tip"]]
    before = tip.co.copy()
    bpy.context.scene.frame_set(12)
    assert tip.co == before
    obj.modifiers["Tug Bake"].show_viewport = False
    bpy.context.scene.frame_set(11)
    assert tip.co != before
