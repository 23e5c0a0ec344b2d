# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles, bind and unbind, and what the result key shows."""

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector
from support import (
    HANDLES,
    LENGTH,
    add_key,
    add_keys,
    add_mesh,
    add_rig,
    add_tube,
    assert_close,
    bent,
    bound_rig,
    evaluated,
    expected,
    in_mode,
    key,
    pull_between,
    pull_to,
    solved,
    state,
    tube,
)

from addon.rigging import rig, vertex_groups
from addon.rigging.inputs import RigError

PLACED = Matrix.LocRotScale(Vector((1, 2, 3)), Euler((0.3, 0.5, 0.7)), Vector((2, 1, 0.5)))


def repaint(obj, group):
    """Paint over some of a group as an artist would: in Weight Paint mode."""
    with in_mode(obj, "WEIGHT_PAINT"):
        obj.vertex_groups[group].add(range(20, 60), 0.9, "REPLACE")
        bpy.context.view_layer.update()


# Handles ---------------------------------------------------------------------------------------


def test_a_handle_is_an_empty_on_the_vertex_as_it_is_shown():
    obj = add_tube()
    obj.matrix_world = PLACED
    bpy.context.view_layer.update()
    key(obj, "Bend").value = 0.5
    key(obj, "Swell").value = 0.25
    empty = rig.add_handle(obj, HANDLES["Middle"], "Middle")
    bpy.context.view_layer.update()
    shown = obj.matrix_world @ Vector(evaluated(obj)[HANDLES["Middle"]].tolist())
    assert empty.type == "EMPTY"
    np.testing.assert_allclose(empty.matrix_world.translation, shown, atol=1e-5)
    assert obj.tug.collection.objects[:] == [empty]


def test_a_handle_shows_a_pinned_key_and_a_masked_one():
    obj = add_tube()
    key(obj, "Swell").value = 1.0
    group = obj.vertex_groups.new(name="Half")
    group.add(range(len(obj.data.vertices)), 0.5, "REPLACE")
    key(obj, "Swell").vertex_group = "Half"
    first = rig.add_handle(obj, HANDLES["Middle"], "First")
    np.testing.assert_allclose(first.location, evaluated(obj)[HANDLES["Middle"]], atol=1e-6)
    obj.show_only_shape_key = True
    obj.active_shape_key_index = 1
    bpy.context.view_layer.update()
    second = rig.add_handle(obj, HANDLES["Middle"], "Second")
    np.testing.assert_allclose(second.location, evaluated(obj)[HANDLES["Middle"]], atol=1e-6)


def test_a_collection_that_was_deleted_is_linked_again():
    obj = add_rig()
    bpy.context.scene.collection.children.unlink(obj.tug.collection)
    rig.add_handle(obj, 40, "Fourth")
    assert rig.bind(obj).handles == 4


def test_a_handle_needs_a_vertex_that_exists():
    obj = add_tube()
    before = state(obj)
    with pytest.raises(RigError, match="no vertex 1000, only 0 to 159"):
        rig.add_handle(obj, 1000, "Far")
    assert state(obj) == before


# Bind ------------------------------------------------------------------------------------------


def test_a_bind_writes_one_vertex_group_for_each_handle():
    obj = add_rig(dictionary="HANDLES")
    summary = rig.bind(obj)
    assert [group.name for group in obj.vertex_groups] == list(HANDLES)
    weights = vertex_groups.read(obj, list(HANDLES))
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-5)
    np.testing.assert_allclose(weights[list(HANDLES.values())], np.eye(3), atol=1e-6)
    assert summary.weights_computed
    assert (summary.vertices, summary.shapes, summary.handles, summary.groups) == (160, 4, 3, 6)
    assert summary.dimension == 3
    seconds = summary.weights_seconds, summary.model_seconds, summary.solve_seconds
    assert all(0 < part < 10 for part in seconds)


def test_a_second_bind_reads_the_weights_and_gives_the_same_pose():
    obj = bound_rig(dictionary="HANDLES")
    pull_to(obj, "Swell")
    before = expected(obj)
    assert not rig.bind(obj).weights_computed
    np.testing.assert_array_equal(expected(obj), before)


