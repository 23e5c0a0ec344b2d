# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs that change after the bind, are copied, saved, undone."""

import threading
from itertools import pairwise

import bpy
import numpy as np
import pytest
from support import (
    HANDLES,
    add_rig,
    bound_rig,
    delete_vertices,
    depsgraph,
    evaluated,
    expected,
    in_mode,
    key,
    pull_between,
    pull_to,
    solved,
    tube,
)

from addon.rigging import inputs, live, rig, vertex_groups
from addon.rigging.inputs import RigError


def test_a_new_handle_needs_a_bind_which_computes_new_weights():
    obj = bound_rig(dictionary="HANDLES")
    rig.add_handle(obj, 40, "Fourth")
    with pytest.raises(RigError, match='its handle "Fourth" is new: bind it again'):
        rig.solve(obj, depsgraph())
    summary = rig.bind(obj)
    assert summary.weights_computed
    assert summary.handles == 4
    np.testing.assert_allclose(vertex_groups.read(obj, ["Fourth"])[40], 1, atol=1e-6)


def test_a_bind_goes_on_without_a_deleted_handle():
    obj = add_rig()
    rig.add_handle(obj, 40, "Fourth")
    rig.bind(obj)
    bpy.data.objects.remove(bpy.data.objects["Middle"])
    summary = rig.bind(obj)
    assert summary.weights_computed
    assert [handle.name for handle in obj.tug.handles] == ["Root", "Tip", "Fourth"]


def test_a_deleted_handle_takes_its_weights_along():
    obj = add_rig(dictionary="HANDLES")
    rig.add_handle(obj, 40, "Fourth")
    rig.bind(obj)
    bpy.data.objects.remove(bpy.data.objects["Middle"])
    rig.add_handle(obj, 95, "Middle")
    assert rig.bind(obj).weights_computed
    assert sorted(group.name for group in obj.vertex_groups) == ["Fourth", "Middle", "Root", "Tip"]
    weights = vertex_groups.read(obj, ["Middle"])[:, 0]
    assert weights.argmax() == 95


def test_a_handle_put_on_another_vertex_gets_new_weights():
    obj = bound_rig(dictionary="HANDLES")
    obj.tug.handles["Middle"].vertex = 95
    assert rig.bind(obj).weights_computed
    assert vertex_groups.read(obj, ["Middle"])[:, 0].argmax() == 95


def test_a_renamed_handle_keeps_its_weights():
    obj = bound_rig(dictionary="HANDLES")
    bpy.data.objects["Middle"].name = "Belly"
    rig.solve(obj, depsgraph())
    assert not rig.bind(obj).weights_computed


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("group_count", 3),
        ("steadiness", 1.0),
        ("selectivity", 3.0),
        ("squared", True),
        ("single_blend", True),
        ("form", "PAPER"),
        ("form", "NO_ROTATIONS"),
    ],
)
def test_a_setting_applies_without_a_bind(setting, value):
    obj = bound_rig(dictionary="HANDLES")
    pull_between(obj)
    before = solved(obj)
    setattr(obj.tug, setting, value)
    assert np.abs(solved(obj) - before).max() > 1e-3


