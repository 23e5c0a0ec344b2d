# SPDX-License-Identifier: GPL-3.0-or-later
"""Points that belong to one of several rows: what the search finds is what trying all finds."""

from __future__ import annotations

from itertools import permutations, product
from types import SimpleNamespace

import numpy as np
import pytest

from addon.geometry import Rows
from addon.registration import correspondence
from addon.registration.body import Body
from addon.registration.correspondence import find_correspondence
from addon.solver import Form, Solver
from sample_scenes import snake

LEGS = ["Front Paw.L", "Front Paw.R", "Hind Paw.L", "Hind Paw.R"]


def posed(creature, left_out: str, **options) -> tuple[Solver, np.ndarray]:
    """A solver of the other shapes, and where the one left out has the handles."""
    shapes, truth = creature.without(left_out)
    vertices = list(creature.handles.values())
    return Body(shapes, creature.triangles, **options).solver(Rows.pin(vertices)), truth[vertices]


@pytest.fixture
def searched(monkeypatch):
    """However few the matchings are, they are searched rather than all tried."""
    monkeypatch.setattr(correspondence, "TRIED", 0)


def exhaustive(solver: Solver, points: np.ndarray, groups: list[list[int]]) -> tuple:
    """The best objective and its order, from a solve of every matching."""
    found = []
    for choice in product(*(permutations(group) for group in groups)):
        order = np.arange(len(points))
        for group, chosen in zip(groups, choice, strict=True):
            order[group] = chosen
        found.append((solver.solve(points[order]).objective, order.tolist()))
    return min(found)


@pytest.mark.parametrize("form", [Form.STEADY, Form.PAPER, Form.CLOSEST])
@pytest.mark.parametrize("left_out", ["Stepping", "Curled", "Sitting"])
def test_four_legs_are_told_apart_as_by_trying_all(searched, creature, left_out, form):
    solver, points = posed(creature, left_out, form=form)
    legs = [list(creature.handles).index(name) for name in LEGS]
    shuffle = np.arange(len(points))
    shuffle[legs] = np.random.default_rng(3).permutation(legs)
    found = find_correspondence(solver, points[shuffle], [legs])
    objective, order = exhaustive(solver, points[shuffle], [legs])
    assert found.order.tolist() == order
    assert found.objective == pytest.approx(objective, rel=1e-9)
    np.testing.assert_array_equal(points[shuffle][found.order], points)


def test_far_fewer_solves_are_needed_than_there_are_matchings(searched, creature):
    solver, points = posed(creature, "Stepping")
    names = list(creature.handles)
    groups = [
        [names.index(name) for name in LEGS],
        [names.index(name) for name in ("Head", "Crown", "Tail")],
    ]
    found = find_correspondence(solver, points, groups)
    assert found.order.tolist() == list(range(len(points)))
    assert found.solves < 144 / 3


def test_the_solver_is_left_pinned_with_the_best_pose(creature):
    solver, points = posed(creature, "Stepping")
    legs = [list(creature.handles).index(name) for name in LEGS]
    find_correspondence(solver, points[::-1][np.argsort(np.arange(10)[::-1])], [legs])
    left = solver.positions()
    solver.set_firmness(np.full(len(points), np.inf))
    solver.solve(points)
    np.testing.assert_array_equal(left, solver.positions())


STEPS = np.stack([np.arange(4.0), np.zeros(4)], axis=1)


class Oracle:
    """In the place of a solver of four rows: objectives by order, and one for all parts."""

    sizes = SimpleNamespace(rows=4, dimension=2)

    def __init__(self, objectives: dict[tuple, float], of_parts: float) -> None:
        self.objectives, self.of_parts, self.pinned = objectives, of_parts, True

    def set_firmness(self, firmness: np.ndarray) -> None:
        self.pinned = bool(np.isinf(firmness).all())

    def solve(self, targets: np.ndarray) -> SimpleNamespace:
        order = tuple(targets[:, 0].astype(int).tolist())
        return SimpleNamespace(objective=self.objectives[order] if self.pinned else self.of_parts)


@pytest.mark.parametrize("of_parts", [0.0, 0.5, 100.0])
def test_few_matchings_are_all_tried_whatever_their_parts_promise(of_parts):
    for best in permutations(range(4)):
        objectives = dict.fromkeys(permutations(range(4)), 2.0) | {best: 1.0}
        found = find_correspondence(Oracle(objectives, of_parts), STEPS, [[0, 1, 2, 3]])
        assert (tuple(found.order), found.objective, found.solves) == (best, 1.0, 24)


