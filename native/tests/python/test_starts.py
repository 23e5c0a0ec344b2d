# SPDX-License-Identifier: GPL-3.0-or-later
"""Forms without blends, and solves that start elsewhere than cold, from Python."""

from __future__ import annotations

import numpy as np
import pytest

from addon.geometry import Mesh
from addon.native import TugError
from addon.solver import Form, Model, Rows, Solver
from addon.starts import RowStart, find_rotations, solve_in_stages
from addon.weights import cluster_triangles, compute_eigenfunctions, compute_weights

HANDLES = [0, 7, 200, 263, 130]


def bend(points: np.ndarray, angle: float) -> np.ndarray:
    """A strip of length 4 along x, rolled up by `angle` in all."""
    x, y, z = points.T
    turn = angle * x / 4
    radius = 4 / angle
    return np.stack([(radius - z) * np.sin(turn), y, radius - (radius - z) * np.cos(turn)], -1)


def shapes() -> tuple[np.ndarray, np.ndarray]:
    number = np.arange(33 * 8).reshape(33, 8)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3).astype(np.int32)
    x, y = np.meshgrid(np.linspace(0, 4, 33), np.linspace(0, 1, 8), indexing="ij")
    flat = np.stack([x, y, 0.2 * np.sin(3 * y)], -1).reshape(-1, 3)
    return np.stack([flat, bend(flat, 1.0), bend(flat, -1.5)]), triangles


class Case:
    """A rich model by handles and a small one by four eigenfunctions, with the same groups."""

    def __init__(self) -> None:
        self.shapes, triangles = shapes()
        self.mesh = Mesh(self.shapes[0], triangles)
        self.rows = Rows.pin(HANDLES)
        weights, _ = compute_weights(self.mesh, [[vertex] for vertex in HANDLES])
        self.groups = cluster_triangles(self.mesh, weights, 8)
        self.values, self.functions, _ = compute_eigenfunctions(self.mesh, 4)
        self.model = Model(self.mesh, self.shapes, weights, self.rows, self.groups)
        self.small = Model(
            *(self.mesh, self.shapes, self.functions, self.rows, self.groups), smoothness=1e-3
        )


@pytest.fixture(scope="module")
def case() -> Case:
    return Case()


def rms(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum((a - b) ** 2, axis=1))))


def test_scaled_examples_come_back_in_their_size(case: Case) -> None:
    with Solver(case.model, form=Form.MINIMAL, scale=1) as solver:
        for number, shape in enumerate(case.shapes):
            info = solver.solve(1.5 * shape[HANDLES])
            assert info.converged
            assert solver.scale() == pytest.approx(1.5, rel=1e-6)
            assert rms(solver.positions(), 1.5 * shape) < 1e-6
            assert np.array_equal(solver.blend(), np.eye(len(case.shapes))[[number] * 8])


def test_only_the_forms_without_blends_scale(case: Case) -> None:
    with pytest.raises(TugError, match="cannot scale"):
        Solver(case.model, form=Form.PAPER, scale=1)


def test_rotations_of_a_pose_are_those_of_its_solve(case: Case) -> None:
    target = bend(case.shapes[0], 1.3)
    with Solver(case.model, form=Form.MINIMAL, max_rounds=1000) as solver:
        assert solver.solve(target[HANDLES]).converged
        chosen = int(solver.blend()[0].argmax())
        found = find_rotations(case.mesh, case.shapes, case.groups, solver.positions())
        assert np.allclose(found[:, chosen], solver.rotations()[:, chosen], atol=1e-4)


def test_rotations_turn_with_the_pose_and_not_with_its_size(case: Case) -> None:
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    still = find_rotations(case.mesh, case.shapes, case.groups, case.shapes[1])
    moved = find_rotations(case.mesh, case.shapes, case.groups, 3 * case.shapes[1] @ turn.T + 5)
    assert np.allclose(moved, turn @ still, atol=1e-9)
    assert np.allclose(still[:, 1], np.eye(3), atol=1e-9)


def test_stages_are_solves_from_the_rotations_before(case: Case) -> None:
    targets = bend(case.shapes[0], 1.3)[HANDLES]
    with (
        Solver(case.small, form=Form.CLOSEST) as first,
        Solver(case.model, form=Form.CLOSEST) as last,
    ):
        solve_in_stages([first, last], targets)
        staged = last.positions()
        last.solve(targets, first.rotations())
        assert np.array_equal(last.positions(), staged)
        last.solve(targets)
        assert not np.array_equal(last.positions(), staged)
        assert rms(last.positions(), staged) < 0.05


def test_starts_from_the_rows_alone_lead_to_the_same_pose(case: Case) -> None:
    target = bend(case.shapes[0], 1.3)
    with Solver(case.model, form=Form.MINIMAL, max_rounds=1000) as solver:
        solver.solve(target[HANDLES])
        cold = solver.positions()
        for sparsity in (0.0, 1e-4):
            start = RowStart(
                *(case.mesh, case.shapes, case.functions, case.values**2, case.rows, case.groups),
                sparsity=sparsity,
            )
            assert rms(start.positions(target[HANDLES])[HANDLES], target[HANDLES]) < 0.05
            assert solver.solve(target[HANDLES], start.rotations(target[HANDLES])).converged
            assert rms(solver.positions(), cold) < 1e-3


