# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting a body to a scan: shape completion and partial registration (F, section 5).

A few features give a first pose. From then on every vertex looks for the nearest point of the scan
that faces the same way, and the body is posed anew with what was found, again and again (iterated
closest points), while its examples keep it a body. What holds it are soft rows (F 5): the features,
and the mean positions of patches of the surface, each as firmly as its vertices have matches.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from ..geometry import Mesh, Rows
from ..native import Progress
from .body import Body
from .features import Features
from .matching import OrientedPoints
from .scan import Scan

# tug_change_rows takes no less: a patch for which nothing was found stays about where it is unless
# others pull, so that a part of the mesh of which nothing was found at all stays too.
LOOSE = 1e-6
FIRMEST = 1e3  # and no more

PATIENCE = 10  # rounds without a shorter move than before

# Of all firmness, how much may have gone from patches to others before the rows are changed, which
# takes far longer than a solve. Matches come and go all the time, but few of them.
STALE = 0.1


@dataclass(frozen=True)
class Settings:
    """How vertices and points of the scan find each other, and when they have.

    reach: what is farther is not matched, in parts of the root of the body's area. angle: nor what
    faces another way by more, in degrees below 90; None: normals do not matter. vertices: at most
    so many look for a match. patches: into so many they are put together, at most. firmness:
    beta_lc of (F 10) for a body whose vertices all have a match; features: for each of the
    features' rows. A fit has converged when a round moves the vertices by less than the tolerance,
    in the root mean square and parts of the root of the area.
    """

    reach: float = 0.1
    angle: float | None = 60.0
    vertices: int = 5000
    patches: int = 200
    firmness: float = 1000.0
    features: float = 10.0
    tolerance: float = 3e-4
    max_rounds: int = 50

    def __post_init__(self) -> None:
        for name in "reach", "vertices", "patches", "firmness", "features", "tolerance":
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name):g}: it must be above 0")
        if self.angle is not None and not 0 < self.angle < 90:
            raise ValueError(f"the angle is {self.angle:g} degrees: it must be between 0 and 90")
        if self.features > FIRMEST:
            raise ValueError(f"features is {self.features:g}: it must be at most {FIRMEST:g}")
        if self.max_rounds < 0:
            raise ValueError("the number of rounds cannot be below 0")


@dataclass(frozen=True)
class Registration:
    """A body fitted to a scan.

    positions: #V by 3. points: #V, for each vertex the point of the scan that is its match, -1
    where it has none. vertices: #P, for each point of the scan the vertex nearest to it, -1 where
    none is within reach. distance: root mean square between vertices and their matches. covered:
    the part of the body's area that has a match.
    """

    positions: np.ndarray
    points: np.ndarray
    vertices: np.ndarray
    distance: float
    covered: float
    rounds: int
    converged: bool