@pytest.mark.parametrize("dictionary", ["EIGENFUNCTIONS", "HANDLES", "SKELETON"])
def test_a_bind_reports_its_progress_and_can_be_cancelled(dictionary):
    obj = add_rig(dictionary=dictionary)
    before = state(obj)
    seen = []

    def stop(stage, fraction):
        seen.append(fraction)
        if fraction > 0.8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rig.bind(obj, stop)
    assert seen == sorted(seen)
    assert state(obj) == before


def test_the_handles_at_rest_show_the_rest_shape():
    obj = bound_rig()
    result = key(obj, "Tug")
    assert (result.value, result.mute) == (1.0, False)
    np.testing.assert_allclose(evaluated(obj), tube()[0], atol=1e-4 * LENGTH)


@pytest.mark.parametrize("name", ["Bend", "Unbend", "Swell"])
def test_the_handles_of_an_example_show_the_example(name):
    obj = bound_rig()
    pull_to(obj, name)
    shape = np.array([point.co for point in key(obj, name).points])
    np.testing.assert_allclose(solved(obj), shape, atol=1e-3 * LENGTH)


def test_the_mesh_shows_exactly_what_was_solved():
    obj = bound_rig()
    pull_to(obj, "Bend")
    assert_close(solved(obj), expected(obj))


def test_the_pose_does_not_depend_on_where_the_object_is():
    poses = []
    for matrix in (Matrix(), PLACED):
        obj = add_tube(f"Tube {len(poses)}")
        obj.matrix_world = matrix
        bpy.context.view_layer.update()
        for name, vertex in HANDLES.items():
            rig.add_handle(obj, vertex, name)
        rig.bind(obj)
        pull_to(obj, "Swell")
        poses.append(solved(obj))
    np.testing.assert_allclose(*poses, atol=1e-4)


def test_a_parent_of_object_and_handles_moves_nothing_within_the_object():
    obj = bound_rig()
    pull_to(obj, "Bend")
    before = solved(obj)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    for child in (obj, *(handle.empty for handle in obj.tug.handles)):
        child.parent = parent
    parent.matrix_world = PLACED
    np.testing.assert_allclose(solved(obj), before, atol=1e-4)


def test_a_handle_that_does_not_follow_the_object_pulls_on_it():
    obj = bound_rig()
    obj.location.x += 1
    bpy.context.view_layer.update()
    target = bpy.data.objects["Tip"].location - obj.location
    np.testing.assert_allclose(solved(obj)[HANDLES["Tip"]], target, atol=1e-5)


def test_a_free_handle_pins_nothing():
    obj = add_rig()
    obj.tug.handles["Middle"].hold = "FREE"
    rig.bind(obj)
    before = solved(obj)
    bpy.data.objects["Middle"].location.x += 5
    np.testing.assert_array_equal(solved(obj), before)
    obj.tug.handles["Middle"].hold = "PINNED"
    assert np.abs(solved(obj) - before).max() > 1


def test_a_flat_mesh_is_solved_in_its_plane():
    vertices, faces = tube()
    across = vertices[:, [0, 2]]
    across[:, 0] += 0.3 * vertices[:, 1]
    flat = np.stack([across[:, 0], np.full(len(vertices), 0.75), across[:, 1]], axis=1)
    grid = flat[np.array([row for row in range(160) if row % 10 in (0, 1, 2, 3, 4)])]
    quads = [(a, a + 1, a + 6, a + 5) for a in range(75) if a % 5 != 4]
    obj = add_mesh("Leaf", grid, quads)
    wide = grid * [2, 1, 1]
    add_keys(obj, wide)
    for vertex in (2, 77):
        rig.add_handle(obj, vertex, f"Handle {vertex}")
    assert rig.bind(obj).dimension == 2
    obj.tug.handles[0].empty.location += Vector((0.1, 3.0, 0.2))
    posed = solved(obj)
    np.testing.assert_allclose(posed[:, 1], 0.75, atol=1e-6)
    np.testing.assert_allclose(posed[2, [0, 2]], grid[2, [0, 2]] + [0.1, 0.2], atol=1e-5)


