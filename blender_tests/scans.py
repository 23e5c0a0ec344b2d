# SPDX-License-Identifier: GPL-3.0-or-later
"""Scans and empties for the tests of fits."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np
from mathutils import Matrix
from support import HANDLES, add_mesh, bent, tube

ELSEWHERE = Matrix.Translation((3, -2, 1)) @ Matrix.Rotation(1.0, 4, "Y") @ Matrix.Scale(2.0, 4)
ORDER = np.random.default_rng(0).permutation(len(tube()[0]))


def pose() -> np.ndarray:
    """Between two examples."""
    return bent(tube()[0], 1.0)


def add_scan(
    obj: bpy.types.Object,
    positions: np.ndarray,
    *,
    faces: bool = True,
    normals: np.ndarray | None = None,
    markers: Iterable[str] = HANDLES,
) -> bpy.types.Object:
    """The positions as an object that stands where the rig's object does but has a space of its
    own, its vertices in another order, and empties at the vertices of the handles."""
    place = np.argsort(ORDER)
    own = np.array(ELSEWHERE.inverted() @ obj.matrix_world)
    there = positions @ own[:3, :3].T + own[:3, 3]
    quads = place[np.array(tube()[1])].tolist() if faces else []
    scan = add_mesh("Scan", there[ORDER], quads)
    scan.matrix_world = ELSEWHERE
    if normals is not None:
        attribute = scan.data.attributes.new("normal", "FLOAT_VECTOR", "POINT")
        turned = normals @ np.linalg.inv(own[:3, :3])
        attribute.data.foreach_set("vector", turned[ORDER].astype(np.float32).ravel())
    bpy.context.view_layer.update()
    add_markers(obj, positions, markers, parent=scan)
    return scan


def add_markers(
    obj: bpy.types.Object,
    positions: np.ndarray,
    names: Iterable[str] = HANDLES,
    parent: bpy.types.Object | None = None,
) -> bpy.types.Collection:
    collection = bpy.data.collections.new("Markers")
    bpy.context.scene.collection.children.link(collection)
    for name in names:
        empty = bpy.data.objects.new(name, None)  # becomes "Tip.001": the handle has the name
        collection.objects.link(empty)
        world = obj.matrix_world @ Matrix.Translation(positions[HANDLES[name]])
        if parent:
            empty.parent = parent
        bpy.context.view_layer.update()
        empty.matrix_world = world
    bpy.context.view_layer.update()
    return collection
