# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits of a rig to meshes, clouds of points and empties: near what is known, or nothing changed."""

from __future__ import annotations

import threading
from math import radians

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from scans import ELSEWHERE, ORDER, add_markers, add_scan, pose
from support import (
    HANDLES,
    LENGTH,
    add_key,
    add_keys,
    add_mesh,
    assert_close,
    bent,
    bound_rig,
    depsgraph,
    evaluated,
    key,
    pull_to,
    read_pc2,
    state,
    tube,
)

from addon.dictionaries import Dictionary
from addon.fitting.fit import finish_fit, fit, fit_frames, plan_fit
from addon.registration.nonrigid import Settings
from addon.rigging import rig, shape_keys
from addon.rigging.inputs import RigError


@pytest.fixture
def obj() -> bpy.types.Object:
    obj = bound_rig()
    obj.matrix_world = Matrix.Rotation(radians(30), 4, "X") @ Matrix.Scale(0.5, 4)
    bpy.context.scene.frame_set(1)
    return obj


def outwards(vertices: np.ndarray) -> np.ndarray:
    """Normals of the straight tube, and of no other."""
    return vertices * [2, 2, 0]


def result(obj: bpy.types.Object) -> np.ndarray:
    return shape_keys.coordinates(key(obj, "Tug"))


def error(obj: bpy.types.Object, truth: np.ndarray) -> float:
    """The mean distance, in parts of the length of the tube."""
    return np.linalg.norm(result(obj) - truth, axis=1).mean() / LENGTH


@pytest.mark.parametrize("dictionary", Dictionary)
def test_a_mesh_is_fitted(obj, dictionary):
    obj.tug.dictionary = dictionary
    rig.bind(obj)
    summary = fit(obj, add_scan(obj, pose()))
    assert error(obj, pose()) < 0.01
    assert (summary.features, summary.points) == (3, len(ORDER))
    assert summary.distance < 0.05 * LENGTH
    assert summary.covered > 0.7
    assert_close(evaluated(obj), result(obj))


def test_an_example_is_found(obj):
    bend = shape_keys.coordinates(key(obj, "Bend"))
    fit(obj, add_scan(obj, bend))
    assert error(obj, bend) < 1e-3


@pytest.mark.parametrize("with_normals", [True, False])
def test_a_cloud_of_points_is_fitted(obj, with_normals):
    straight = tube()[0]
    normals = outwards(straight) if with_normals else None
    summary = fit(obj, add_scan(obj, straight, faces=False, normals=normals))
    assert summary.points == len(ORDER)
    assert error(obj, straight) < 0.01


@pytest.mark.skipif(bpy.app.version < (4, 4), reason="not run: no script makes a cloud before 4.4")
def test_an_object_of_points_is_fitted(obj):
    scan = add_scan(obj, pose(), faces=False)
    bpy.context.view_layer.objects.active = scan
    scan.select_set(True)
    bpy.ops.object.convert(target="POINTCLOUD")
    cloud = bpy.context.view_layer.objects.active
    assert cloud.type == "POINTCLOUD"
    fit(obj, cloud)
    assert error(obj, pose()) < 0.015


def test_modifiers_of_the_target_count(obj):
    scan = add_scan(obj, pose())
    scan.modifiers.new("Subdivision", "SUBSURF")
    assert fit(obj, scan).points > 3 * len(ORDER)
    assert error(obj, pose()) < 0.02


def test_a_mirrored_target_faces_outwards_too(obj):
    scan = add_scan(obj, pose())
    mirror = Matrix.Scale(-1, 4, (1, 0, 0))
    scan.data.transform(mirror)
    scan.data.flip_normals()
    markers = list(scan.children)
    places = [marker.matrix_world.copy() for marker in markers]
    scan.matrix_world = ELSEWHERE @ mirror
    bpy.context.view_layer.update()
    for marker, place in zip(markers, places, strict=True):
        marker.matrix_world = place
    bpy.context.view_layer.update()
    assert fit(obj, scan).covered > 0.7
    assert error(obj, pose()) < 0.01


def test_empties_alone_hold_the_rig(obj):
    summary = fit(obj, add_markers(obj, pose()))
    assert (summary.features, summary.points) == (3, 0)
    vertices = list(HANDLES.values())
    assert_close(result(obj)[vertices], pose()[vertices])
    assert error(obj, pose()) < 0.05


