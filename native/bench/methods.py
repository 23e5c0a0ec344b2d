# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that poses a mesh from handle positions, behind one interface: Tug's forms, and the
methods it is compared with.

A method is made from a rig; it has solve(targets), with `converged` and `rounds` in its result,
positions() and close().
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from library import Dictionary, Form, SolveInfo, Solver, native
from rigs import Rig
from schedule import ABLATIONS

ENERGIES = {
    "steady": Form.STEADY,
    "average": Form.AVERAGE,
    "minimal": Form.MINIMAL,
    "closest": Form.CLOSEST,
}
DICTIONARIES = {
    "handles": Dictionary.HANDLES,
    "lbo": Dictionary.EIGENFUNCTIONS,
    "skeleton": Dictionary.SKELETON,
}
SOFT = 10.0  # how much stiffer than the surface soft rows are: beta_lc of (F 5), for all alike
DEFAULT = "steady_lbo"  # the pair of make_solver
AMRAP = "amrap"  # as its paper has it, but steady: on a bounded biharmonic function a handle


@dataclass(frozen=True)
class Choice:
    """What of Tug a method is: options of Solver, a dictionary, and the firmness of its rows."""

    options: dict[str, float]
    dictionary: Dictionary = Dictionary.HANDLES
    firmness: float = np.inf


# Every energy on every dictionary with pinned and with soft rows: steady_lbo, minimal_skeleton_soft
PAIRS = {
    f"{energy}_{dictionary}{ending}": Choice({"form": form}, kind, firmness)
    for energy, form in ENERGIES.items()
    for dictionary, kind in DICTIONARIES.items()
    for ending, firmness in (("", np.inf), ("_soft", SOFT))
}
FORMS = {
    AMRAP: Choice({"form": Form.STEADY}),
    "paper": Choice({"form": Form.PAPER}),
    "no_rotations": Choice({"form": Form.NO_ROTATIONS}),
    "no_costs": Choice({"form": Form.STEADY, "lambda_": 0.0}),
    "trust_region": Choice({"form": Form.TRUST_REGION}),
}
OWN = PAIRS | FORMS
UNSETTLED = (Form.PAPER, Form.AVERAGE, Form.MINIMAL, Form.CLOSEST)  # may end without coming to rest
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
        self.unconverged += not info.converged and form not in UNSETTLED
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
    """A form of Tug on a dictionary that keeps a tally."""

    def __init__(self, rig: Rig, choice: Choice = PAIRS[DEFAULT]) -> None:
        self.functions = rig.functions(choice.dictionary)
        self.solver = Solver(rig.model(choice.dictionary), **choice.options)
        if choice.firmness < np.inf:
            self.solver.set_firmness(np.full(len(rig.handles), choice.firmness))
        self.tally = Tally()
        self._form = Form(choice.options.get("form", Form.STEADY))
        self._diagonal = rig.diagonal

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


def make(name: str, rig: Rig) -> Method:
    """A method by its name; the others get the handles' weights. Raises KeyError where there is
    none of it."""
    if name in OWN:
        return Tug(rig, OWN[name])
    if name in ABLATIONS:
        return ABLATIONS[name](rig)
    from baselines import METHODS

    functions = rig.functions(Dictionary.HANDLES)
    given = (rig.shapes, rig.triangles, rig.handles, functions.weights, functions.groups)
    return METHODS[name](*given)
