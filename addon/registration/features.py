# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a body that are known on a scan: the rows that a registration starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry import Rows
from ..parts import find_floating
from .body import Body
from .scan import Scan

# Of the spread across the line that fits best to that along it, below which points are on a line.
COLLINEAR = 1e-3


@dataclass(frozen=True)
class Features:
    """Vertices of the body, #N, and their places on the scan, #N by 3; and the rows, with their
    targets, that hold the body there in a first pose: those vertices, or more around them."""

    vertices: np.ndarray
    places: np.ndarray
    rows: Rows
    targets: np.ndarray

    @classmethod
    def at_points(cls, vertices: Sequence[int], places: np.ndarray) -> Self:
        """Nothing but the places is known."""
        places = np.ascontiguousarray(places, np.float64)
        if places.shape != (len(vertices), 3):
            raise ValueError(
                f"there are {len(vertices)} features, their places must be as many by 3, not "
                f"{places.shape}"
            )
        return cls(np.array(vertices, int), places, Rows.pin(vertices), places)

    @classmethod
    def at_discs(
        cls,
        body: Body,
        vertices: Sequence[int],
        scan: Scan,
        points: Sequence[int],
        *,
        count: int = 10,
        radius: float = 0.15,
    ) -> Self:
        """Vertices of the body and, in the same order, of the scan, each with the mean positions of
        `count` geodesic discs around it, the largest of `radius` times the root of the body's area.

        They tell more than single points do, and the noise of a scan goes out. Around its features
        the scan must be whole. The defaults are those of F.
        """
        if scan.mesh is None:
            raise ValueError("only a scan with triangles has discs: give the features as points")
        if len(points) != len(vertices):
            raise ValueError(f"{len(vertices)} vertices cannot be {len(points)} points of the scan")
        reach = radius * np.sqrt(body.mesh.areas().sum())
        radii = np.tile(reach * np.arange(1, count + 1) / count, len(vertices))
        rows = Rows.discs(body.mesh, np.repeat(vertices, count), radii)
        there = Rows.discs(scan.mesh, np.repeat(points, count), radii)
        places = scan.points[np.array(points, int)]
        return cls(np.array(vertices, int), places, rows, there.of(scan.points))

    def pose(self, body: Body, firmness: float) -> np.ndarray:
        """#V by 3: the body held by these rows alone, with this firmness each, or pinned where it
        is inf. Raises ValueError where they are too few."""
        self._check(body)
        soft = None if firmness == np.inf else np.full(len(self.rows), firmness)
        with body.solver(self.rows, soft) as solver:
            solver.solve(self.targets)
            return solver.positions()

    def _check(self, body: Body) -> None:
        """Raises ValueError where they do not tell how the body lies in space."""
        last = len(body.rest) - 1
        if bad := [int(vertex) for vertex in self.vertices if not 0 <= vertex <= last]:
            raise ValueError(f"there is no vertex {bad[0]} for a feature, only 0 to {last}")
        if len(np.unique(self.vertices)) < len(self.vertices):
            raise ValueError("two features are at one vertex: move or leave out one of them")
        if not np.isfinite(self.places).all():
            raise ValueError("the features have places that are not finite: leave those out")
        if len(self.vertices) < 3:
            raise ValueError(
                f"at least three features are needed to place a body, there are "
                f"{len(self.vertices)}: add some, or give a pose to start from"
            )
        for where, points in (
            ("on the body", body.rest[self.vertices]),
            ("on the scan", self.places),
        ):
            spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
            if spread[1] <= COLLINEAR * spread[0]:
                raise ValueError(
                    f"the features are on one line {where}, so that the turn about it is open: add "
                    "one beside the line"
                )
        self._check_parts(body)

    def _check_parts(self, body: Body) -> None:
        """Raises ValueError where a part has no feature and moves by weights of its own."""
        vertex = find_floating(body.mesh, body.functions.weights, self.vertices)
        if vertex >= 0:
            parts = body.mesh.components().max() + 1
            raise ValueError(
                f"the mesh has {parts} parts that are not connected, and the one with vertex "
                f"{vertex} has no feature: give each part one"
            )
