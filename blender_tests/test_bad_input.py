# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be bound or solved: a clear error, and a scene that is as it was."""

import bpy
import numpy as np
import pytest
from support import (
    HANDLES,
    add_key,
    add_keys,
    add_mesh,
    add_rig,
    add_tube,
    bound_rig,
    depsgraph,
    in_mode,
    key,
    state,
    tube,
)

from addon.rigging import rig, shape_keys
from addon.rigging.inputs import RigError


def refused(obj, text):
    """Binding fails with `text` and changes nothing."""
    before = state(obj)
    with pytest.raises(RigError, match=text) as caught:
        rig.bind(obj)
    assert obj.name in str(caught.value)
    assert state(obj) == before


def rig_of(vertices, faces, edges=(), handles=(0, 85, 150)):
    obj = add_mesh("Mesh", vertices, faces, edges)
    add_keys(obj, np.asarray(vertices) * [1, 1, 1.5])
    for vertex in handles:
        rig.add_handle(obj, vertex, f"Handle {vertex}")
    return obj


def test_no_shape_keys():
    vertices, faces = tube()
    obj = add_mesh("Plain", vertices, faces)
    refused(obj, "has no shape keys: add Basis and the example shapes first")
    with pytest.raises(RigError, match="no shape keys"):
        rig.add_handle(obj, 0, "Handle")


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_handles(count):
    obj = add_tube()
    for vertex in range(count):
        rig.add_handle(obj, vertex, "Only")
    refused(obj, f"needs at least two handles, it has {count}")


def test_two_handles_on_the_same_vertex():
    obj = add_rig()
    rig.add_handle(obj, HANDLES["Tip"], "Again")
    refused(obj, '"Tip" and "Again" of "Tube" are on the same vertex 150')


def test_only_free_handles():
    obj = add_rig()
    for handle in obj.tug.handles:
        handle.hold = "FREE"
    refused(obj, "every handle of .* is free")


def test_a_handle_on_a_vertex_that_does_not_exist():
    obj = add_rig()
    obj.tug.handles["Tip"].vertex = 5000
    refused(obj, '"Tip" is on vertex 5000, but "Tube" has only 160 vertices')


@pytest.mark.parametrize(
    ("dictionary", "text"),
    [
        ("HANDLES", "component 1 of 2 .* has no handle"),
        ("EIGENFUNCTIONS", "the part with vertex [0-9]+ has no handle: put one on it, or switch"),
    ],
)
def test_a_part_without_a_handle(dictionary, text):
    vertices, faces = tube()
    twice = np.concatenate([vertices, vertices + [5, 0, 0]])
    more = [tuple(corner + 160 for corner in face) for face in faces]
    obj = rig_of(twice, faces + more)
    obj.tug.dictionary = dictionary
    refused(obj, text)
    obj.tug.follow_nearest = True
    assert rig.bind(obj).weights_computed


def test_a_shape_key_of_another_mesh():
    obj = add_rig()
    vertices, faces = tube()
    obj.data.clear_geometry()
    obj.data.from_pydata(vertices[:150].tolist(), [], [f for f in faces if max(f) < 150])
    obj.tug.handles["Tip"].vertex = 140
    assert len(key(obj, "Bend").points) == 160
    refused(obj, 'shape key "Basis" of "Tube" has 160 points but the mesh has 150 vertices')


