# SPDX-License-Identifier: GPL-3.0-or-later
"""Which point belongs to which row, where that is not known: four feet, and four points.

The matching whose pose has the least objective is taken for the right one (F, section 5). Where
there are not too many, all are tried. Else a search (A*) leaves out what cannot become the best:
rows that are let go lower the least objective, so that a part of a matching bounds what it becomes.

That bound holds for minima over all poses. A solve finds a local one, and the steady form's priors
follow the targets, so that letting a row go may raise what a solve finds. The search is told to
expect that up to a margin; it finds the best matching wherever the margin is enough, and nothing
proves that it always is.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import prod

import numpy as np

from ..native import ERROR_HANDLES, Progress, TugError
from ..placing import leaves_turn_open
from ..solver import Solver

TRIED = 720  # matchings that are all tried, in a few seconds: six feet, say

# How far a part's objective may be above that of what it becomes. It is by half a percent at most,
# in every form, on the creature of the sample scenes with its legs exchanged in all ways.
MARGIN = 0.05

FEW = 6  # matchings left of a part that the search tries outright


@dataclass(frozen=True)
class Correspondence:
    """The best matching: `points[order]` are the targets of the rows, with this objective. solves:
    how many it took."""

    order: np.ndarray
    objective: float
    solves: int


def find_correspondence(
    solver: Solver,
    points: np.ndarray,
    groups: Sequence[Sequence[int]],
    *,
    progress: Progress | None = None,
) -> Correspondence:
    """Match points with rows that may be exchanged for each other.

    points: #H by k, in the order of the rows, but for those of the rows in one group, which may
    stand in any order among themselves. groups: numbers of rows, each in one group at most. All
    rows are pinned, also afterwards, and the solver is left with the best pose.

    Up to TRIED matchings the objective is the least of all, each of them solved for. With more it
    is where no part of the best is above it by more than MARGIN, for far fewer solves as a rule;
    where points tell nothing until all are placed, a third more than there are matchings.
    """
    points = np.ascontiguousarray(points, np.float64)
    _check(solver, points, groups)
    search = _Search(solver, points, groups)
    try:
        return search.try_all(progress) if search.matchings <= TRIED else search.run(progress)
    finally:
        solver.set_firmness(np.full(len(points), np.inf))
        if search.best is not None:
            solver.solve(points[search.best])


class _Search:
    """A partial matching is a tuple of points, those of the first of the exchangeable rows."""

    def __init__(self, solver: Solver, points: np.ndarray, groups: Sequence[Sequence[int]]) -> None:
        self.solver, self.points = solver, points
        self.rows = np.array(list(chain(*groups)), int)
        # Of each of these rows: its points, and how many of them the rows before it leave.
        self.candidates = [sorted(group) for group in groups for _ in group]
        self.choices = [left for group in groups for left in range(len(group), 0, -1)]
        self.matchings = prod(self.choices)
        self.solves, self.best = 0, None

    def try_all(self, progress: Progress | None) -> Correspondence:
        """Of equal ones the first, as the search takes it."""
        found = []
        for matching in self._extended((), len(self.rows)):
            if progress:
                progress("match points", self.solves / self.matchings)
            found.append((self._objective(matching), matching))
        return self._result(*min(found))

    def run(self, progress: Progress | None) -> Correspondence:
        open_parts = [(self._objective(()), ())]  # what they become has no lower objective
        furthest = 0
        while True:
            bound, part = heapq.heappop(open_parts)
            furthest = max(furthest, len(part))
            if progress:
                progress("match points", furthest / max(len(self.rows), 1))
            if len(part) == len(self.rows):
                return self._result(bound, part)
            for longer in self._longer(part):
                heapq.heappush(open_parts, (max(bound, self._objective(longer)), longer))

    def _result(self, objective: float, matching: tuple[int, ...]) -> Correspondence:
        self.best = self._order(matching)
        return Correspondence(self.best, objective, self.solves)

    def _longer(self, part: tuple[int, ...]) -> list[tuple[int, ...]]:
        """With a row more, and all that leave no choice; with all rows where few matchings are
        left, whose parts would take about as many solves."""
        few = prod(self.choices[len(part) :]) <= FEW
        length = len(part) + 1
        while length < len(self.rows) and (few or self.choices[length] == 1):
            length += 1
        return self._extended(part, length)

    def _extended(self, part: tuple[int, ...], length: int) -> list[tuple[int, ...]]:
        """All parts of so many rows that begin with this one."""
        parts = [part]
        for candidates in self.candidates[len(part) : length]:
            parts = [(*one, point) for one in parts for point in candidates if point not in one]
        return parts

    def _order(self, part: tuple[int, ...]) -> np.ndarray:
        order = np.arange(len(self.points))
        order[self.rows[: len(part)]] = part
        return order

    def _objective(self, part: tuple[int, ...]) -> float:
        """Of a whole matching; a bound below it of a part."""
        firmness = np.full(len(self.points), np.inf)
        firmness[self.rows[len(part) :]] = 0
        self.solves += 1
        try:
            self.solver.set_firmness(firmness)
            objective = self.solver.solve(self.points[self._order(part)]).objective
            return objective if len(part) == len(self.rows) else (1 - MARGIN) * objective
        except TugError as error:
            if error.code == ERROR_HANDLES and len(part) < len(self.rows):
                return 0.0  # a part of the mesh is held by none of these rows yet
            raise


def _check(solver: Solver, points: np.ndarray, groups: Sequence[Sequence[int]]) -> None:
    wanted = (solver.sizes.rows, solver.sizes.dimension)
    if points.shape != wanted:
        raise ValueError(f"points must be {wanted[0]} by {wanted[1]}, not {points.shape}")
    if not np.isfinite(points).all():
        raise ValueError("points must be finite: leave out the rows of those that are not known")
    rows = list(chain(*groups))
    if len(set(rows)) < len(rows):
        raise ValueError("a row is in two groups, or twice in one")
    if bad := [row for row in rows if not 0 <= row < len(points)]:
        raise ValueError(f"there is no row {bad[0]}, only 0 to {len(points) - 1}")
    if leaves_turn_open(points):
        raise ValueError(
            "the points are on one line, or too few to place the body, so that it may turn and "
            "exchange them at no cost: add some beside the line"
        )
