# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object is fitted to, read from the scene: a mesh, a cloud of points, named empties.

Everything is taken as it is evaluated, after modifiers, and in the space of the fitted object.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import bpy
import numpy as np

from ..registration.scan import Scan
from ..rigging.inputs import RigError

NORMAL_ATTRIBUTES = ("normal", "Normal", "N")  # of the points of a cloud

Place = bpy.types.Object | int  # an object's location, or a point of the target
Target = bpy.types.Object | bpy.types.Collection


def chosen(obj: bpy.types.Object) -> Target | None:
    """What the artist chose for the rig."""
    return obj.tug.fit_target or obj.tug.fit_markers


def chosen_pairs(obj: bpy.types.Object) -> dict[str, Place] | None:
    """Where there are a scan and markers, those beside the empties below the scan. None: as
    find_pairs finds them."""
    rig = obj.tug
    if rig.fit_target is None or rig.fit_markers is None:
        return None
    return {**find_pairs(obj, rig.fit_target), **find_pairs(obj, rig.fit_markers)}


def space(
    obj: bpy.types.Object, other: bpy.types.Object, depsgraph: bpy.types.Depsgraph
) -> np.ndarray:
    """4 by 4, from the space of another object to that of `obj`."""
    own = np.array(obj.evaluated_get(depsgraph).matrix_world)
    if np.linalg.matrix_rank(own[:3, :3]) < 3:
        raise RigError(f'"{obj.name}" has a scale of zero: nothing can be fitted in its space')
    return np.linalg.solve(own, np.array(other.evaluated_get(depsgraph).matrix_world))


def read_scan(
    obj: bpy.types.Object, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph
) -> Scan:
    """The points of the target. Of a mesh with faces the vertices, else the points with the normals
    of their attribute "normal", if there is one. May raise ValueError as Scan does."""
    if target.type not in ("MESH", "POINTCLOUD"):
        raise RigError(
            f'"{target.name}" is neither a mesh nor a point cloud: convert it, or give a '
            "collection of empties"
        )
    matrix = space(obj, target, depsgraph)
    data = target.evaluated_get(depsgraph).data
    if data is None:
        raise RigError(f'"{target.name}" has no data at this frame')
    points = _vectors(data, "position") @ matrix[:3, :3].T + matrix[:3, 3]
    if isinstance(data, bpy.types.Mesh) and len(data.polygons):
        return Scan.of_mesh(points, _triangles(data, mirrored=np.linalg.det(matrix[:3, :3]) < 0))
    name = next((name for name in NORMAL_ATTRIBUTES if name in data.attributes), None)
    if name is None:
        return Scan(points)
    normals = _vectors(data, name) @ np.linalg.pinv(matrix[:3, :3])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return Scan(points, normals / np.where(lengths > 0, lengths, 1))


def find_pairs(obj: bpy.types.Object, target: Target) -> dict[str, Place]:
    """Handles of the rig, and empties of their names below the target or in the collection. As no
    two objects have one name, numbers that Blender appends (".001") do not count."""
    below = (
        target.children_recursive if isinstance(target, bpy.types.Object) else target.all_objects
    )
    handles = {handle.empty for handle in obj.tug.handles}
    found: dict[str, Place] = {}
    for empty in below:
        if empty.type != "EMPTY" or empty in handles:
            continue
        name = next(
            (name for name in (empty.name, _plain(empty.name)) if name in _names(obj)), None
        )
        if name in found:
            raise RigError(
                f'"{found[name].name}" and "{empty.name}" both stand for the handle "{name}": '
                "rename one of them"
            )
        if name is not None:
            found[name] = empty
    return found


def read_features(
    obj: bpy.types.Object,
    pairs: Mapping[str | int, Place],
    scan: Scan | None,
    depsgraph: bpy.types.Depsgraph,
) -> tuple[list[int], np.ndarray]:
    """Vertices of the object and their places, #N by 3. pairs: a handle's name or a vertex, and the
    object that stands where it belongs, or a point of the scan."""
    vertices = [_vertex(obj, key) for key in pairs]
    places = [_place(obj, place, scan, depsgraph) for place in pairs.values()]
    return vertices, np.array(places).reshape(-1, 3)


def _vertex(obj: bpy.types.Object, key: str | int) -> int:
    if isinstance(key, int):
        return key
    for handle in obj.tug.handles:
        if handle.name == key:
            return handle.vertex
    raise RigError(f'"{obj.name}" has no handle "{key}"; there are: {", ".join(_names(obj))}')


def _place(
    obj: bpy.types.Object, place: Place, scan: Scan | None, depsgraph: bpy.types.Depsgraph
) -> np.ndarray:
    if isinstance(place, bpy.types.Object):
        return space(obj, place, depsgraph)[:3, 3]
    if scan is None or not 0 <= place < len(scan.points):
        raise RigError(f"the target has no point {place}")
    return scan.points[place]


def _names(obj: bpy.types.Object) -> list[str]:
    return [handle.name for handle in obj.tug.handles]


def _plain(name: str) -> str:
    return re.sub(r"\.\d+$", "", name)


def _vectors(data: bpy.types.ID, name: str) -> np.ndarray:
    attribute = data.attributes.get(name)
    if attribute is None:  # an empty mesh has not even positions
        return np.zeros((0, 3))
    if attribute.domain != "POINT" or attribute.data_type != "FLOAT_VECTOR":
        raise RigError(f'the attribute "{name}" must hold a vector for each point')
    flat = np.empty(3 * len(attribute.data), np.float32)
    attribute.data.foreach_get("vector", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def _triangles(mesh: bpy.types.Mesh, *, mirrored: bool) -> np.ndarray:
    mesh.calc_loop_triangles()
    flat = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", flat)
    triangles = flat.reshape(-1, 3)
    return triangles[:, ::-1].copy() if mirrored else triangles