def test_pairs_may_be_given(obj):
    scan = add_scan(obj, pose(), markers=[])
    place = np.argsort(ORDER)
    empty = bpy.data.objects.new("Somewhere", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.matrix_world = obj.matrix_world @ Matrix.Translation(pose()[40])
    bpy.context.view_layer.update()
    pairs = {"Root": int(place[0]), "Middle": int(place[85]), 155: int(place[155]), 40: empty}
    assert fit(obj, scan, pairs).features == 4
    assert error(obj, pose()) < 0.01


def test_without_pairs_it_starts_where_the_handles_are(obj):
    pull_to(obj, "Bend")
    bend = shape_keys.coordinates(key(obj, "Bend"))
    summary = fit(obj, add_scan(obj, bent(tube()[0], 1.3), markers=[]))
    assert summary.features == 0
    assert error(obj, bent(tube()[0], 1.3)) < error(obj, bend)


def test_handles_pose_the_rig_again_after_a_fit(obj):
    before = rig.positions(obj, depsgraph())
    fit(obj, add_scan(obj, pose()))
    rig.solve(obj, depsgraph())
    assert_close(result(obj), before)


# In three parts -----------------------------------------------------------------------------------


def built_in_thread(job, progress=None):
    """What went wrong, if anything."""
    problems = []

    def build():
        try:
            job.build(progress)
        except BaseException as error:
            problems.append(error)

    thread = threading.Thread(target=build)
    thread.start()
    thread.join()
    return problems


def test_a_fit_in_a_thread_is_what_a_fit_gives(obj):
    scan = add_scan(obj, pose())
    fit(obj, scan)
    wanted = result(obj)
    rig.solve(obj, depsgraph())
    before = state(obj)
    job = plan_fit(obj, scan)
    assert built_in_thread(job) == []
    assert state(obj) == before
    assert finish_fit(obj, job).features == 3
    np.testing.assert_array_equal(result(obj), wanted)


def test_a_thread_that_is_cancelled_leaves_the_scene_as_it_was(obj):
    def stop(stage, fraction):
        if fraction > 0.3:
            raise KeyboardInterrupt

    job = plan_fit(obj, add_scan(obj, pose()))
    before = state(obj)
    assert isinstance(built_in_thread(job, stop)[0], KeyboardInterrupt)
    with pytest.raises(ValueError, match="has not been built"):
        finish_fit(obj, job)
    assert state(obj) == before


def test_a_fit_is_not_finished_on_an_object_that_was_edited_meanwhile(obj):
    job = plan_fit(obj, add_scan(obj, pose()))
    assert built_in_thread(job) == []
    bend = shape_keys.coordinates(key(obj, "Bend"))
    shape_keys.write(obj.data, key(obj, "Bend"), 1.1 * bend)
    before = state(obj)
    with pytest.raises(RigError, match="was edited while it was being fitted: fit it again"):
        finish_fit(obj, job)
    assert state(obj) == before


def test_a_target_of_another_size_is_followed(obj):
    obj.tug.form, obj.tug.follow_size = "CLOSEST", True
    large = 1.4 * pose()
    fit(obj, add_scan(obj, large))
    assert error(obj, large) < 0.02


# Every frame ------------------------------------------------------------------------------------


@pytest.fixture
def moving(obj) -> bpy.types.Object:
    """A scan that bends from frame 1 to 5, its markers with it."""
    scan = add_scan(obj, tube()[0])
    own = np.array(ELSEWHERE.inverted() @ obj.matrix_world)
    add_key(scan, "Basis", (tube()[0] @ own[:3, :3].T + own[:3, 3])[ORDER])
    there = (bent(tube()[0], 1.2) @ own[:3, :3].T + own[:3, 3])[ORDER]
    block = add_key(scan, "Bent", there)
    for frame, value in ((1, 0.0), (5, 1.0)):
        block.value = value
        block.keyframe_insert("value", frame=frame)
    for marker in scan.children:
        vertex = int(np.argsort(ORDER)[HANDLES[marker.name.partition(".")[0]]])
        marker.parent_type, marker.parent_vertices = "VERTEX", [vertex] * 3
        marker.matrix_parent_inverse.identity()
        marker.location = (0, 0, 0)
    return scan


def mixed(share: float) -> np.ndarray:
    return (1 - share) * tube()[0] + share * bent(tube()[0], 1.2)


def test_each_frame_of_a_moving_scan_is_fitted(obj, moving, tmp_path):
    bpy.context.scene.frame_set(2)
    path = fit_frames(obj, moving, 1, 5, tmp_path / "fit.pc2")
    assert bpy.context.scene.frame_current == 2
    first, frames = read_pc2(path)
    assert (first, len(frames)) == (1, 5)
    for number, positions in enumerate(frames):
        bpy.context.scene.frame_set(1 + number)
        np.testing.assert_array_equal(evaluated(obj), positions)  # the modifier shows it
    for share, positions in ((0.0, frames[0]), (1.0, frames[4])):
        assert np.linalg.norm(positions - mixed(share), axis=1).mean() < 0.01 * LENGTH


def test_a_part_equals_the_same_frames_of_the_whole(obj, moving, tmp_path):
    _, whole = read_pc2(fit_frames(obj, moving, 1, 4, tmp_path / "whole.pc2"))
    _, part = read_pc2(fit_frames(obj, moving, 3, 4, tmp_path / "part.pc2"))
    np.testing.assert_array_equal(part, whole[2:])


def test_cancelled_frames_leave_nothing_behind(obj, moving, tmp_path):
    def stop(stage, fraction):
        if stage == "frame 2":
            raise KeyboardInterrupt

    before = state(obj)
    with pytest.raises(KeyboardInterrupt):
        fit_frames(obj, moving, 1, 5, tmp_path / "fit.pc2", progress=stop)
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


def test_a_frame_that_cannot_be_fitted_is_told(obj, moving, tmp_path):
    moving.matrix_world = Matrix.Scale(0.0, 4)
    before = state(obj)
    with pytest.raises(RigError, match='"Tube" cannot be fitted to "Scan": '):
        fit_frames(obj, moving, 1, 5, tmp_path / "fit.pc2")
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


# What cannot be ---------------------------------------------------------------------------------


def assert_told(obj: bpy.types.Object, text: str, *arguments: object, **options: object) -> None:
    before = state(obj)
    with pytest.raises(RigError, match=text):
        fit(obj, *arguments, **options)
    assert state(obj) == before


def test_a_cancelled_fit_changes_nothing(obj):
    def stop(stage, fraction):
        raise KeyboardInterrupt

    scan = add_scan(obj, pose())
    before = state(obj)
    with pytest.raises(KeyboardInterrupt):
        fit(obj, scan, progress=stop)
    assert state(obj) == before


def test_targets_that_cannot_be_are_told(obj):
    assert_told(obj, '"Tube" cannot be fitted to itself', obj)
    curve = bpy.data.objects.new("Line", bpy.data.curves.new("Line", "CURVE"))
    bpy.context.scene.collection.objects.link(curve)
    assert_told(obj, '"Line" is neither a mesh nor a point cloud', curve)
    assert_told(obj, "the scan is empty", add_mesh("Nothing", np.zeros((0, 3)), []))
    nowhere = add_mesh("Nowhere", np.full((4, 3), np.nan), [])
    assert_told(obj, "4 points of the scan are not finite", nowhere)


def test_a_far_target_is_told(obj):
    scan = add_scan(obj, pose() + 100, markers=[])
    assert_told(obj, "no point of the scan is near the body", scan)


def test_pairs_that_cannot_be_are_told(obj):
    scan = add_scan(obj, pose(), markers=["Root", "Tip"])
    assert_told(obj, "at least three features are needed .* there are 2", scan)
    assert_told(obj, 'has no handle "Nose"; there are: Root, Middle, Tip', scan, {"Nose": 0})
    assert_told(obj, "the target has no point 1000", scan, {"Root": 1000})
    line = {0: 0, 10: 1, 20: 2}
    cloud = add_mesh("Line", np.arange(9.0).reshape(3, 3), [])
    assert_told(obj, "on one line", cloud, line)


def test_a_collection_without_the_names_of_handles_is_told(obj):
    nameless = add_markers(obj, pose(), [])
    assert_told(obj, 'no empty of .* has the name of a handle of "Tube": Root', nameless)


def test_two_empties_of_one_handle_are_told(obj):
    markers = add_markers(obj, pose())
    again = bpy.data.objects.new("Tip", None)
    markers.objects.link(again)
    assert_told(obj, '"Tip.001" and "Tip.002" both stand for the handle "Tip"', markers)


def test_normals_that_are_asked_for_are_told(obj):
    scan = add_scan(obj, pose(), faces=False)
    assert_told(obj, "the scan has no normals", scan, settings=Settings())


def test_rigs_that_are_not_bound_or_stale_are_told(obj):
    scan = add_scan(obj, pose())
    rig.unbind(obj)
    assert_told(obj, '"Tube" is not bound: bind it first', scan)


def test_a_flat_rig_is_told():
    across, up = np.meshgrid(np.arange(3.0), np.arange(8.0))
    flat = np.stack([across.ravel(), 0 * across.ravel(), up.ravel()], axis=1)
    corner = (3 * np.arange(7)[:, None] + np.arange(2)).ravel()
    obj = add_mesh(
        "Strip", flat, np.stack([corner, corner + 1, corner + 4, corner + 3], 1).tolist()
    )
    add_keys(obj, flat * [1, 1, 1.5])
    for name, vertex in (("Low", 1), ("Left", 9), ("High", 23)):
        rig.add_handle(obj, vertex, name)
    rig.bind(obj)
    assert_told(obj, "its shapes are flat", add_mesh("Scan", flat, []), {"Low": 0})
