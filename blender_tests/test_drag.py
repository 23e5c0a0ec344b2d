# SPDX-License-Identifier: GPL-3.0-or-later
"""A handle is dragged: how far the mouse pulls it, what follows, and the way back."""

from math import radians
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from support import HANDLES, add_armature, add_tube, animate, bound_rig, evaluated, expected, key

from addon import bake
from addon.rigging import live, shape_keys
from addon.rigging.inputs import RigError
from addon.ui.drag import Drag
from addon.ui.pull import PRECISION, Pull

AWAY = Vector((0.3, -0.2, 0.4))
MIDDLE = Vector((200, 150))


def drag(name="Tip", offset=AWAY):
    return bpy.ops.tug.drag(handle=name, offset=offset)


def place(name="Tip"):
    return bpy.data.objects[name].matrix_world.translation.copy()


def snapshot(obj):
    empties = [handle.empty for handle in obj.tug.handles]
    return (
        shape_keys.coordinates(key(obj, "Tug")).tolist(),
        evaluated(obj).tolist(),
        [tuple(empty.location) for empty in empties],
        [empty.select_get() for empty in empties],
        obj.tug.get(live.POSED),
    )


def test_the_mesh_follows_a_drag():
    obj = bound_rig()
    before = evaluated(obj)[HANDLES["Tip"]]
    assert drag() == {"FINISHED"}
    np.testing.assert_allclose(evaluated(obj)[HANDLES["Tip"]], before + AWAY, atol=1e-5)
    np.testing.assert_array_equal(
        shape_keys.coordinates(key(obj, "Tug")), expected(obj).astype(np.float32)
    )


def test_the_mesh_follows_a_drag_where_live_is_off():
    obj = bound_rig()
    obj.tug.live = False
    before = evaluated(obj)[HANDLES["Tip"]]
    drag()
    np.testing.assert_allclose(evaluated(obj)[HANDLES["Tip"]], before + AWAY, atol=1e-5)


def test_a_drag_is_one_step_of_undo():
    obj = bound_rig()
    bpy.ops.ed.undo_push(message="Bound")
    states = [snapshot(obj)]
    for offset in (AWAY, -2 * AWAY):
        drag(offset=offset)
        bpy.ops.ed.undo_push(message="Drag Handle")  # a script's operators push none
        states.append(snapshot(bpy.data.objects["Tube"]))
    for step, before in ((bpy.ops.ed.undo, 1), (bpy.ops.ed.undo, 0), (bpy.ops.ed.redo, 1)):
        step()
        assert snapshot(bpy.data.objects["Tube"]) == states[before]


def by_parent(tip):
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.matrix_world = Matrix.LocRotScale(AWAY, Matrix.Rotation(1.0, 3, AWAY), (2, 3, 0.5))
    tip.parent = parent


def by_parent_kept_in_place(tip):
    by_parent(tip)
    bpy.context.view_layer.update()
    tip.matrix_parent_inverse = tip.parent.matrix_world.inverted()


def by_bone(tip):
    armature = add_armature(Bone=((0, 0, 0), (1, 2, 3)))
    armature.pose.bones["Bone"].rotation_euler = (1, 2, 3)
    armature.pose.bones["Bone"].rotation_mode = "XYZ"
    tip.parent, tip.parent_type, tip.parent_bone = armature, "BONE", "Bone"


def by_nothing_but_turned(tip):
    tip.rotation_euler, tip.scale = (1, 2, 3), (2, 3, 4)
    tip.delta_location = AWAY


@pytest.mark.parametrize(
    "held", [by_parent, by_parent_kept_in_place, by_bone, by_nothing_but_turned]
)
def test_an_offset_is_in_the_world_whatever_a_handle_hangs_on(held):
    bound_rig()
    held(bpy.data.objects["Tip"])
    bpy.context.view_layer.update()
    before = place()
    drag()
    assert (place() - before - AWAY).length < 1e-5


def test_locks_hold():
    bound_rig()
    tip, before = bpy.data.objects["Tip"], place()
    tip.lock_location = (True, False, True)
    drag()
    assert (place() - before - Vector((0, AWAY.y, 0))).length < 1e-6


def test_a_drag_selects_its_handle_and_keeps_what_is_active():
    obj = bound_rig()
    bpy.context.view_layer.objects.active = obj
    bpy.data.objects["Root"].select_set(True)
    drag()
    assert [bpy.data.objects[name].select_get() for name in HANDLES] == [False, False, True]
    assert bpy.context.view_layer.objects.active == obj


@pytest.mark.parametrize("is_live", [True, False])
def test_restore_brings_back_what_no_solve_would_give(is_live):
    obj = bound_rig()
    obj.tug.live = is_live
    painted = expected(obj) + np.linspace(0, 1, 3)
    shape_keys.write(obj.data, key(obj, "Tug"), painted)
    bpy.context.view_layer.update()
    before = snapshot(obj)
    one = Drag(bpy.context, obj, bpy.data.objects["Tip"])
    one.pull(AWAY)
    assert snapshot(obj) != before
    one.restore()
    bpy.context.view_layer.update()
    assert snapshot(obj) == before


def test_a_rig_that_is_stale_says_so_and_stays_as_it_was():
    obj = bound_rig()
    obj.shape_key_remove(key(obj, "Swell"))
    before = snapshot(obj)
    with pytest.raises(RuntimeError, match="bind it again"):
        drag()
    assert snapshot(obj) == before


