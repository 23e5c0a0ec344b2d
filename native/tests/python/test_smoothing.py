# SPDX-License-Identifier: GPL-3.0-or-later
"""Averages of solutions over time, and the poses that are made of them."""

from __future__ import annotations

import numpy as np
import pytest
from test_solver import HANDLES, LENGTH, bent, strip

from addon.dictionaries import Dictionary
from addon.native import TugError
from addon.smoothing import Solution, average, reach
from addon.solver import Solver, make_solver


@pytest.fixture(params=[2, 3], ids=["2D", "3D"])
def shapes(request) -> np.ndarray:
    vertices, _ = strip(request.param)
    return np.stack([vertices, bent(vertices, 1.0), bent(vertices, -1.5)])


@pytest.fixture
def solver(shapes) -> Solver:
    """On the handles' functions, whose edge groups are as wide as the strip: in space smaller ones
    would flip about the line of the handles."""
    with make_solver(shapes, strip()[1], HANDLES, dictionary=Dictionary.HANDLES) as solver:
        yield solver


def solutions(solver: Solver, path: np.ndarray) -> list[Solution]:
    found = []
    for targets in path:
        solver.solve(targets)
        found.append(Solution(targets, solver.blend(), solver.rotations()))
    return found


def shown(solver: Solver, given: Solution) -> np.ndarray:
    solver.pose(given.targets, given.blend, given.rotations)
    return solver.positions()


def shaken(shapes: np.ndarray, frames: int) -> np.ndarray:
    """Handles from one example to another in a moment, with a tremble: #frames by #H by k."""
    random = np.random.default_rng(5)
    share = (np.arange(frames) >= frames // 2)[:, None, None]
    path = np.where(share, shapes[1, HANDLES], shapes[2, HANDLES])
    return path + 0.05 * random.standard_normal(path.shape)


def test_the_pose_of_a_solution_is_the_solved_one(solver, shapes):
    targets = shapes[1, HANDLES] + 0.2
    (solution,) = solutions(solver, targets[None])
    solver.solve(targets)
    solved = solver.positions()
    np.testing.assert_allclose(shown(solver, solution), solved, atol=1e-9 * LENGTH)
    with pytest.raises(TugError, match="nothing has been solved"):
        solver.costs()


def test_a_still_average_is_what_stands_still(solver, shapes):
    (solution,) = solutions(solver, shapes[2, HANDLES][None] + 0.1)
    mean = average((2 * reach(1.5) + 1) * [solution], 1.5)
    np.testing.assert_allclose(mean.blend, solution.blend, atol=1e-12)
    np.testing.assert_allclose(mean.rotations, solution.rotations, atol=1e-12)


def test_averages_are_blends_and_rotations_and_meet_the_handles(solver, shapes):
    path = shaken(shapes, 2 * reach(2.0) + 1)
    mean = average(solutions(solver, path), 2.0)
    identity = np.broadcast_to(np.eye(shapes.shape[2]), mean.rotations.shape)
    np.testing.assert_allclose(mean.rotations @ mean.rotations.swapaxes(2, 3), identity, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(mean.rotations), 1, atol=1e-12)
    np.testing.assert_allclose(mean.blend.sum(axis=1), 1)
    assert mean.blend.min() >= 0
    posed = shown(solver, mean)
    np.testing.assert_allclose(posed[HANDLES], path[reach(2.0)], atol=1e-9)


def test_averages_tremble_less(solver, shapes):
    """Blends and rotations change less from frame to frame, at the jump and beside it."""
    smoothing, frames = 2.0, 40
    found = solutions(solver, shaken(shapes, frames))
    width = 2 * reach(smoothing) + 1
    means = [average(found[i : i + width], smoothing) for i in range(frames - width + 1)]

    def largest_step(given: list[Solution], part: str) -> float:
        return np.abs(np.diff([getattr(one, part) for one in given], axis=0)).max()

    inner = found[reach(smoothing) : frames - reach(smoothing)]
    assert largest_step(means, "blend") < 0.3 * largest_step(inner, "blend")
    assert largest_step(means, "rotations") < 0.5 * largest_step(inner, "rotations")


def test_what_cannot_be_posed_is_refused(solver, shapes):
    (one,) = solutions(solver, shapes[:1, HANDLES])
    with pytest.raises(TugError, match="blend"):
        solver.pose(one.targets, 2 * one.blend, one.rotations)
    with pytest.raises(TugError, match="shape 1 in group 2 is not a rotation"):
        rotations = one.rotations.copy()
        rotations[2, 1] *= 1.1
        solver.pose(one.targets, one.blend, rotations)
    with pytest.raises(ValueError, match="blend must be"):
        solver.pose(one.targets, one.blend[1:], one.rotations)
