# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses are reset, copied, mirrored, keyed, saved and baked by operators."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import (
    AROUND,
    HANDLES,
    LENGTH,
    add_rig,
    add_tube,
    assert_close,
    bound_rig,
    evaluated,
    expected,
    key,
    pull_to,
    read_pc2,
    tube,
)

from addon.rigging import inputs, rig
from addon.ui import pose_operators


@pytest.fixture(autouse=True)
def nothing_copied():
    pose_operators._copied.clear()


def activate(obj):
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def paired_rig():
    """A rig with handles at both sides of the plane x = 0, bound."""
    obj = add_tube()
    for name, vertex in (("Root", 0), ("Arm.L", 8 * AROUND), ("Tip", 15 * AROUND)):
        rig.add_handle(obj, vertex, name)
    rig.add_handle(obj, 8 * AROUND + AROUND // 2, "Arm.R")
    rig.bind(obj)
    return activate(obj)


def place(name):
    return np.array(bpy.data.objects[name].location)


def test_a_pose_is_taken_from_a_key_and_reset():
    obj = activate(bound_rig())
    obj.location = (1, 2, 3)
    bpy.context.view_layer.update()
    bpy.ops.tug.pose_from_key(key="Bend")
    bpy.context.view_layer.update()
    np.testing.assert_allclose(
        evaluated(obj), np.array([p.co for p in key(obj, "Bend").points]), atol=2e-3 * LENGTH
    )
    bpy.ops.tug.reset_pose()
    bpy.context.view_layer.update()
    np.testing.assert_allclose(evaluated(obj), tube()[0], atol=1e-4)
    np.testing.assert_allclose(place("Tip"), tube()[0][HANDLES["Tip"]] + [1, 2, 3], atol=1e-6)


def test_a_handle_below_a_parent_is_put_where_it_belongs():
    obj = activate(bound_rig())
    parent = bpy.data.objects.new("Parent", None)
    parent.location, parent.scale = (3, 0, 0), (2, 2, 2)
    bpy.context.scene.collection.objects.link(parent)
    bpy.data.objects["Tip"].parent = parent
    bpy.context.view_layer.update()
    bpy.ops.tug.reset_pose()
    bpy.context.view_layer.update()
    found = bpy.data.objects["Tip"].matrix_world.translation
    np.testing.assert_allclose(found, tube()[0][HANDLES["Tip"]], atol=1e-5)
    assert_close(evaluated(obj), expected(obj))


def test_a_pose_is_copied_and_pasted_on_another_mesh():
    first = activate(bound_rig())
    pull_to(first, "Bend")
    before = evaluated(first)
    bpy.ops.tug.copy_pose()
    bpy.ops.tug.reset_pose()
    bpy.ops.tug.paste_pose()
    bpy.context.view_layer.update()
    assert_close(evaluated(first), before)


def test_a_pose_of_other_handles_is_refused():
    activate(bound_rig())
    bpy.ops.tug.copy_pose()
    activate(bound_rig("Other", "other "))
    with pytest.raises(RuntimeError, match='no handle of "Other": their names are Root, Middle'):
        bpy.ops.tug.paste_pose()


def test_a_pose_is_mirrored():
    paired_rig()
    bpy.data.objects["Arm.L"].location += Vector((0.4, 0.1, 0.2))
    bpy.data.objects["Tip"].location += Vector((0.3, 0.0, 0.1))
    rest = tube()[0]
    bpy.context.view_layer.update()
    bpy.ops.tug.mirror_pose()
    right = 8 * AROUND + AROUND // 2
    np.testing.assert_allclose(place("Arm.L"), rest[8 * AROUND], atol=1e-5)
    np.testing.assert_allclose(place("Arm.R"), rest[right] + [-0.4, 0.1, 0.2], atol=1e-5)
    np.testing.assert_allclose(place("Tip"), rest[15 * AROUND] + [-0.3, 0, 0.1], atol=1e-5)
    bpy.ops.tug.copy_pose()
    bpy.ops.tug.reset_pose()
    bpy.ops.tug.paste_pose(flipped=True)
    np.testing.assert_allclose(place("Arm.L"), rest[8 * AROUND] + [0.4, 0.1, 0.2], atol=1e-5)


def keys_of(name):
    """How often an object is keyed."""
    data = bpy.data.objects[name].animation_data
    if data is None or data.action is None:
        return 0
    return int(data.action.frame_range[1] - data.action.frame_range[0]) + 1


def test_all_handles_are_keyed():
    activate(bound_rig())
    bpy.context.scene.frame_set(1)
    bpy.ops.tug.keyframe_handles()
    bpy.data.objects["Tip"].location.z += 1
    bpy.context.scene.frame_set(3)
    bpy.ops.tug.pose_from_key(key="Bend")
    assert keys_of("Tip") == 1
    bpy.ops.tug.keyframe_handles()
    assert keys_of("Tip") == 3
    bpy.context.scene.frame_set(1)
    np.testing.assert_allclose(place("Tip"), tube()[0][HANDLES["Tip"]], atol=1e-6)


def test_a_pose_is_keyed_where_auto_keying_is_on():
    activate(bound_rig())
    bpy.ops.tug.pose_from_key(key="Bend")
    assert keys_of("Tip") == 0
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    bpy.context.preferences.edit.use_keyframe_insert_available = False
    try:
        bpy.ops.tug.reset_pose()
    finally:
        bpy.context.scene.tool_settings.use_keyframe_insert_auto = False
    assert keys_of("Tip") == 1


def test_a_pose_becomes_an_example():
    obj = activate(bound_rig())
    bpy.data.objects["Tip"].location += Vector((1.5, 0.5, -1.0))
    bpy.context.view_layer.update()
    before = evaluated(obj)
    bpy.ops.tug.save_pose(key_name="Twist")
    assert "Twist" in inputs.bound_examples(obj)
    assert key(obj, "Twist").mute
    bpy.ops.tug.reset_pose()
    bpy.ops.tug.pose_from_key(key="Twist")
    bpy.context.view_layer.update()
    # To a hundredth of how far it is from rest: an example is met but for the prior.
    assert np.abs(evaluated(obj) - before).max() < 1e-2 * np.abs(before - tube()[0]).max()


def test_a_pose_is_saved_for_later():
    obj = activate(bound_rig())
    bpy.ops.tug.save_pose(key_name="Later", use=False)
    assert key(obj, "Later").value == 0
    assert "Later" not in inputs.ticked(obj)
    rig.bind(obj)
    assert "Later" not in inputs.bound_examples(obj)


def test_examples_are_ticked_for_the_next_bind():
    obj = activate(bound_rig())
    bpy.ops.tug.tick_example(key="Swell")
    assert "Swell" in inputs.bound_examples(obj)
    assert inputs.ticked(obj) == ["Basis", "Bend", "Unbend"]
    bpy.ops.tug.bind()
    assert inputs.bound_examples(obj) == ["Basis", "Bend", "Unbend"]
    bpy.ops.tug.tick_example(key="Swell")
    assert "Swell" in inputs.ticked(obj)


def test_a_rig_that_is_not_live_is_posed_on_demand():
    obj = activate(bound_rig())
    obj.tug.live = False
    bpy.data.objects["Tip"].location.z += 0.5
    bpy.context.view_layer.update()
    bpy.ops.tug.update_pose()
    assert_close(evaluated(obj), expected(obj))


def test_animation_is_baked_and_the_bake_removed(tmp_path):
    obj = activate(bound_rig())
    for frame, name in ((1, "Basis"), (4, "Bend")):
        pull_to(obj, name)
        bpy.context.scene.frame_current = frame
        bpy.ops.tug.keyframe_handles()
    path = tmp_path / "tube.pc2"
    bpy.ops.tug.bake(filepath=str(path), first=1, last=4)
    first, frames = read_pc2(path)
    assert (first, len(frames)) == (1, 4)
    assert "Tug Bake" in obj.modifiers
    bpy.ops.tug.remove_bake()
    assert "Tug Bake" not in obj.modifiers
    assert path.exists()


def test_a_key_that_is_gone_is_named():
    obj = activate(add_rig())
    with pytest.raises(TypeError, match="Gone"):
        bpy.ops.tug.pose_from_key(key="Gone")
    assert obj.tug.handles