def test_a_rig_that_shows_its_bake_says_so(tmp_path):
    obj = bound_rig()
    animate(obj)
    bake.bake(obj, 1, 2, tmp_path / "tube.pc2")
    with pytest.raises(RuntimeError, match="shows its bake: hide the modifier"):
        drag()


def test_a_handle_of_no_bound_mesh_is_refused():
    add_tube()
    with pytest.raises(RuntimeError, match='No bound mesh has a handle "Tip"'):
        drag()


def curves(obj):
    """Path and frames of each curve of an object."""
    animation = obj.animation_data
    if animation is None or animation.action is None:
        return []
    if hasattr(animation.action, "layers") and bpy.app.version >= (5, 0):
        found = animation.action.layers[0].strips[0].channelbag(animation.action_slot).fcurves
    else:
        found = animation.action.fcurves
    return [(curve.data_path, [point.co[0] for point in curve.keyframe_points]) for curve in found]


def test_auto_keying_is_honoured():
    bound_rig()
    bpy.context.scene.frame_set(7)
    drag()
    assert curves(bpy.data.objects["Tip"]) == []
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    bpy.context.preferences.edit.use_keyframe_insert_available = False
    drag()
    assert curves(bpy.data.objects["Tip"]) == [("location", [7.0])] * 3
    assert curves(bpy.data.objects["Root"]) == []


def seen(perspective=True, turned=0.0):
    """A region, and a view of the origin from a distance of ten, along -z where not turned."""
    turn = Matrix.Rotation(turned, 4, "X") @ Matrix.Rotation(turned, 4, "Z")
    view = Matrix.Translation((0, 0, -10)) @ turn
    if perspective:
        lens = Matrix(((1.5, 0, 0, 0), (0, 2, 0, 0), (0, 0, -1.002, -0.2), (0, 0, -1, 0)))
    else:
        lens = Matrix(((0.15, 0, 0, 0), (0, 0.2, 0, 0), (0, 0, -0.01, 0), (0, 0, 0, 1)))
    region = SimpleNamespace(width=400, height=300)
    shown = SimpleNamespace(
        view_matrix=view,
        perspective_matrix=lens @ view,
        is_perspective=perspective,
        view_perspective="PERSP" if perspective else "ORTHO",
    )
    return region, shown


def pixels(region, view, point):
    x, y, _, w = view.perspective_matrix @ point.to_4d()
    return Vector((region.width * (0.5 + 0.5 * x / w), region.height * (0.5 + 0.5 * y / w)))


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("turned", [0.0, radians(40)])
def test_a_pull_stays_under_the_mouse_in_the_plane_of_the_view(perspective, turned):
    region, view = seen(perspective, turned)
    start, mouse = Vector((0.5, 0.3, 0.2)), Vector((310, 90))
    press = pixels(region, view, start)
    pull = Pull(region, view, start, press)
    pull.move(mouse, precise=False)
    assert (pixels(region, view, start + pull.offset) - mouse).length < 0.01
    assert abs(pull.offset.dot(view.view_matrix.row[2].xyz)) < 1e-4


@pytest.mark.parametrize("axis", "XYZ")
def test_a_pull_keeps_to_an_axis_or_to_the_plane_across_it(axis):
    region, view = seen(turned=radians(40))
    number = "XYZ".index(axis)
    pull = Pull(region, view, Vector((0.5, 0.3, 0.2)), MIDDLE)
    pull.move(Vector((260, 180)), precise=False)
    free = pull.offset.copy()
    pull.constrain(axis, across=False)
    assert [abs(c) > 1e-3 for c in pull.offset] == [i == number for i in range(3)]
    pull.constrain(axis, across=True)
    assert [abs(c) > 1e-3 for c in pull.offset] == [i != number for i in range(3)]
    pull.constrain(axis, across=True)
    assert pull.offset == free


def test_a_pull_along_the_line_of_sight_stays():
    region, view = seen(perspective=False)
    pull = Pull(region, view, Vector((0, 0, 0)), MIDDLE)
    pull.constrain("Z", across=False)
    pull.move(Vector((260, 180)), precise=False)
    assert pull.offset.length == 0


def test_beyond_the_horizon_a_pull_stays_where_it_was():
    region, view = seen(turned=radians(-80))
    pull = Pull(region, view, Vector((0, 0, 0)), MIDDLE)
    pull.constrain("Z", across=True)
    pull.move(Vector((200, 160)), precise=False)
    near = pull.offset.copy()
    assert near.length > 0
    pull.move(Vector((200, 300)), precise=False)
    assert pull.offset == near


def test_precision_takes_a_tenth_of_what_follows():
    region, view = seen(perspective=False)
    pull = Pull(region, view, Vector((0, 0, 0)), MIDDLE)
    pull.move(MIDDLE + Vector((50, 0)), precise=False)
    whole = pull.offset.x
    pull.move(MIDDLE + Vector((100, 0)), precise=True)
    assert pull.offset.x == pytest.approx(whole * (1 + PRECISION))


def test_a_drag_needs_a_rig_that_can_be_posed():
    obj = bound_rig()
    obj.data.shape_keys.key_blocks["Tug"].name = "Other"
    with pytest.raises(RigError, match="bind it again"):
        Drag(bpy.context, obj, bpy.data.objects["Tip"])
