# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators that fit a rig, called as functions."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from scans import add_markers, add_scan, pose
from support import LENGTH, add_mesh, bound_rig, key, read_pc2, state

from addon.fitting import fit
from addon.rigging import rig, shape_keys


@pytest.fixture
def obj() -> bpy.types.Object:
    obj = bound_rig()
    bpy.context.view_layer.objects.active = obj
    bpy.context.scene.frame_set(1)
    return obj


def result(obj: bpy.types.Object) -> np.ndarray:
    return shape_keys.coordinates(key(obj, "Tug"))


def error(obj: bpy.types.Object) -> float:
    """The mean distance from the pose of the scan, in parts of the length of the tube."""
    return np.linalg.norm(result(obj) - pose(), axis=1).mean() / LENGTH


def test_a_target_is_fitted_and_undo_takes_it_back(obj):
    obj.tug.fit_target = add_scan(obj, pose())
    before = result(obj)
    bpy.ops.ed.undo_push(message="scanned")
    assert bpy.ops.tug.fit("EXEC_DEFAULT", True) == {"FINISHED"}
    assert error(obj) < 0.01
    bpy.context.view_layer.update()
    assert error(obj) < 0.01  # live, but no handle has moved
    bpy.ops.ed.undo()
    np.testing.assert_array_equal(result(bpy.data.objects["Tube"]), before)


def test_markers_alone_or_beside_a_scan(obj):
    obj.tug.fit_markers = add_markers(obj, pose())
    assert bpy.ops.tug.fit() == {"FINISHED"}
    assert error(obj) < 0.05
    obj.tug.fit_target = add_scan(obj, pose(), markers=[])
    assert bpy.ops.tug.fit() == {"FINISHED"}
    assert error(obj) < 0.01


def test_every_frame_is_fitted(obj, tmp_path):
    obj.tug.fit_target = add_scan(obj, pose())
    wanted = fit.fit_frames(obj, obj.tug.fit_target, 1, 2, tmp_path / "wanted.pc2")
    path = tmp_path / "fit.pc2"
    assert bpy.ops.tug.fit_frames(filepath=str(path), first=1, last=2) == {"FINISHED"}
    np.testing.assert_array_equal(read_pc2(path)[1], read_pc2(wanted)[1])


def test_what_is_missing_is_told(obj):
    with pytest.raises(RuntimeError, match=r"poll.*Choose a target first"):
        bpy.ops.tug.fit()
    obj.tug.fit_target = add_scan(obj, pose())
    rig.unbind(obj)
    for operator in (bpy.ops.tug.fit, bpy.ops.tug.fit_frames):
        with pytest.raises(RuntimeError, match=r"poll.*Bind the mesh to its handles"):
            operator()


@pytest.mark.parametrize(
    ("positions", "text"),
    [
        (np.zeros((0, 3)), "the scan is empty"),
        (np.full((4, 3), np.nan), "4 points of the scan are not finite"),
        (np.full((4, 3), 1e3), "no point of the scan is near"),
    ],
)
def test_targets_that_cannot_be_are_told_and_nothing_changes(obj, tmp_path, positions, text):
    obj.tug.fit_target = add_mesh("Scan", positions, [])
    bpy.context.view_layer.update()
    before = state(obj)
    with pytest.raises(RuntimeError, match=f'"Tube" cannot be fitted to "Scan": .*{text}'):
        bpy.ops.tug.fit()
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.tug.fit_frames(filepath=str(tmp_path / "fit.pc2"), first=1, last=2)
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


def test_the_settings_of_the_rig_count(obj):
    obj.tug.fit_target = add_scan(obj, pose(), markers=[])
    obj.tug.fit_reach = 0.5
    bpy.ops.tug.fit()
    far = error(obj)
    rig.solve(obj, bpy.context.evaluated_depsgraph_get())
    obj.tug.fit_reach = 0.001
    with pytest.raises(RuntimeError, match="no point of the scan is near"):
        bpy.ops.tug.fit()
    assert far < 0.2


def test_an_object_is_no_target_of_itself(obj):
    obj.tug.fit_target = obj
    with pytest.raises(RuntimeError, match='"Tube" cannot be fitted to itself'):
        bpy.ops.tug.fit()


def test_a_bake_rolls_the_same_film(obj, tmp_path):
    path = tmp_path / "bake.pc2"
    assert bpy.ops.tug.bake(filepath=str(path), first=1, last=3) == {"FINISHED"}
    assert len(read_pc2(path)[1]) == 3
