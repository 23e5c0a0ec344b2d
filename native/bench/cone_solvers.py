# SPDX-License-Identifier: GPL-3.0-or-later
"""(A 20) by the library and by ECOS, SCS and Clarabel, each asked for 1e-8.

Times include every solver's set-up, from matrices that are there; ECOS, SCS and Clarabel tell their
own, so that what their Python adds does not count. The library starts as in a solve, from each
group's cheapest shape.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_double, c_void_p
from dataclasses import dataclass

import clarabel
import ecos
import numpy as np
import scipy.sparse
import scs
from conic import ConeProgram, Instance
from library import native
from timing import bare_library, seconds_of

TOLERANCE = 1e-8
SCS_ITERATIONS = 20_000


@dataclass(frozen=True)
class Optimum:
    """What a solver found, and in what time."""

    objective: float
    seconds: float
    converged: bool


def evaluate(problem: ConeProgram, z: np.ndarray) -> float:
    """The objective at z."""
    return float(np.linalg.norm(problem.F @ z + problem.g) / np.sqrt(2) + problem.cost @ z)


def solve_by_tug(instance: Instance, repeats: int) -> Optimum:
    """From the instance's reduced form."""
    problem, n = instance.reduced, instance.groups * instance.shapes
    Q = np.ascontiguousarray(problem.F.T @ problem.F)
    c = np.ascontiguousarray(problem.F.T @ problem.g)
    cost, blend = np.ascontiguousarray(problem.cost), np.empty(n)
    Q_at, c_at, cost_at, blend_at = (c_void_p(a.ctypes.data) for a in (Q, c, cost, blend))
    start = np.zeros((instance.groups, instance.shapes))
    start[np.arange(instance.groups), cost.reshape(start.shape).argmin(axis=1)] = 1.0
    r, info = c_double(problem.g @ problem.g), native.tug_blend_info()
    function = bare_library().tug_minimise_blend

    def call() -> None:
        blend[:] = start.ravel()
        function(
            *(instance.groups, instance.shapes, Q_at, c_at, r, cost_at, c_double(1.0), 0),
            *(blend_at, byref(info)),
        )

    seconds = float(np.median(seconds_of(call, repeats)))
    return Optimum(evaluate(problem, blend), seconds, info.gap <= TOLERANCE * info.objective)


@dataclass(frozen=True)
class Cones:
    """min c^T x where the first rows of b - A x are zero, the next not negative, the last in a
    second-order cone; x is (t, z) with t >= |F z + g|."""

    c: np.ndarray
    A: scipy.sparse.csc_matrix
    b: np.ndarray
    zero: int
    positive: int
    cone: int


def to_cones(problem: ConeProgram) -> Cones:
    """The same problem as solvers want it."""
    size, count, n = len(problem.cost), len(problem.F), problem.blends
    nothing = np.zeros
    rows = [
        np.hstack([nothing((len(problem.A), 1)), problem.A]),
        np.hstack([nothing((n, 1 + size - n)), -np.eye(n)]),
        -np.eye(1, 1 + size),
        np.hstack([nothing((count, 1)), -problem.F]),
    ]
    return Cones(
        np.concatenate([[np.sqrt(0.5)], problem.cost]),
        scipy.sparse.csc_matrix(np.vstack(rows)),
        np.concatenate([problem.b, nothing(n + 1), problem.g]),
        len(problem.A),
        n,
        1 + count,
    )


def solve_by_ecos(cones: Cones) -> tuple[np.ndarray, float, bool]:
    found = ecos.solve(
        cones.c,
        cones.A[cones.zero :].tocsc(),
        cones.b[cones.zero :],
        {"l": cones.positive, "q": [cones.cone]},
        cones.A[: cones.zero].tocsc(),
        cones.b[: cones.zero],
        verbose=False,
        abstol=TOLERANCE,
        reltol=TOLERANCE,
        feastol=TOLERANCE,
    )
    info = found["info"]
    return found["x"], info["timing"]["runtime"], info["exitFlag"] == 0


def solve_by_scs(cones: Cones) -> tuple[np.ndarray, float, bool]:
    found = scs.solve(
        {"A": cones.A, "b": cones.b, "c": cones.c},
        {"z": cones.zero, "l": cones.positive, "q": [cones.cone]},
        verbose=False,
        eps_abs=TOLERANCE,
        eps_rel=TOLERANCE,
        max_iters=SCS_ITERATIONS,
    )
    info = found["info"]
    seconds = 1e-3 * (info["setup_time"] + info["solve_time"])
    return found["x"], seconds, info["status"] == "solved"


def solve_by_clarabel(cones: Cones) -> tuple[np.ndarray, float, bool]:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    kinds = [
        clarabel.ZeroConeT(cones.zero),
        clarabel.NonnegativeConeT(cones.positive),
        clarabel.SecondOrderConeT(cones.cone),
    ]
    nothing = scipy.sparse.csc_matrix((len(cones.c),) * 2)
    found = clarabel.DefaultSolver(nothing, cones.c, cones.A, cones.b, kinds, settings).solve()
    return np.array(found.x), found.solve_time, str(found.status) == "Solved"


PEERS: dict[str, Callable[[Cones], tuple[np.ndarray, float, bool]]] = {
    "ECOS": solve_by_ecos,
    "SCS": solve_by_scs,
    "Clarabel": solve_by_clarabel,
}


def solve_by_peer(name: str, problem: ConeProgram, repeats: int) -> Optimum:
    """One solver of PEERS on one form of an instance; the median of its times."""
    cones = to_cones(problem)
    runs = [PEERS[name](cones) for _ in range(repeats)]
    x, _, converged = runs[0]
    seconds = float(np.median([run[1] for run in runs]))
    return Optimum(evaluate(problem, x[1:]), seconds, converged)