def add_stiffness(obj):
    """The lower half of the tube in a group of its own."""
    group = obj.vertex_groups.new(name="Bone")
    group.add(range(len(obj.data.vertices) // 2), 1.0, "REPLACE")
    obj.tug.stiffness_group = "Bone"
    return group


def test_stiffness_is_read_from_its_group():
    obj = add_rig()
    assert set(inputs.gather(obj, ["Basis"], obj.tug.handles).stiffness) == {1}
    add_stiffness(obj)
    obj.tug.stiffness_max = 5
    stiffness = inputs.gather(obj, ["Basis"], obj.tug.handles).stiffness
    # Between the halves a triangle has one or two corners in the group.
    assert sorted(set(stiffness.round(6))) == [1, 2.333333, 3.666667, 5]


def test_stiffness_applies_without_a_bind():
    obj = bound_rig()
    pull_between(obj)
    poses = [solved(obj)]
    group = add_stiffness(obj)
    poses.append(solved(obj))
    obj.tug.stiffness_max = 50
    poses.append(solved(obj))
    group.add(range(len(obj.data.vertices)), 0.5, "REPLACE")
    live.touch(obj)
    poses.append(solved(obj))
    for before, after in pairwise(poses):
        assert np.abs(after - before).max() > 1e-4


def test_a_stiffness_group_that_is_gone_is_named():
    obj = bound_rig()
    obj.vertex_groups.remove(add_stiffness(obj))
    with pytest.raises(RigError, match='no vertex group "Bone" to take its stiffness from'):
        rig.solve(obj, depsgraph())
    with pytest.raises(RigError, match='no vertex group "Bone"'):
        rig.bind(obj)
    obj.tug.stiffness_group = ""
    rig.solve(obj, depsgraph())


def test_a_sculpted_example_changes_the_pose():
    obj = bound_rig()
    pull_to(obj, "Swell")
    before = solved(obj)
    with in_mode(obj, "SCULPT"):
        key(obj, "Swell").points[50].co.x += 0.3
        bpy.context.view_layer.update()
    assert np.abs(solved(obj) - before).max() > 0.1


def test_handles_are_found_again_after_an_edit_of_the_mesh():
    obj = bound_rig()
    delete_vertices(obj, 1, 2, 90)
    with pytest.raises(RigError, match="number of vertices went from 160 to 157: bind it again"):
        rig.solve(obj, depsgraph())
    rig.bind(obj)
    tip = obj.tug.handles["Tip"]
    assert tip.vertex == HANDLES["Tip"] - 3
    np.testing.assert_allclose(tip.rest, tube()[0][HANDLES["Tip"]], atol=1e-6)


def test_a_handle_whose_vertex_is_gone_is_named():
    obj = bound_rig()
    with in_mode(obj, "EDIT"):
        bpy.ops.mesh.select_all(action="DESELECT")
    obj.data.vertices[HANDLES["Middle"]].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")
    with pytest.raises(RigError, match='vertex of the handle "Middle" is no longer there'):
        rig.bind(obj)


# Scenes and files ------------------------------------------------------------------------------


def test_several_rigs_do_not_mix():
    first, second = bound_rig("First", "first "), bound_rig("Second", "second ")
    rest = solved(second)
    pull_to(first, "Bend")
    moved = solved(first)
    np.testing.assert_array_equal(solved(second), rest)
    pull_to(second, "Bend")
    np.testing.assert_array_equal(solved(second), moved)


def test_a_copy_is_a_rig_of_its_own():
    obj = bound_rig()
    copy = obj.copy()
    copy.data = obj.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    pull_between(obj)
    np.testing.assert_array_equal(solved(copy), solved(obj))
    copy.tug.squared = True
    assert np.abs(solved(copy) - solved(obj)).max() > 0


def test_a_saved_file_gives_the_same_pose(tmp_path):
    obj = bound_rig()
    pull_between(obj)
    before = solved(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    loaded = bpy.data.objects["Tube"]
    np.testing.assert_array_equal(evaluated(loaded), before)
    np.testing.assert_array_equal(solved(loaded), before)


def test_undo_brings_back_the_pose_and_the_solver_that_gave_it():
    obj = bound_rig()
    bpy.ops.ed.undo_push(message="bound")
    before = solved(obj)
    bpy.ops.ed.undo_push(message="solved")
    for group in obj.vertex_groups:
        group.add([80, 81, 82], 0.5, "REPLACE")
    live.touch(obj)
    bpy.data.objects["Middle"].location.x += 1
    assert np.abs(solved(obj) - before).max() > 0.1
    bpy.ops.ed.undo_push(message="painted and moved")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    np.testing.assert_array_equal(evaluated(obj), before)
    np.testing.assert_array_equal(solved(obj), before)


def test_undoing_the_bind_leaves_an_unbound_rig():
    obj = add_rig()
    bpy.ops.ed.undo_push(message="rigged")
    rig.bind(obj)
    bpy.ops.ed.undo_push(message="bound")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert not obj.tug.bound
    assert "Tug" not in obj.data.shape_keys.key_blocks
    with pytest.raises(RigError, match="is not bound"):
        rig.solve(obj, depsgraph())
    assert rig.bind(obj).weights_computed


def test_threads_that_ask_for_poses_do_not_disturb_each_other():
    obj = bound_rig()
    pull_between(obj)
    wanted, graph, found = expected(obj), depsgraph(), []

    def ask():
        found.extend(rig.positions(obj, graph) for _ in range(20))

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 80
    assert all(np.array_equal(pose, wanted) for pose in found)
