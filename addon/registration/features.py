# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a body that are known on a scan: the rows that a registration starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry import Rows
from ..placing import check_parts, check_vertices, leaves_turn_open
from .body import Body
from .scan import Scan


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
        if count < 1 or not radius > 0:
            raise ValueError(f"{count} discs of radius {radius:g}: both must be above 0")
        check_vertices(vertices, len(body.rest), "feature")
        check_vertices(points, len(scan.points), "feature's place on the scan")
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
        check_vertices(self.vertices, len(body.rest), "feature")
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
            if leaves_turn_open(points):
                raise ValueError(
                    f"the features are on one line {where}, so that the turn about it is open: add "
                    "one beside the line"
                )
        check_parts(body.mesh, body.functions.weights, self.vertices, "feature")