def test_an_ngon_is_solved_through_its_triangles():
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    vertices = np.concatenate([ring, ring + [0, 0, 1]])
    faces = [tuple(range(7, -1, -1)), tuple(range(8, 16))]
    faces += [(i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i) for i in range(8)]
    obj = add_mesh("Drum", vertices, faces)
    add_keys(obj, bent(vertices, 0.5))
    for vertex in (0, 12):
        rig.add_handle(obj, vertex, f"Handle {vertex}")
    rig.bind(obj)
    np.testing.assert_allclose(evaluated(obj), vertices, atol=1e-3)


# Keys ------------------------------------------------------------------------------------------


def test_examples_are_muted_and_keep_their_values_until_the_rig_is_unbound():
    obj = add_rig(dictionary="HANDLES")
    key(obj, "Bend").value = 0.25
    key(obj, "Swell").mute = True
    rig.bind(obj)
    assert [key(obj, name).mute for name in ("Bend", "Unbend", "Swell")] == [True] * 3
    assert key(obj, "Bend").value == 0.25
    rig.bind(obj)
    rig.unbind(obj)
    assert [key(obj, name).mute for name in ("Bend", "Unbend", "Swell")] == [False, False, True]
    assert key(obj, "Bend").value == 0.25
    assert "Tug" not in obj.data.shape_keys.key_blocks
    assert [group.name for group in obj.vertex_groups] == list(HANDLES)
    assert not obj.animation_data or not obj.animation_data.drivers


def test_a_key_that_is_no_example_adds_on_top():
    obj = add_rig()
    shape = obj.tug.shapes.add()
    shape.name, shape.use = "Swell", False
    summary = rig.bind(obj)
    assert summary.shapes == 3
    swell = key(obj, "Swell")
    assert not swell.mute
    swell.value = 0.5
    difference = np.array([p.co for p in swell.points]) - tube()[0]
    assert_close(solved(obj), expected(obj) + 0.5 * difference)


def test_a_key_that_was_unticked_is_shown_again_by_the_next_bind():
    obj = bound_rig()
    obj.tug.shapes["Swell"].use = False
    rig.bind(obj)
    assert not key(obj, "Swell").mute


def test_a_key_of_the_artist_that_is_called_tug_is_not_written():
    obj = add_rig()
    add_key(obj, "Tug", tube()[0] + 1)
    summary = rig.bind(obj)
    assert summary.shapes == 5
    assert obj.tug.result == "Tug.001"
    np.testing.assert_allclose([p.co for p in key(obj, "Tug").points], tube()[0] + 1, atol=1e-6)


# Weights ---------------------------------------------------------------------------------------


def test_repainting_changes_the_pose_to_what_a_new_bind_gives():
    obj = bound_rig(dictionary="HANDLES")
    pull_between(obj)
    before = solved(obj)
    repaint(obj, "Middle")
    painted = solved(obj)
    assert np.abs(painted - before).max() > 1e-3
    assert not rig.bind(obj).weights_computed
    np.testing.assert_array_equal(solved(obj), painted)


def test_painted_weights_are_not_overwritten():
    obj = bound_rig(dictionary="HANDLES")
    repaint(obj, "Middle")
    rig.add_handle(obj, 40, "Fourth")
    before = state(obj)
    with pytest.raises(RigError, match="Tug did not make: Middle"):
        rig.bind(obj)
    assert state(obj) == before


def test_groups_of_the_artist_serve_as_weights():
    obj = add_rig(dictionary="HANDLES")
    height = tube()[0][:, 2] / LENGTH
    for name, center in zip(HANDLES, (0.0, 0.5, 1.0), strict=True):
        group = obj.vertex_groups.new(name=name)
        for vertex, distance in enumerate(np.abs(height - center)):
            group.add([vertex], max(0.0, 1 - 2 * distance) * 0.8, "REPLACE")
    assert not rig.bind(obj).weights_computed


def test_a_vertex_that_belongs_to_no_handle_is_named():
    obj = bound_rig(dictionary="HANDLES")
    for group in obj.vertex_groups:
        group.remove([33, 44])
    before = state(obj)
    with pytest.raises(RigError, match="2 vertices .* belong to no handle, the first is vertex 33"):
        rig.bind(obj)
    assert state(obj) == before