@pytest.mark.parametrize("name", ["Basis", "Bend"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_coordinates_that_are_not_numbers(name, value):
    obj = add_rig()
    positions = shape_keys.coordinates(key(obj, name))
    positions[[7, 9], 1] = value
    shape_keys.write(obj.data, key(obj, name), positions)
    refused(obj, f'"{name}" of "Tube" has 2 points that are nowhere .*first at vertex 7')


def test_triangles_of_no_area():
    vertices, faces = tube()
    vertices[33] = vertices[34] = vertices[44]
    refused(rig_of(vertices, faces), "area")


def test_loose_vertices_and_edges():
    vertices, faces = tube()
    loose = np.concatenate([vertices, [[3, 0, 0], [3, 1, 0], [3, 2, 0]]])
    refused(rig_of(loose, faces, edges=[(160, 161)]), "vert")


def test_an_edge_between_vertices_of_faces_does_not_matter():
    vertices, faces = tube()
    rig.bind(rig_of(vertices, faces, edges=[(0, 80)]))


def test_a_mesh_without_faces():
    refused(rig_of([[0, 0, 0], [1, 0, 0], [2, 1, 0]], [], [(0, 1)], (0, 1)), "triangle|face")


def test_something_that_is_no_mesh():
    empty = bpy.data.objects.new("Empty", None)
    with pytest.raises(RigError, match='"Empty" is not a mesh'):
        rig.bind(empty)


def test_absolute_shape_keys():
    obj = add_rig()
    obj.data.shape_keys.use_relative = False
    refused(obj, "are absolute: switch them to Relative")


def test_edit_mode():
    obj = add_rig()
    with in_mode(obj, "EDIT"), pytest.raises(RigError, match="is in Edit Mode: leave it first"):
        rig.bind(obj)
    assert not obj.tug.bound


def test_an_object_scaled_to_nothing():
    obj = bound_rig()
    obj.scale.y = 0
    bpy.context.view_layer.update()
    with pytest.raises(RigError, match="has a scale of zero"):
        rig.solve(obj, depsgraph())


# After the bind --------------------------------------------------------------------------------


def stale(obj, text):
    """Solving fails with `text` and changes nothing."""
    bpy.context.view_layer.update()
    before = state(obj)
    with pytest.raises(RigError, match=f"{text}.*: bind it again"):
        rig.solve(obj, depsgraph())
    assert state(obj) == before


def test_a_handle_that_was_removed_from_the_file():
    obj = bound_rig()
    bpy.data.objects.remove(bpy.data.objects["Tip"])
    stale(obj, 'its handle "Tip" was deleted')


def test_a_handle_that_was_deleted_in_the_viewport():
    obj = bound_rig()
    bpy.ops.object.select_all(action="DESELECT")
    bpy.data.objects["Tip"].select_set(True)
    bpy.ops.object.delete()
    assert obj.tug.handles["Tip"].empty is not None
    stale(obj, 'its handle "Tip" was deleted')


def edit(obj, operation, *, select="SELECT", **options):
    with in_mode(obj, "EDIT"):
        bpy.ops.mesh.select_all(action=select)
        operation(**options)


def test_a_mesh_that_was_subdivided():
    obj = bound_rig()
    edit(obj, bpy.ops.mesh.subdivide)
    stale(obj, "its number of vertices went from 160 to")


def test_a_mesh_whose_faces_were_edited():
    obj = bound_rig()
    edit(obj, bpy.ops.mesh.quads_convert_to_tris)
    stale(obj, "its faces were edited")


def test_a_mesh_that_was_joined_with_another():
    obj = bound_rig()
    other = add_tube("Other")
    bpy.ops.object.select_all(action="DESELECT")
    other.select_set(True)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.join()
    stale(obj, "its number of vertices went from 160 to 320")


def test_an_example_that_was_deleted():
    obj = bound_rig()
    obj.shape_key_remove(key(obj, "Bend"))
    stale(obj, 'its shape key "Bend" was deleted or renamed')


def test_a_result_key_that_was_deleted():
    obj = bound_rig()
    obj.shape_key_remove(key(obj, "Tug"))
    stale(obj, 'its shape key "Tug" was deleted or renamed')
    rig.bind(obj)
    assert key(obj, "Tug").value == 1.0


def test_another_key_that_was_made_the_first():
    obj = bound_rig()
    obj.active_shape_key_index = 1
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.shape_key_move(type="UP")
    if obj.data.shape_keys.reference_key.name == "Basis":
        pytest.skip("not run: this Blender keeps Basis first")
    stale(obj, 'its shape key "Basis" is no longer the first')


def test_all_shape_keys_deleted():
    obj = bound_rig()
    obj.shape_key_clear()
    with pytest.raises(RigError, match="has no shape keys"):
        rig.solve(obj, depsgraph())


def test_a_vertex_group_that_was_deleted():
    obj = bound_rig(dictionary="HANDLES")
    obj.vertex_groups.remove(obj.vertex_groups["Tip"])
    stale(obj, 'its vertex group "Tip" was deleted or renamed')


def test_a_key_added_since_is_no_example_before_the_next_bind():
    obj = bound_rig()
    add_key(obj, "Later", tube()[0])
    rig.solve(obj, depsgraph())
    assert rig.bind(obj).shapes == 5
