# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles are added, named, mirrored, moved and deleted by operators."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import (
    AROUND,
    HANDLES,
    LENGTH,
    add_armature,
    add_key,
    add_mesh,
    add_rig,
    add_tube,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    expected,
    tube,
)

from addon.rigging import handles, rig, vertex_groups
from addon.rigging.inputs import RigError


def activate(obj):
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def names(obj):
    return [handle.title for handle in obj.tug.handles]


def select_vertices(obj, *vertices):
    """In Edit Mode, only these."""
    activate(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for vertex in vertices:
        obj.data.vertices[vertex].select = True
    bpy.ops.object.mode_set(mode="EDIT")


# Added -------------------------------------------------------------------------------------------


def test_handles_are_spread_over_the_mesh():
    obj = activate(add_tube())
    bpy.ops.tug.add_handles(count=2)
    heights = [obj.data.vertices[handle.vertex].co.z for handle in obj.tug.handles]
    assert sorted(heights) == pytest.approx([0, LENGTH])
    bpy.ops.tug.add_handles(count=1)
    assert obj.data.vertices[obj.tug.handles[2].vertex].co.z == pytest.approx(LENGTH / 2, abs=0.5)
    assert names(obj) == ["Handle 1", "Handle 2", "Handle 3"]
    assert rig.bind(obj).handles == 3


def test_loose_parts_get_their_handles_first():
    vertices, faces = tube()
    twice = np.concatenate([vertices, vertices + [5, 0, 0]])
    obj = add_mesh("Two", twice, faces + [tuple(v + 160 for v in face) for face in faces])
    for name, scale in (("Basis", 1.0), ("Long", 1.2)):
        add_key(obj, name, twice * [1, 1, scale])
    handles.add_spread(obj, 2)
    assert {handle.vertex >= 160 for handle in obj.tug.handles} == {False, True}


def test_handles_are_empties_in_a_collection_of_their_own_that_can_be_seen():
    obj = add_rig()
    collection = obj.tug.collection
    assert collection.name == "Tube Handles"
    assert {empty.name for empty in collection.objects} == set(HANDLES)
    assert all(empty.show_in_front and empty.show_name for empty in collection.objects)


def test_a_handle_on_each_selected_vertex_or_one_in_the_middle():
    obj = add_tube()
    select_vertices(obj, 3, 40, 77)
    bpy.ops.tug.add_handles_on_vertices(where="EACH")
    assert bpy.context.mode == "EDIT_MESH"
    assert [handle.vertex for handle in obj.tug.handles] == [3, 40, 77]
    bpy.ops.object.mode_set(mode="OBJECT")
    ring = range(5 * AROUND, 6 * AROUND)
    select_vertices(obj, *ring)
    bpy.ops.tug.add_handles_on_vertices(where="MIDDLE")
    assert obj.tug.handles[3].vertex in ring
    assert len(obj.tug.handles) == 4


def test_vertices_that_were_moved_in_edit_mode_get_their_handle_where_they_are():
    obj = add_tube()
    select_vertices(obj, 3)
    bpy.ops.transform.translate(value=(2, 0, 0))
    bpy.ops.tug.add_handles_on_vertices()
    x = obj.tug.handles[0].empty.location.x
    assert x == pytest.approx(tube()[0][3, 0] + 2, abs=1e-5)


def test_no_selection_and_too_large_a_one_are_refused():
    obj = add_tube()
    select_vertices(obj)
    with pytest.raises(RuntimeError, match="select vertices first"):
        bpy.ops.tug.add_handles_on_vertices()
    bpy.ops.mesh.select_all(action="SELECT")
    with pytest.raises(RuntimeError, match="160 vertices are selected: select at most 100"):
        bpy.ops.tug.add_handles_on_vertices()
    assert len(obj.tug.handles) == 0


def be_deformed(obj):
    """By an armature with one bone that does not deform."""
    names = ("Low", "High", "Control")
    armature = add_armature(
        **{name: ((0, 0, 2 * number), (0, 0, 2 * number + 2)) for number, name in enumerate(names)}
    )
    armature.data.bones["Control"].use_deform = False
    obj.modifiers.new("Armature", "ARMATURE").object = armature


def test_a_handle_for_each_deforming_bone():
    obj = add_tube()
    be_deformed(obj)
    activate(obj)
    bpy.ops.tug.add_handles_on_bones()
    assert names(obj) == ["Handle Low", "Handle High"]
    heights = [obj.data.vertices[handle.vertex].co.z for handle in obj.tug.handles]
    assert heights == pytest.approx([1, 3], abs=0.2)


def test_the_place_under_a_click_is_a_vertex_as_it_is_shown():
    obj = add_tube()
    place = Vector(tube()[0][33] + 0.01)
    assert handles.nearest_vertex(obj, place, depsgraph()) == 33
    obj.modifiers.new("Subdivision", "SUBSURF")
    bpy.context.view_layer.update()
    assert handles.nearest_vertex(obj, place, depsgraph()) == 33


# Mirrored ----------------------------------------------------------------------------------------


def test_handles_at_a_side_get_partners_and_names():
    obj = activate(add_tube())
    side = 5 * AROUND  # angle 0: x > 0
    rig.add_handle(obj, side, "Hand")
    rig.add_handle(obj, AROUND // 4 + 10 * AROUND, "Paw.L")
    bpy.ops.tug.mirror_handles()
    found = {handle.title: handle.vertex for handle in obj.tug.handles}
    assert set(found) == {"Hand.L", "Hand.R", "Paw.L", "Paw.R"}
    assert found["Hand.R"] == side + AROUND // 2
    bpy.ops.tug.mirror_handles()
    assert len(obj.tug.handles) == 4


def test_two_handles_that_face_each_other_become_a_pair():
    obj = activate(add_tube())
    rig.add_handle(obj, 5 * AROUND, "Hand")
    rig.add_handle(obj, 5 * AROUND + AROUND // 2, "Other")
    bpy.ops.tug.mirror_handles()
    assert names(obj) == ["Hand.L", "Hand.R"]


# Named, moved, deleted ---------------------------------------------------------------------------


def test_a_name_goes_to_the_empty_and_to_the_weights():
    obj = bound_rig()
    obj.tug.handles["Middle"].title = "Belly"
    assert names(obj) == ["Root", "Belly", "Tip"]
    assert "Belly" in bpy.data.objects
    rig.solve(obj, depsgraph())
    assert "Belly" in obj.tug.handles


def test_a_name_goes_to_painted_weights():
    obj = add_rig(dictionary="HANDLES")
    rig.bind(obj)
    obj.tug.handles["Middle"].title = "Belly"
    assert sorted(group.name for group in obj.vertex_groups) == ["Belly", "Root", "Tip"]
    assert not rig.bind(obj).weights_computed


def test_a_handle_that_is_renamed_in_the_outliner_is_listed_under_its_name():
    obj = bound_rig()
    bpy.data.objects["Middle"].name = "Belly"
    assert names(obj) == ["Root", "Belly", "Tip"]
    bpy.data.objects["Belly"].location.x += 1
    bpy.context.view_layer.update()
    assert_close(evaluated(obj), expected(obj))
    rig.bind(obj)
    assert "Belly" in obj.tug.handles


def test_a_handle_is_deleted_before_the_bind():
    obj = activate(add_rig())
    obj.tug.active_handle = 1
    bpy.ops.tug.delete_handle()
    assert names(obj) == ["Root", "Tip"]
    assert "Middle" not in bpy.data.objects


def test_a_deleted_handle_of_a_bound_mesh_goes_with_the_next_bind():
    obj = activate(add_rig())
    rig.add_handle(obj, 40, "Fourth")
    rig.bind(obj)
    obj.tug.active_handle = 1
    bpy.ops.tug.delete_handle()
    with pytest.raises(RigError, match='its handle "Middle" was deleted: bind it again'):
        rig.solve(obj, depsgraph())
    bpy.ops.tug.bind()
    assert names(obj) == ["Root", "Tip", "Fourth"]
    rig.solve(obj, depsgraph())


def test_a_handle_is_put_on_another_vertex():
    obj = activate(bound_rig())
    obj.tug.active_handle = 1
    select_vertices(obj, 95)
    bpy.ops.tug.put_handle()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert obj.tug.handles["Middle"].vertex == 95
    np.testing.assert_allclose(bpy.data.objects["Middle"].location, tube()[0][95], atol=1e-5)
    bpy.ops.tug.bind()
    assert obj.tug.handles["Middle"].rest_vertex == 95


def test_a_handle_is_not_put_where_another_is():
    obj = activate(add_rig())
    select_vertices(obj, HANDLES["Tip"])
    with pytest.raises(RuntimeError, match='the handle "Tip" is on that vertex already'):
        bpy.ops.tug.put_handle()


def test_handles_are_selected():
    obj = activate(add_rig())
    bpy.ops.tug.select_handles()
    assert {chosen.name for chosen in bpy.context.selected_objects} == set(HANDLES)
    bpy.ops.tug.select_handles(index=1)
    assert [chosen.name for chosen in bpy.context.selected_objects] == ["Middle"]
    assert bpy.context.object.name == "Middle"
    bpy.ops.tug.select_handles(index=2, extend=True)
    assert len(bpy.context.selected_objects) == 2
    bpy.ops.tug.bind()  # works from a handle too
    assert obj.tug.bound


# Duplicates --------------------------------------------------------------------------------------


def duplicate(*objects):
    for obj in bpy.context.scene.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]
    bpy.ops.object.duplicate()
    bpy.context.view_layer.update()
    return bpy.context.object


def test_a_duplicate_shares_its_handles_until_it_gets_its_own():
    obj = bound_rig()
    copy = duplicate(obj)
    assert handles.sharing(copy) == [obj]
    copy.location.x += 5
    bpy.ops.tug.make_handles_own()
    bpy.context.view_layer.update()
    assert not handles.sharing(copy)
    assert names(copy) == ["Root.001", "Middle.001", "Tip.001"]
    assert_close(evaluated(copy), evaluated(obj))
    bpy.data.objects["Tip.001"].location.z += 0.5
    bpy.context.view_layer.update()
    assert_close(evaluated(copy), expected(copy))
    assert np.abs(evaluated(copy) - evaluated(obj)).max() > 0.1


def test_a_mesh_that_is_duplicated_with_its_handles_has_its_own():
    obj = bound_rig()
    copy = duplicate(obj, *[handle.empty for handle in obj.tug.handles])
    copy = next(o for o in bpy.context.selected_objects if o.type == "MESH")
    assert not handles.sharing(copy)
    assert names(copy) == ["Root.001", "Middle.001", "Tip.001"]
    bpy.data.objects["Tip.001"].location.z += 0.5
    bpy.context.view_layer.update()
    assert_close(evaluated(copy), expected(copy))


def test_deleting_a_shared_handle_leaves_it_to_the_other_mesh():
    obj = bound_rig()
    copy = activate(duplicate(obj))
    copy.tug.active_handle = 1
    bpy.ops.tug.delete_handle()
    assert "Middle" in bpy.data.objects
    rig.solve(obj, depsgraph())
    with pytest.raises(RigError, match='its handle "Middle" was deleted'):
        rig.solve(copy, depsgraph())


def test_own_handles_are_refused_where_none_are_shared():
    activate(bound_rig())
    with pytest.raises(RuntimeError, match="not shared with another mesh"):
        bpy.ops.tug.make_handles_own()


def test_a_linked_duplicate_gets_handles_with_a_mesh_of_its_own():
    obj = bound_rig()
    copy = obj.copy()
    bpy.context.scene.collection.objects.link(copy)
    activate(copy)
    with pytest.raises(RuntimeError, match="make the mesh single-user first"):
        bpy.ops.tug.make_handles_own()
    copy.data = copy.data.copy()
    bpy.ops.tug.make_handles_own()
    assert not handles.sharing(copy)


def test_the_weights_of_handles_are_read_back_as_painted():
    obj = add_rig(dictionary="HANDLES")
    rig.bind(obj)
    before = vertex_groups.read(obj, ["Middle"])
    handles.rename(obj, obj.tug.handles["Middle"], "Belly")
    np.testing.assert_array_equal(vertex_groups.read(obj, ["Belly"]), before)