def test_rows_change_without_the_mesh(case: Case) -> None:
    vertices = np.arange(0, len(case.shapes[0]), 3)
    model = case.model.change_rows(Rows.pin(vertices), np.ones(len(vertices)))
    with Solver(model, form=Form.MINIMAL) as solver:
        solver.solve(case.shapes[2][vertices])
        assert rms(solver.positions(), case.shapes[2]) < 1e-6
    with pytest.raises(ValueError, match="firmness"):
        case.model.change_rows(Rows.pin(vertices), np.ones(3))


def test_smooth_models_of_eigenfunctions_find_examples(case: Case) -> None:
    model = Model(*(case.mesh, case.shapes, case.functions, case.rows, case.groups), smoothness=0.1)
    with Solver(model) as solver:
        for shape in case.shapes:
            solver.solve(shape[HANDLES])
            assert rms(solver.positions(), shape) < 1e-5


# What cannot be ---------------------------------------------------------------------------------


def row_start(case: Case, **changes: object) -> RowStart:
    given = {
        "mesh": case.mesh,
        "shapes": case.shapes,
        "weights": case.functions,
        "energies": case.values**2,
        "rows": case.rows,
        "groups": case.groups,
    }
    return RowStart(**given | changes)


@pytest.mark.parametrize(
    ("targets", "text"),
    [
        (np.zeros((3, 3)), "targets must be 5 by 3 finite coordinates"),
        (np.full((5, 3), np.nan), "targets must be 5 by 3 finite coordinates"),
        (np.zeros((5, 3)), "the targets are on one line, or too few"),
        (np.linspace(0, 1, 5)[:, None] * np.ones(3), "the targets are on one line, or too few"),
    ],
)
def test_targets_that_cannot_place_a_body_are_told(case: Case, targets, text) -> None:
    with pytest.raises(ValueError, match=text):
        row_start(case).rotations(targets)


def test_too_few_rows_are_told(case: Case) -> None:
    for pins in ([], [0], [0, 263]):
        with pytest.raises(ValueError, match="too few to place the body|there is no row"):
            row_start(case, rows=Rows.pin(pins)).rotations(case.shapes[0][pins])


def test_what_a_start_cannot_be_made_of_is_told(case: Case) -> None:
    for changes, error, text in (
        ({"rows": Rows.pin([0, 10**6])}, ValueError, "no vertex 1000000 for a row, only 0 to 263"),
        ({"rows": Rows.pin([0, -1])}, ValueError, "no vertex -1 for a row"),
        ({"shapes": np.full_like(case.shapes, np.nan)}, ValueError, "not finite: repair them"),
        ({"weights": case.functions[:5]}, ValueError, "expected a matrix of 264 rows"),
        ({"energies": np.ones(3)}, ValueError, "energies must be of the 4 weight functions"),
        ({"groups": case.groups[:5]}, ValueError, "groups must be #F"),
    ):
        with pytest.raises(error, match=text):
            row_start(case, **changes)
    for changes, text in (
        ({"weights": np.full_like(case.functions, np.nan)}, "row 0 of X has a value"),
        ({"energies": -np.ones(4)}, "not positive semidefinite"),
        ({"fit": np.nan}, "fit is nan: it must be above zero"),
    ):
        with pytest.raises(TugError, match=text):
            row_start(case, **changes).positions(case.shapes[1][HANDLES])


def test_a_part_of_the_mesh_without_a_row_is_told(case: Case) -> None:
    shapes, triangles = np.concatenate([case.shapes, case.shapes + 9], axis=1), case.mesh.triangles
    with Mesh(shapes[0], np.concatenate([triangles, triangles + len(case.shapes[0])])) as two:
        values, functions, _ = compute_eigenfunctions(two, 4)
        groups = np.repeat([0, 1], len(triangles)).astype(np.int32)
        rows = Rows.pin(HANDLES)
        with pytest.raises(ValueError, match="2 parts .* the one with vertex 264 has no row"):
            RowStart(two, shapes, functions, values**2, rows, groups)


def test_poses_and_solvers_that_are_none_are_told(case: Case) -> None:
    with pytest.raises(TugError, match="coordinate 0 of the positions is not finite"):
        find_rotations(case.mesh, case.shapes, case.groups, np.full_like(case.shapes[0], np.nan))
    with pytest.raises(ValueError, match="positions must be 264 by 3"):
        find_rotations(case.mesh, case.shapes, case.groups, case.shapes[0][:5])
    with pytest.raises(ValueError, match="there is no solver"):
        solve_in_stages([], case.shapes[0][HANDLES])