def register(
    body: Body,
    scan: Scan,
    features: Features | None = None,
    *,
    start: np.ndarray | None = None,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Registration:
    """Pose the body so that it fits the scan, and tell which vertex is which point.

    features: where some places of the body are on the scan; start: #V by 3 positions that are near
    already, needed where there are no features. Seconds at 10,000 vertices.
    """
    settings = settings or Settings()
    _check(body, scan, features, start, settings)
    if start is None:
        start = features.pose(body, settings.features)
    return _Fit(body, scan, features, settings).run(np.array(start, np.float64), progress)


class _Fit:
    """One body and one scan."""

    def __init__(
        self, body: Body, scan: Scan, features: Features | None, settings: Settings
    ) -> None:
        self.body, self.features, self.settings = body, features, settings
        self.areas = body.mesh.areas()
        self.unit = np.sqrt(self.areas.sum())
        self.scan, self.edge = self._oriented(scan.points, scan.normals), scan.edge
        # The same in every fit, and not along the order of the vertices, which may mean something.
        shuffled = np.random.default_rng(0).permutation(len(self.areas))
        self.looking = np.sort(shuffled[: settings.vertices])
        self.patch = _patches(body.mesh, settings.patches)
        self.rows = self._rows()
        self.held = ExitStack()  # the solver of these rows
        self.solver, self.firmness = None, None

    def run(self, positions: np.ndarray, progress: Progress | None) -> Registration:
        with self.held:
            return self._run(positions, progress)

    def _run(self, positions: np.ndarray, progress: Progress | None) -> Registration:
        """Rounds until the pose stays where it is, or has ceased to come nearer to that: matches
        may go to and fro for ever."""
        moves: list[float] = []
        while not self._settled(moves):
            if progress:
                progress(f"fit, round {len(moves) + 1}", len(moves) / self.settings.max_rounds)
            before, positions = positions, self._improved(positions)
            squares = np.sum((positions - before) ** 2, axis=1)
            moves.append(np.sqrt(squares @ self.areas) / self.unit**2)
        converged = bool(moves) and moves[-1] <= self.settings.tolerance
        return self._result(positions, len(moves), converged)

    def _settled(self, moves: list[float]) -> bool:
        if moves and moves[-1] <= self.settings.tolerance:
            return True
        stuck = len(moves) > PATIENCE and min(moves[-PATIENCE:]) >= min(moves[:-PATIENCE])
        return stuck or len(moves) == self.settings.max_rounds

    def _result(self, positions: np.ndarray, rounds: int, converged: bool) -> Registration:
        surface = self._surface(positions, slice(None))
        points, distances = self._match(surface)
        area = np.where(points >= 0, self.areas, 0)
        covered = area.sum()
        squares = np.where(points >= 0, distances, 0) ** 2
        return Registration(
            positions=positions,
            points=points,
            vertices=surface.nearest(self.scan)[0],
            distance=float(np.sqrt(area @ squares / covered)) if covered else np.inf,
            covered=float(covered / self.unit**2),
            rounds=rounds,
            converged=converged,
        )

    def _improved(self, positions: np.ndarray) -> np.ndarray:
        """The pose that has each patch where its vertices' matches are, as far as they have any."""
        points, _ = self._match(self._surface(positions, self.looking))
        vertices, points = self.looking[points >= 0], points[points >= 0]
        if not len(vertices):
            raise ValueError(
                "no point of the scan is near the body and faces the same way: give features or a "
                "better start, turn the scan's normals outwards, or allow a longer reach"
            )
        ways = self.scan.points[points] - positions[vertices]
        weight = self._sums(vertices, self.areas[vertices])
        mean = self._sums(vertices, self.areas[vertices, None] * ways)
        mean /= np.where(weight > 0, weight, 1)[:, None]
        there = self.rows.of(positions)[-len(mean) :]
        part = weight / self.areas[self.looking].sum()
        firmness = np.clip(self.settings.firmness * part, LOOSE, FIRMEST)
        return self._posed(there + mean, firmness)

    def _posed(self, targets: np.ndarray, firmness: np.ndarray) -> np.ndarray:
        """With targets and firmness of the patches."""
        if self.features is not None:
            held = np.full(len(self.features.places), self.settings.features)
            targets = np.concatenate([self.features.places, targets])
            firmness = np.concatenate([held, firmness])
        if self.solver is None or self._stale(firmness):
            self.held.close()
            self.solver = self.held.enter_context(self.body.solver(self.rows, firmness))
            self.firmness = firmness
        self.solver.solve(targets)
        return self.solver.positions()

    def _stale(self, firmness: np.ndarray) -> bool:
        return np.abs(firmness - self.firmness).sum() > STALE * firmness.sum()

    def _match(self, surface: OrientedPoints) -> tuple[np.ndarray, np.ndarray]:
        fewer = min(len(surface.points), len(self.scan.points))
        points, distances = self.scan.mutual(surface, self.unit / np.sqrt(fewer))
        stray = (points >= 0) & self.edge[points]
        return np.where(stray, -1, points), np.where(stray, np.inf, distances)

    def _surface(self, positions: np.ndarray, vertices: np.ndarray | slice) -> OrientedPoints:
        normals = self.body.mesh.normals(positions)
        return self._oriented(positions[vertices], normals[vertices])

    def _oriented(self, points: np.ndarray, normals: np.ndarray | None) -> OrientedPoints:
        reach = self.settings.reach * self.unit
        return OrientedPoints(points, normals, reach, self.settings.angle)

    def _sums(self, vertices: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Of values at vertices over each patch."""
        sums = np.zeros((self.patch.max() + 1, *values.shape[1:]))
        np.add.at(sums, self.patch[vertices], values)
        return sums

    def _rows(self) -> Rows:
        """Those of the features, then the mean position of each patch."""
        patches = [np.flatnonzero(self.patch == number) for number in range(self.patch.max() + 1)]
        pins = () if self.features is None else self.features.vertices
        return Rows.combine(
            [([vertex], [1.0]) for vertex in pins]
            + [(part, self.areas[part] / self.areas[part].sum()) for part in patches]
        )


def _patches(mesh: Mesh, count: int) -> np.ndarray:
    """For each vertex which of at most `count` spread vertices is nearest along the surface."""
    centres = mesh.spread(min(count, mesh.vertex_count))
    patch = mesh.nearest_sources(centres)
    if (patch < 0).any():
        raise ValueError(
            f"the mesh has {mesh.components().max() + 1} parts that are not connected, and can be "
            f"fitted by {count} patches at most: join parts or delete small ones"
        )
    return patch


def _check(
    body: Body,
    scan: Scan,
    features: Features | None,
    start: np.ndarray | None,
    settings: Settings,
) -> None:
    if body.mesh.dimension != 3:
        raise ValueError("only bodies in space can be fitted to a scan, this one is flat")
    if settings.angle is not None and scan.normals is None:
        raise ValueError(
            "the scan has no normals, which tell the sides of thin parts from each other: give "
            "them, or give the scan as a mesh, or set `angle` to None to do without"
        )
    if start is None and features is None:
        raise ValueError("nothing tells where the body is: give features, or a pose to start from")
    if start is not None and (np.shape(start) != body.rest.shape or not np.isfinite(start).all()):
        raise ValueError(f"the start must be {len(body.rest)} by 3 finite positions")
