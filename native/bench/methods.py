# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that poses a mesh from handle positions, behind one interface: Tug's forms, and the
methods it is compared with.

A method is made from (shapes, triangles, handles, weights, groups), the rest shape first; it has
solve(targets), with `converged` and `rounds` in its result, positions() and close().
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from data import Binding
from library import Form, Mesh, Model, Rows, SolveInfo, Solver, native

FORMS: dict[str, dict[str, float]] = {
    "amrap": {"form": Form.STEADY},
    "paper": {"form": Form.PAPER},
    "no_rotations": {"form": Form.NO_ROTATIONS},
    "no_costs": {"form": Form.STEADY, "lambda_": 0.0},
    "trust_region": {"form": Form.TRUST_REGION},
}
ONE_SHAPE = ("fast",)  # methods that see the rest shape only
NO_PEERS = "the library of the other methods was not built"


class Outcome(Protocol):
    """How a solve ended."""

    converged: bool
    rounds: int


class Method(Protocol):
    """See the module's text."""

    def solve(self, targets: np.ndarray) -> Outcome: ...

    def positions(self) -> np.ndarray: ...

    def close(self) -> None: ...


@dataclass
class Tally:
    """What Tug's own solves have certified: numbers of solves, and the worst of them.

    A gap is relative to the objective; where that is below a thousandth of the rest shape's
    diagonal (at an example it is zero, and rounding is all there is) it is in diagonals, and apart.
    """

    solves: int = 0
    unconverged: int = 0
    rises: int = 0  # solves whose objective rose beyond rounding though the form excludes it
    gap: float = 0.0
    where: str = ""  # the largest gap was seen
    gap_at_examples: float = 0.0

    def count(self, info: SolveInfo, form: Form, diagonal: float) -> None:
        """One more solve."""
        self.solves += 1
        self.unconverged += not info.converged and form != Form.PAPER
        self.rises += info.increase > 1e-12 * diagonal and form != Form.PAPER
        if info.objective >= 1e-3 * diagonal:
            self.gap = max(self.gap, info.gap / info.objective)
        else:
            self.gap_at_examples = max(self.gap_at_examples, info.gap / diagonal)

    def add(self, other: Tally, where: str = "") -> None:
        """The solves of another tally, and where they were."""
        if other.gap > self.gap:
            self.where = other.where or where
        self.solves += other.solves
        self.unconverged += other.unconverged
        self.rises += other.rises
        self.gap = max(self.gap, other.gap)
        self.gap_at_examples = max(self.gap_at_examples, other.gap_at_examples)


class Tug:
    """A form of Tug that keeps a tally."""

    def __init__(
        self,
        shapes: np.ndarray,
        triangles: np.ndarray,
        handles: np.ndarray,
        binding: Binding,
        **options: float,
    ) -> None:
        rows = Rows.pin(handles)
        with (
            Mesh(shapes[0], triangles) as mesh,
            Model(mesh, shapes, binding.weights, rows, binding.groups) as model,
        ):
            self.solver = Solver(model, **options)
        self.tally = Tally()
        self._form = Form(options.get("form", Form.STEADY))
        self._diagonal = float(np.linalg.norm(np.ptp(shapes[0], axis=0)))

    def solve(self, targets: np.ndarray) -> SolveInfo:
        info = self.solver.solve(targets)
        self.tally.count(info, self._form, self._diagonal)
        return info

    def positions(self) -> np.ndarray:
        return self.solver.positions()

    def close(self) -> None:
        self.solver.close()


def peers() -> list[str]:
    """Names of the methods that Tug is compared with; none where they were not built."""
    try:
        from baselines import METHODS, library

        library()
    except (ModuleNotFoundError, native.LibraryError):
        return []
    return list(METHODS)


def make(
    name: str, shapes: np.ndarray, triangles: np.ndarray, handles: np.ndarray, binding: Binding
) -> Method:
    """A method by its name. Raises KeyError where there is none of it."""
    if name in FORMS:
        return Tug(shapes, triangles, handles, binding, **FORMS[name])
    from baselines import METHODS

    return METHODS[name](shapes, triangles, handles, binding.weights, binding.groups)