def test_the_search_finds_the_best_where_parts_are_above_it_by_no_more_than_the_margin(
    searched, monkeypatch
):
    monkeypatch.setattr(correspondence, "FEW", 1)
    just = 1.0 / (1.0 - correspondence.MARGIN)
    for best in permutations(range(4)):
        objectives = dict.fromkeys(permutations(range(4)), 1.01) | {best: 1.0}
        oracle = Oracle(objectives, 0.999 * just)
        found = find_correspondence(oracle, STEPS, [[0, 1, 2, 3]])
        assert tuple(found.order) == best


def test_rows_of_a_flat_snake_are_told_apart():
    sample = snake.sample()
    shapes = np.stack(list(sample.shapes.values()))[:, :, :2]
    vertices = list(sample.handles.values())
    solver = Body(shapes[:4], sample.triangles()).solver(Rows.pin(vertices))
    points = shapes[4][vertices]
    shuffled = points[[0, 3, 1, 2, 4]]
    found = find_correspondence(solver, shuffled, [[1, 2, 3]])
    np.testing.assert_array_equal(shuffled[found.order], points)


def test_a_part_that_only_exchangeable_rows_hold_is_matched(creature):
    shapes, truth = creature.without("Stepping")
    count = shapes.shape[1]
    two = np.concatenate([shapes, shapes + [3.0, 0, 0]], axis=1)  # side by side
    triangles = np.concatenate([creature.triangles, creature.triangles + count])
    names = ["Head", "Tail", "Front Paw.L", "Hind Paw.R"]
    pins = [creature.handles[name] for name in names]
    solver = Body(two, triangles).solver(Rows.pin([*pins, *(v + count for v in pins)]))
    points = np.concatenate([truth[pins], truth[pins] + [3.0, 0, 0]])
    found = find_correspondence(solver, points[[0, 1, 2, 3, 5, 7, 4, 6]], [[4, 5, 6, 7]])
    assert found.order.tolist() == [0, 1, 2, 3, 6, 4, 7, 5]


@pytest.fixture(scope="module")
def small() -> Solver:
    sample = snake.sample()
    shapes = np.stack(list(sample.shapes.values()))[:, :, :2]
    return Body(shapes, sample.triangles()).solver(Rows.pin(list(sample.handles.values())))


def test_without_groups_there_is_one_matching(small):
    points = np.random.default_rng(0).random((5, 2))
    found = find_correspondence(small, points, [])
    assert (found.order.tolist(), found.solves) == ([0, 1, 2, 3, 4], 1)


def test_an_exception_of_progress_cancels_and_leaves_the_solver_usable(small):
    def stop(stage, fraction):
        raise KeyboardInterrupt

    points = np.random.default_rng(0).random((5, 2))
    with pytest.raises(KeyboardInterrupt):
        find_correspondence(small, points, [[0, 1]], progress=stop)
    assert small.solve(points).converged


@pytest.mark.parametrize(
    ("points", "groups", "text"),
    [
        (np.zeros((4, 2)), [], "points must be 5 by 2"),
        (np.full((5, 2), np.nan), [], "points must be finite"),
        (np.zeros((5, 2)), [[0, 1], [1, 2]], "a row is in two groups"),
        (np.zeros((5, 2)), [[0, 5]], "there is no row 5, only 0 to 4"),
        (np.ones((5, 2)), [[0, 1]], "the points are on one line, or too few"),
    ],
)
def test_what_cannot_be_matched_is_told(small, points, groups, text):
    with pytest.raises(ValueError, match=text):
        find_correspondence(small, points, groups)


def test_points_that_leave_the_turn_open_are_told(creature):
    vertices = list(creature.handles.values())
    body = Body(creature.shapes[:2], creature.triangles)
    for pins, points in (
        (vertices[:2], creature.shapes[1][vertices[:2]]),
        (vertices[:4], np.linspace(0, 1, 4)[:, None] * [1.0, 2.0, 3.0]),
    ):
        with pytest.raises(ValueError, match="on one line, or too few to place the body"):
            find_correspondence(body.solver(Rows.pin(pins)), points, [[0, 1]])
