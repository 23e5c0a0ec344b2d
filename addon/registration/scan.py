# SPDX-License-Identifier: GPL-3.0-or-later
"""What a body is fitted to: points of a surface, whole or in part, with their normals."""

from __future__ import annotations

from typing import Self

import numpy as np

from ..geometry import Mesh

# Unit lengths may be off by this, after a file of few digits.
UNIT_TOLERANCE = 1e-2


class Scan:
    """Points #P by 3 of a surface.

    normals: #P by 3, unit and outwards, or None; a point of normal zero is matched with nothing.
    mesh: what the points are the vertices of, or None for a cloud of points. edge: #P, whether the
    surface ends there, and what is nearest to the point may be missing; False in a cloud.
    """

    def __init__(
        self, points: np.ndarray, normals: np.ndarray | None = None, mesh: Mesh | None = None
    ) -> None:
        self.points, self.normals, self.mesh = _checked("points", points), None, mesh
        if not len(self.points):
            raise ValueError("the scan is empty: there is nothing to fit to")
        self.edge = np.zeros(len(self.points), bool)
        if mesh is not None:
            self.edge[_border(mesh.triangles)] = True
        if normals is not None:
            self.normals = _checked("normals", normals)
            self._check_normals()

    @classmethod
    def of_mesh(cls, vertices: np.ndarray, triangles: np.ndarray) -> Self:
        """The vertices of a mesh: holes and loose parts do not matter."""
        vertices = _checked("points", vertices)
        if not len(vertices):
            raise ValueError("the scan is empty: there is nothing to fit to")
        if not len(triangles):
            raise ValueError("the scan has no triangles: give its points, with their normals")
        mesh = Mesh(vertices, triangles)
        return cls(vertices, mesh.normals(vertices), mesh)

    def _check_normals(self) -> None:
        if self.normals.shape != self.points.shape:
            raise ValueError(f"there are {len(self.points)} points but {len(self.normals)} normals")
        lengths = np.linalg.norm(self.normals, axis=1)
        if bad := np.count_nonzero((np.abs(lengths - 1) > UNIT_TOLERANCE) & (lengths > 0)):
            raise ValueError(f"{bad} normals of the scan are not of length one: divide them by it")
        if not lengths.any():
            raise ValueError("no point of the scan has a normal: its triangles have no area")


def _border(triangles: np.ndarray) -> np.ndarray:
    """Vertices of edges that have one triangle."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    return edges[uses == 1].ravel()


def _checked(name: str, array: np.ndarray) -> np.ndarray:
    array = np.ascontiguousarray(array, np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"the {name} of a scan must be #P by 3, not {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise ValueError(
            f"{len(bad)} {name} of the scan are not finite, the first is number {bad[0]}: "
            "leave them out"
        )
    return array
