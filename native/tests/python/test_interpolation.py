# SPDX-License-Identifier: GPL-3.0-or-later
"""In-betweens: exact at both ends, smooth between, and turning where straight lines would
shrink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from addon.geometry import Rows
from addon.interpolation import interpolate, power
from addon.registration.body import Body
from addon.smoothing import Solution
from addon.solver import Form, Solver
from sample_scenes import snake


def turn(angle: float, k: int = 3) -> np.ndarray:
    """About z, or in the plane."""
    matrix = np.eye(k)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return matrix


def random_turns(count: int) -> np.ndarray:
    left, _, right = np.linalg.svd(np.random.default_rng(0).normal(size=(count, 3, 3)))
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[..., None]
    return left @ right


def solution(solver: Solver, targets: np.ndarray) -> Solution:
    assert solver.solve(targets).converged
    return Solution(targets, solver.blend(), solver.rotations())


def shown(solver: Solver, given: Solution) -> np.ndarray:
    solver.pose(given.targets, given.blend, given.rotations)
    return solver.positions()


@pytest.mark.parametrize("exponent", [-1.0, 0.0, 0.5, 1.0])
def test_powers_of_rotations_are_those_of_their_eigenvalues(exponent):
    turns = random_turns(200)
    values, vectors = np.linalg.eig(turns)
    expected = (vectors * values[:, None] ** exponent) @ np.linalg.inv(vectors)
    np.testing.assert_allclose(power(turns, exponent), expected.real, atol=1e-12)


def test_no_turn_small_turns_and_half_turns_have_powers():
    np.testing.assert_allclose(power(np.eye(3), 0.3), np.eye(3), atol=1e-15)
    np.testing.assert_allclose(power(turn(1e-9), 0.5), turn(0.5e-9), atol=1e-16)
    half = power(np.diag([-1.0, 1.0, -1.0]), 0.5)
    np.testing.assert_allclose(half @ half, np.diag([-1.0, 1.0, -1.0]), atol=1e-14)
    np.testing.assert_allclose(power(turn(2.0, 2), 0.25), turn(0.5, 2), atol=1e-15)


@pytest.fixture(scope="module")
def fox(creature) -> tuple[Solver, Solution, Solution]:
    """A solver, and two poses between its examples."""
    vertices = list(creature.handles.values())
    solver = Body(creature.shapes[:5], creature.triangles).solver(Rows.pin(vertices))
    ends = [creature.shapes[number][vertices] for number in (5, 6)]
    return solver, solution(solver, ends[0]), solution(solver, ends[1])


@pytest.mark.parametrize("form", [Form.STEADY, Form.PAPER])
def test_both_ends_are_the_poses_themselves(creature, form):
    vertices = list(creature.handles.values())
    shapes, truth = creature.without("Stepping")
    solver = Body(shapes, creature.triangles, form=form).solver(Rows.pin(vertices))
    poses, ends = [], []
    for targets in (truth[vertices], 0.5 * (truth + shapes[1])[vertices]):
        solver.solve(targets)
        ends.append(Solution(targets, solver.blend(), solver.rotations()))
        poses.append(solver.positions())
    for share, pose in enumerate(poses):
        between = shown(solver, interpolate(*ends, share))
        np.testing.assert_allclose(between, pose, atol=1e-9)


def test_frames_follow_each_other_smoothly(fox):
    solver, start, end = fox

    def film(frames: int) -> np.ndarray:
        shares = np.linspace(0, 1, frames + 1)
        return np.stack([shown(solver, interpolate(start, end, share)) for share in shares])

    coarse, fine = film(8), film(16)
    np.testing.assert_array_equal(coarse, fine[::2])
    steps = np.linalg.norm(np.diff(coarse, axis=0), axis=2).mean(axis=1)
    assert steps.max() < 1.5 * steps.mean()
    bends = [np.abs(np.diff(frames, 2, axis=0)).max() for frames in (coarse, fine)]
    assert bends[1] == pytest.approx(bends[0] / 4, rel=0.25)  # of a smooth path


def test_rows_follow_the_path_they_are_given(fox):
    solver, start, end = fox
    path = 0.5 * (start.targets + end.targets) + [0.0, 0.0, 0.1]
    between = interpolate(start, end, 0.5, path)
    np.testing.assert_array_equal(between.targets, path)
    assert np.isfinite(shown(solver, between)).all()


@pytest.mark.parametrize("angle", [0.5, 2.0, 3.1])
def test_a_body_that_only_turns_and_moves_does_so_on_the_way(fox, angle):
    solver, start, _ = fox
    pose, offset = shown(solver, start), np.array([1.0, -2.0, 0.5])
    middle = start.targets.mean(axis=0)
    turned = replace(
        start,
        targets=(start.targets - middle) @ turn(angle).T + middle + offset,
        rotations=turn(angle) @ start.rotations,
    )
    for share in (0.25, 0.5, 1.0):
        expected = (pose - middle) @ turn(share * angle).T + middle + share * offset
        np.testing.assert_allclose(
            shown(solver, interpolate(start, turned, share)), expected, atol=1e-9
        )


def test_a_snake_that_coils_keeps_its_length_better_than_on_straight_lines():
    sample = snake.sample()
    shapes = np.stack(list(sample.shapes.values()))[:, :, :2]
    vertices = list(sample.handles.values())
    solver = Body(shapes, sample.triangles()).solver(Rows.pin(vertices))
    straight, coiled = (solution(solver, shapes[number][vertices]) for number in (0, 2))
    free = np.zeros(len(vertices))
    free[len(vertices) // 2] = np.inf  # rotations alone tell the pose
    solver.set_firmness(free)
    spine = np.arange(4, shapes.shape[1], 9)

    def length(positions: np.ndarray) -> float:
        return np.linalg.norm(np.diff(positions[spine], axis=0), axis=1).sum()

    whole = length(shapes[0])
    turned = length(shown(solver, interpolate(straight, coiled, 0.5)))
    lines = length(0.5 * (shapes[0] + shapes[2]))
    assert abs(turned - whole) < 0.05 * whole < abs(lines - whole)


def test_what_cannot_be_interpolated_is_told(fox):
    _, start, end = fox
    with pytest.raises(ValueError, match="the share is 1.5: it must be from 0 to 1"):
        interpolate(start, end, 1.5)
    with pytest.raises(ValueError, match="both must be of one model"):
        interpolate(start, replace(end, blend=end.blend[1:]), 0.5)
