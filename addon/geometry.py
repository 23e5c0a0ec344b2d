# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, rows on their vertices, and nearest points, with NumPy arrays in and out.

The conventions are those of solver.py.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, byref, c_int32
from dataclasses import dataclass
from typing import Self

import numpy as np

from . import native
from .objects import Memory, Owner, as_matrix, offsets


@dataclass(frozen=True)
class MeshReport:
    """What is wrong with a mesh: numbers of lines in `text`, errors first."""

    errors: int
    warnings: int
    text: str


class Mesh(Owner):
    """The rest shape and its triangles. O(#V + #F log #F).

    vertices: #V by k. triangles: #F by 3, indices from 0. Any geometry is taken; `check` says what
    is wrong with it.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        vertices, triangles = as_matrix(vertices, np.float64), as_matrix(triangles, np.int32)
        if triangles.shape[1] != 3:
            raise ValueError(f"triangles must be #F by 3, not {triangles.shape}")
        self.vertex_count, self.dimension = vertices.shape
        self.triangle_count = len(triangles)
        self.triangles = triangles.copy()
        out = POINTER(native.tug_mesh)()
        native.library().tug_create_mesh(
            vertices, *vertices.shape, triangles, len(triangles), byref(out)
        )
        super().__init__(Memory(out, native.library().tug_destroy_mesh))

    def check(self) -> MeshReport:
        """What is wrong with the mesh, in words. O(#F)."""
        text = ctypes.create_string_buffer(4096)
        errors, warnings = c_int32(), c_int32()
        native.library().tug_check_mesh(
            self._pointer, text, len(text), byref(errors), byref(warnings)
        )
        return MeshReport(errors.value, warnings.value, text.value.decode(errors="replace"))

    def components(self) -> np.ndarray:
        """#V component numbers, from 0 in the order of their first vertex."""
        component, count = np.empty(self.vertex_count, np.int32), c_int32()
        native.library().tug_find_components(self._pointer, component, byref(count))
        return component

    def spread(self, count: int, first: int = 0) -> np.ndarray:
        """`count` vertices spread evenly over the surface: `first`, then always the one farthest
        along the edges from all before it. O(count #V log #V)."""
        vertices = np.empty(max(count, 0), np.int32)
        native.library().tug_spread_vertices(self._pointer, first, count, vertices)
        return vertices

    def distances(self, sources: Sequence[int]) -> np.ndarray:
        """#V distances along the edges from the nearest of the sources; inf in a component that has
        none. O(#V log #V)."""
        sources = np.ascontiguousarray(sources, np.int32)
        distances = np.empty(self.vertex_count)
        native.library().tug_find_distances(self._pointer, sources, len(sources), distances, None)
        return distances

    def nearest_sources(self, sources: Sequence[int]) -> np.ndarray:
        """#V, which of the sources, counted from 0, is nearest along the edges; -1 in a component
        that has none. O(#V log #V)."""
        sources = np.ascontiguousarray(sources, np.int32)
        distances, nearest = np.empty(self.vertex_count), np.empty(self.vertex_count, np.int32)
        native.library().tug_find_distances(
            *(self._pointer, sources, len(sources), distances),
            nearest.ctypes.data_as(POINTER(c_int32)),
        )
        return nearest

    def areas(self) -> np.ndarray:
        """#V Voronoi areas, which sum to the area of the mesh. O(#F)."""
        areas = np.empty(self.vertex_count)
        native.library().tug_find_areas(self._pointer, areas)
        return areas

    def half_cotangents(self) -> np.ndarray:
        """#F by 3, of the angle at each corner: the weight of the edge opposite of it. O(#F)."""
        half_cotangents = np.empty((self.triangle_count, 3))
        native.library().tug_get_cotangents(self._pointer, half_cotangents)
        return half_cotangents

    def normals(self, positions: np.ndarray) -> np.ndarray:
        """#V by 3 unit normals at some positions, #V by 3, the triangles' weighted by their angles;
        zero where there is none. O(#F)."""
        positions = as_matrix(positions, np.float64, rows=self.vertex_count)
        if positions.shape[1] != 3:
            raise ValueError(f"positions must be {self.vertex_count} by 3, not {positions.shape}")
        normals = np.empty_like(positions)
        native.library().tug_find_normals(self._pointer, positions, normals)
        return normals


@dataclass(frozen=True)
class Rows:
    """Sparse constraint rows, #H by #V: row r holds values[starts[r]:starts[r + 1]] at the vertices
    of the same places."""

    starts: np.ndarray
    vertices: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        for name, dtype in ("starts", np.int32), ("vertices", np.int32), ("values", np.float64):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype))

    @classmethod
    def pin(cls, vertices: Sequence[int]) -> Self:
        """One row for each vertex: its position is the target."""
        return cls.combine([([vertex], [1.0]) for vertex in vertices])

    @classmethod
    def combine(cls, rows: Sequence[tuple[Sequence[int], Sequence[float]]]) -> Self:
        """One row for each (vertices, values): the sum of values times positions is the target."""
        for vertices, values in rows:
            if len(vertices) != len(values):
                raise ValueError(f"a row has {len(vertices)} vertices but {len(values)} values")
        return cls(
            offsets([vertices for vertices, _ in rows]),
            np.array([vertex for vertices, _ in rows for vertex in vertices]),
            np.array([value for _, values in rows for value in values]),
        )

    @classmethod
    def discs(cls, mesh: Mesh, vertices: Sequence[int], radius: float | Sequence[float]) -> Self:
        """One row for each vertex: the mean position of all that is no farther from it along the
        edges than `radius`, one for all or one for each, by Voronoi area. O(#V log #V) a vertex."""
        areas, rows = mesh.areas(), []
        distances = {vertex: mesh.distances([vertex]) for vertex in dict.fromkeys(vertices)}
        for vertex, reach in np.broadcast(vertices, radius):
            near = np.flatnonzero(distances[vertex] <= reach)
            if not len(near):
                raise ValueError(f"the disc around vertex {vertex} has a radius of {reach}")
            rows.append((near, areas[near] / areas[near].sum()))
        return cls.combine(rows)

    @classmethod
    def laplacian(cls, mesh: Mesh, vertices: Sequence[int]) -> Self:
        """One row for each vertex: its Laplacian coordinates, (L q)_v over its Voronoi area. They
        are zero where the surface is flat, else the normal times the sum of the principal
        curvatures, outwards on a sphere. O(#F) a row."""
        areas, half_cotangents, rows = mesh.areas(), mesh.half_cotangents(), []
        one, other = mesh.triangles[:, [1, 2, 0]], mesh.triangles[:, [2, 0, 1]]
        for vertex in vertices:
            here, there = one == vertex, other == vertex
            if not here.any():
                raise ValueError(f"there is no vertex {vertex}")
            weights = np.concatenate([half_cotangents[here], half_cotangents[there]])
            weights /= areas[vertex]
            around = np.concatenate([other[here], one[there]])
            neighbours, place = np.unique(around, return_inverse=True)
            values = -np.bincount(place, weights)
            rows.append(([vertex, *neighbours], [weights.sum(), *values]))
        return cls.combine(rows)

    def of(self, positions: np.ndarray) -> np.ndarray:
        """What the rows make of positions (#V by k): #H by k."""
        found = np.zeros((len(self), positions.shape[1]))
        row = np.repeat(np.arange(len(self)), np.diff(self.starts))
        np.add.at(found, row, self.values[:, None] * positions[self.vertices])
        return found

    def __len__(self) -> int:
        return len(self.starts) - 1


