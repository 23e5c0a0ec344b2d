# SPDX-License-Identifier: GPL-3.0-or-later
"""What a model is made from, read off an object and checked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from . import shape_keys, vertex_groups

# A coordinate that varies by less, relative to the size of the shapes, is flat.
FLAT = 1e-6


class RigError(Exception):
    """A rig cannot be bound or solved; the text tells the artist why and what to do."""


@dataclass(frozen=True)
class Inputs:
    """Arrays of an object whose keys and handles have been checked.

    shapes: #S by #V by 3 float32, Basis first. triangles: #F by 3; faces: #F, the face that each is
    of. handles: the vertex of each. stiffness: #F, what the energy of each triangle is multiplied
    by. axes: the coordinates that are solved for, two where every shape lies in one plane across an
    axis. topology: digest of the faces.
    """

    shapes: np.ndarray
    triangles: np.ndarray
    faces: np.ndarray
    handles: np.ndarray
    stiffness: np.ndarray
    axes: list[int]
    topology: str

    @property
    def solved_shapes(self) -> np.ndarray:
        """#S by #V by k float64."""
        return np.ascontiguousarray(self.shapes[:, :, self.axes], np.float64)


def digest(*arrays: np.ndarray) -> str:
    state = hashlib.blake2b(digest_size=16)
    for array in arrays:
        state.update(f"{array.shape}{array.dtype}".encode())
        state.update(np.ascontiguousarray(array).data)
    return state.hexdigest()


def is_linked(obj: bpy.types.Object) -> bool:
    """Whether its shape keys are another file's: no pose can be written to them."""
    return bool(obj.library or obj.data.library)


def check_local(obj: bpy.types.Object) -> None:
    """Raises RigError where an object cannot be changed."""
    if obj.type == "MESH" and is_linked(obj):
        raise RigError(
            f'"{obj.name}" is linked from another file: make it and its mesh local first. As it '
            "is, its poses can be baked"
        )


def check_object(obj: bpy.types.Object) -> None:
    """Raises RigError where an object cannot carry a rig at all."""
    name = f'"{obj.name}"'
    if obj.type != "MESH":
        raise RigError(f"{name} is not a mesh")
    if obj.data.is_editmode:
        raise RigError(f"{name} is in Edit Mode: leave it first")
    keys = obj.data.shape_keys
    if keys is None:
        raise RigError(f"{name} has no shape keys: add Basis and the example shapes first")
    if not keys.use_relative:
        raise RigError(f"the shape keys of {name} are absolute: switch them to Relative")


def ticked(obj: bpy.types.Object) -> list[str]:
    """Names of the example keys, Basis first."""
    keys, rig = obj.data.shape_keys, obj.tug
    return [keys.reference_key.name] + [
        block.name
        for block in keys.key_blocks
        if block.name not in (keys.reference_key.name, rig.result)
        and (block.name not in rig.shapes or rig.shapes[block.name].use)
    ]


def tick(obj: bpy.types.Object, name: str, *, use: bool) -> None:
    """Let a shape key be an example, or leave it out, from the next bind on."""
    shape = obj.tug.shapes.get(name) or obj.tug.shapes.add()
    shape.name, shape.use = name, use


def bound_examples(obj: bpy.types.Object) -> list[str]:
    """Names of the keys that the rig was bound to, Basis first."""
    return json.loads(obj.tug.examples) if obj.tug.bound else []


def gather(
    obj: bpy.types.Object,
    examples: Sequence[str],
    handles: Sequence[bpy.types.PropertyGroup],
    vertices: Sequence[int] | None = None,
) -> Inputs:
    """Read and check everything but the weights. vertices: of the handles where not their own."""
    shapes, (triangles, faces) = _shapes(obj, examples), _triangles(obj.data)
    return Inputs(
        shapes=shapes,
        triangles=triangles,
        faces=faces,
        handles=_vertices(obj, handles, vertices or [handle.vertex for handle in handles]),
        stiffness=_stiffness(obj, triangles),
        axes=_axes(shapes),
        topology=topology(obj.data),
    )


def surface(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """The rest shape, #V by 3, and its triangles, #F by 3."""
    check_object(obj)
    rest = _shapes(obj, [obj.data.shape_keys.reference_key.name])[0]
    return rest.astype(np.float64), _triangles(obj.data)[0]


def topology(mesh: bpy.types.Mesh) -> str:
    """Digest of the faces, whatever the coordinates are."""
    starts = np.empty(len(mesh.polygons), np.int32)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    if len(corners):  # many times faster than the loops' own "vertex_index"
        mesh.attributes[".corner_vert"].data.foreach_get("value", corners)
    return digest(starts, corners, np.array([len(mesh.vertices)]))


def _shapes(obj: bpy.types.Object, examples: Sequence[str]) -> np.ndarray:
    count = len(obj.data.vertices)
    shapes = np.empty((len(examples), count, 3), np.float32)
    for shape, name in zip(shapes, examples, strict=True):
        points = shape_keys.coordinates(obj.data.shape_keys.key_blocks[name])
        if len(points) != count:
            raise RigError(
                f'the shape key "{name}" of "{obj.name}" has {len(points)} points but the mesh has '
                f"{count} vertices: it was made for another mesh, delete it or make it again"
            )
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise RigError(
                f'the shape key "{name}" of "{obj.name}" has {len(bad)} points that are nowhere '
                f"(not a number or infinite), the first at vertex {bad[0]}: move or delete them"
            )
        shape[:] = points
    return shapes


def _triangles(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """And the number of the face that each is of."""
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    faces = np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    if len(faces):  # many times faster than the triangles' own "polygon_index"
        mesh.loop_triangle_polygons.foreach_get("value", faces)
    return triangles.reshape(-1, 3), faces


def _vertices(
    obj: bpy.types.Object, handles: Sequence[bpy.types.PropertyGroup], vertices: Sequence[int]
) -> np.ndarray:
    if len(handles) < 2:
        raise RigError(f'"{obj.name}" needs at least two handles, it has {len(handles)}')
    seen: dict[int, str] = {}
    for handle, vertex in zip(handles, vertices, strict=True):
        if vertex >= len(obj.data.vertices):
            raise RigError(
                f'the handle "{handle.name}" is on vertex {vertex}, but "{obj.name}" has only '
                f"{len(obj.data.vertices)} vertices: choose another vertex"
            )
        if vertex in seen:
            raise RigError(
                f'the handles "{seen[vertex]}" and "{handle.name}" of "{obj.name}" are on the same '
                f"vertex {vertex}: put one on another vertex or delete it"
            )
        seen[vertex] = handle.name
    return np.array(list(seen), np.int32)


def _stiffness(obj: bpy.types.Object, triangles: np.ndarray) -> np.ndarray:
    """From 1 where the stiffness group has no weight to the maximum where it has weight 1, as for
    cloth; a triangle has the mean of its corners."""
    name = obj.tug.stiffness_group
    if not name:
        return np.ones(len(triangles))
    if name not in obj.vertex_groups:
        raise RigError(
            f'"{obj.name}" has no vertex group "{name}" to take its stiffness from: choose another '
            "in the settings of the rig or none"
        )
    weights = vertex_groups.read(obj, [name])[:, 0].astype(np.float64)
    return 1 + (obj.tug.stiffness_max - 1) * weights[triangles].mean(axis=1)


def _axes(shapes: np.ndarray) -> list[int]:
    extents = np.array([np.ptp(shapes[..., axis]) for axis in range(3)])
    flat = extents <= FLAT * extents.max()
    return [axis for axis in range(3) if flat.sum() != 1 or not flat[axis]]
