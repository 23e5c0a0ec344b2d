# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations that the handles leave open: solves converge, and keep to what is known."""

from __future__ import annotations

import numpy as np
import pytest
from test_blend_optimum import AROUND, examples, tube

from addon.dictionaries import Dictionary
from addon.native import ERROR_HANDLES, TugError
from addon.solver import make_solver

# Springs are tried on the handles' weights alone: on so few vertices the columns of eigenfunctions
# nearly depend on each other, and what is left of the energy of a loose part is rounding.
DICTIONARIES = (Dictionary.HANDLES, Dictionary.EIGENFUNCTIONS)
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def with_eyes() -> tuple[np.ndarray, np.ndarray, list[int]]:
    """The tube and two small parts that every example carries along unturned, a handle on each."""
    rest, triangles = tube()
    shapes, handles = examples(rest), [0, 4 * AROUND + 2, 8 * AROUND + 5, 12 * AROUND + 3]
    for anchor in (3 * AROUND, 9 * AROUND + 4):
        eye = shapes[:, [anchor]] + 0.2 * TETRAHEDRON + np.array([0, 0, 1.5])
        first = shapes.shape[1]
        faces = first + np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        shapes = np.concatenate([shapes, eye], axis=1)
        triangles = np.concatenate([triangles, faces.astype(np.int32)])
        handles.append(first)
    return shapes, triangles, handles


@pytest.mark.parametrize("dictionary", DICTIONARIES)
def test_a_part_with_one_handle_is_recognised_with_the_rest(dictionary):
    shapes, triangles, handles = with_eyes()
    with make_solver(shapes, triangles, handles, dictionary=dictionary) as solver:
        for shape in shapes:
            info = solver.solve(shape[handles])
            assert info.converged
            np.testing.assert_allclose(solver.positions(), shape, atol=1e-5)


def test_letting_go_of_a_part_names_its_rows():
    shapes, triangles, handles = with_eyes()
    with make_solver(shapes, triangles, handles, dictionary=Dictionary.HANDLES) as solver:
        with pytest.raises(TugError, match="rows 5:") as caught:
            solver.set_firmness([1, 1, 0, 1, np.inf, 0])
        assert caught.value.code == ERROR_HANDLES
        solver.set_firmness([1, 1, 0, 1, 1, 1])
        for shape in shapes:
            assert solver.solve(shape[handles]).converged
            np.testing.assert_allclose(solver.positions(), shape, atol=1e-5)


@pytest.mark.parametrize("firmness", [1e-5, 1e-3, 1])
def test_solves_converge_however_softly_everything_is_held(firmness):
    """What springs leave of the energy is a difference of much larger numbers."""
    shapes, triangles, handles = with_eyes()
    with make_solver(shapes, triangles, handles, dictionary=Dictionary.HANDLES) as solver:
        solver.set_firmness(np.full(len(handles), firmness))
        for shape in shapes:
            assert solver.solve(shape[handles]).converged
            np.testing.assert_allclose(solver.positions(), shape, atol=2e-4)


@pytest.mark.parametrize("dictionary", DICTIONARIES)
def test_solves_converge_between_the_examples(dictionary):
    shapes, triangles, handles = with_eyes()
    random = np.random.default_rng(0)
    with make_solver(shapes, triangles, handles, dictionary=dictionary) as solver:
        for mixture in random.dirichlet(np.ones(len(shapes)), 20):
            targets = np.tensordot(mixture, shapes[:, handles], 1)
            info = solver.solve(targets + 0.1 * random.standard_normal(targets.shape))
            assert info.converged
            assert info.rounds < 30


@pytest.mark.parametrize("dictionary", DICTIONARIES)
@pytest.mark.parametrize("count", [2, 3])
def test_handles_on_a_line_leave_the_turn_about_it_as_it_was(count, dictionary):
    rest, triangles = tube()
    handles = [0, 12 * AROUND, 6 * AROUND][:count]
    with make_solver(rest[None], triangles, handles, dictionary=dictionary) as solver:
        info = solver.solve(rest[handles])
        assert info.converged
        np.testing.assert_allclose(solver.positions(), rest, atol=1e-6)