class Points(Owner):
    """Points in order of place, a k-d tree: count by 1 to 6. O(count log count)."""

    def __init__(self, points: np.ndarray) -> None:
        points = as_matrix(points, np.float64)
        self.dimension = points.shape[1]
        out = POINTER(native.tug_points)()
        native.library().tug_create_points(points, *points.shape, byref(out))
        super().__init__(Memory(out, native.library().tug_destroy_points))

    def nearest(self, queries: np.ndarray, limit: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """For each query (count by the points' dimension) number and distance of the nearest point
        no farther than `limit`, of several the first; -1 and inf where there is none."""
        queries = as_matrix(queries, np.float64)
        if queries.shape[1] != self.dimension:
            raise ValueError(f"queries must have {self.dimension} columns, not {queries.shape[1]}")
        numbers, distances = np.empty(len(queries), np.int32), np.empty(len(queries))
        native.library().tug_find_nearest(
            self._pointer, queries, len(queries), limit, numbers, distances
        )
        return numbers, distances


def as_shapes(mesh: Mesh, shapes: np.ndarray) -> np.ndarray:
    shapes = np.ascontiguousarray(shapes, np.float64)
    if shapes.ndim != 3 or shapes.shape[1:] != (mesh.vertex_count, mesh.dimension):
        raise ValueError(
            f"shapes must be #S by {mesh.vertex_count} by {mesh.dimension}, not {shapes.shape}"
        )
    return shapes


def as_groups(mesh: Mesh, groups: np.ndarray) -> np.ndarray:
    groups = np.ascontiguousarray(groups, np.int32)
    if groups.shape != (mesh.triangle_count,):
        raise ValueError(f"groups must be #F = {mesh.triangle_count} numbers")
    return groups
