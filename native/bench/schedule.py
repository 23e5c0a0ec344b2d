# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's whole way from rows to a pose, on eigenfunctions, and what is left out of it one at a time:
the ablations of its Figure 8."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from library import (
    Dictionary,
    Form,
    Mesh,
    Rows,
    RowStart,
    SolveInfo,
    Solver,
    compute_eigenfunctions,
    find_rotations,
)
from rigs import Rig

SMALL = 4  # eigenfunctions of the start
SPARSITY = 1e-4
ROUNDS = 10  # of one reference shape, as in the schedule


class Schedule:
    """The rotations of the elastic net's pose (F 23), then ten rounds on the examples' dictionary;
    without `start` from cold, without `scale` in the examples' size."""

    def __init__(self, rig: Rig, *, start: bool = True, scale: bool = True) -> None:
        model = rig.model(Dictionary.EIGENFUNCTIONS)
        self._solver = Solver(model, form=Form.CLOSEST, scale=int(scale))
        self._start = row_start(rig) if start else None

    def solve(self, targets: np.ndarray) -> SolveInfo:
        rotations = self._start.rotations(targets) if self._start else None
        return self._solver.solve(targets, rotations)

    def positions(self) -> np.ndarray:
        return self._solver.positions()

    def close(self) -> None:
        self._solver.close()


@dataclass(frozen=True)
class Outcome:
    converged: bool
    rounds: int


class OneReference:
    """The rest shape's energy alone in the dictionary of all, by rounds on the whole mesh."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self._start = rig, row_start(rig)
        self._solver = Solver(rig.model(Dictionary.EIGENFUNCTIONS))
        sizes = self._solver.sizes
        self._blend = np.eye(sizes.shapes)[np.zeros(sizes.groups, int)]

    def solve(self, targets: np.ndarray) -> Outcome:
        groups = self._rig.functions(Dictionary.EIGENFUNCTIONS).groups
        rotations = self._start.rotations(targets)
        with Mesh(self._rig.shapes[0], self._rig.triangles) as mesh:
            for _ in range(ROUNDS):
                self._solver.pose(targets, self._blend, rotations)
                rotations = find_rotations(mesh, self._rig.shapes, groups, self.positions())
        return Outcome(False, ROUNDS)

    def positions(self) -> np.ndarray:
        return self._solver.positions()

    def close(self) -> None:
        self._solver.close()


def row_start(rig: Rig) -> RowStart:
    """From the rows alone, on a few eigenfunctions."""
    groups = rig.functions(Dictionary.EIGENFUNCTIONS).groups
    mesh = Mesh(rig.shapes[0], rig.triangles)
    values, functions, _ = compute_eigenfunctions(mesh, SMALL)
    rows = Rows.pin(rig.handles)
    return RowStart(mesh, rig.shapes, functions, values**2, rows, groups, sparsity=SPARSITY)


ABLATIONS = {
    "fbt": Schedule,
    "fbt_one_example": lambda rig: Schedule(rig.with_shapes(rig.shapes[:1])),
    "fbt_one_reference": OneReference,
    "fbt_no_scale": lambda rig: Schedule(rig, scale=False),
    "fbt_no_start": lambda rig: Schedule(rig, start=False),
}
