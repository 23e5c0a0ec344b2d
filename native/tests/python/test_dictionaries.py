# SPDX-License-Identifier: GPL-3.0-or-later
"""Change and reduction of dictionaries against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from addon.native import TugError
from addon.solver import fit_dictionary, reduce_dictionary

SHAPES, VERTICES, WEIGHTS = 3, 200, 4
BLOCK = 1 + 3 * SHAPES


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(8)


@pytest.fixture
def shapes(random) -> np.ndarray:
    return random.normal(size=(SHAPES, VERTICES, 3))


@pytest.fixture
def weights(random) -> np.ndarray:
    return random.uniform(size=(VERTICES, WEIGHTS))


def dictionary(shapes, weights) -> np.ndarray:
    """D of (F 4): #V by #W (1 + #S k)."""
    coordinates = shapes.transpose(1, 0, 2).reshape(VERTICES, -1)
    block = np.concatenate([np.ones((VERTICES, 1)), coordinates], axis=1)
    return (weights[:, :, None] * block[:, None]).reshape(VERTICES, -1)


@pytest.mark.parametrize("left_out", [[], [1, 7, 13, 29]], ids=["all", "some"])
def test_a_fit_is_the_least_squares_solution(random, shapes, weights, left_out):
    D = dictionary(shapes, weights)
    atoms = np.setdiff1d(np.arange(D.shape[1]), left_out)
    positions = random.normal(size=(VERTICES, 3))
    transforms, fitted = fit_dictionary(shapes, weights, positions, atoms if left_out else None)
    expected = np.linalg.lstsq(D[:, atoms], positions, rcond=None)[0]
    np.testing.assert_allclose(transforms[atoms], expected, atol=1e-9)
    np.testing.assert_array_equal(transforms[left_out], 0)
    np.testing.assert_allclose(fitted, D[:, atoms] @ expected, atol=1e-9)


def test_dependent_atoms_are_no_harm(random, shapes, weights):
    shapes[2] = shapes[1] @ random.normal(size=(3, 3)) + 1
    positions = random.normal(size=(VERTICES, 3))
    _, fitted = fit_dictionary(shapes, weights, positions)
    D = dictionary(shapes, weights)
    expected = D @ np.linalg.lstsq(D, positions, rcond=1e-10)[0]
    np.testing.assert_allclose(fitted, expected, atol=1e-7)


def test_a_change_of_dictionary_is_that_of_the_equation(random, shapes, weights):
    first = dictionary(shapes, random.uniform(size=(VERTICES, 2)))
    given = random.normal(size=(first.shape[1], 3))
    D = dictionary(shapes, weights)
    expected = np.linalg.solve(D.T @ D, D.T @ first @ given)  # (F 24)
    transforms, _ = fit_dictionary(shapes, weights, first @ given)
    np.testing.assert_allclose(transforms, expected, atol=1e-7)


def test_similar_shapes_lose_little_in_a_reduction(random, shapes, weights):
    weights /= weights.sum(axis=1, keepdims=True)
    shapes[1:] = shapes[0] + 0.01 * random.normal(size=(2, VERTICES, 3))
    atoms = reduce_dictionary(shapes, weights, 4 * WEIGHTS)
    assert set(range(0, WEIGHTS * BLOCK, BLOCK)) <= set(atoms)
    kinds = {(atom // BLOCK, (atom % BLOCK - 1) % 3) for atom in atoms if atom % BLOCK}
    assert len(kinds) == 3 * WEIGHTS  # of each weight and axis, one of the three shapes
    _, fitted = fit_dictionary(shapes, weights, shapes[2], atoms)
    assert np.abs(fitted - shapes[2]).max() < 0.05


def test_what_cannot_be_is_refused(shapes, weights):
    with pytest.raises(TugError, match="3 atoms are wanted"):
        reduce_dictionary(shapes, weights, WEIGHTS - 1)
    with pytest.raises(TugError, match="weight functions are not among"):
        fit_dictionary(shapes, weights, shapes[0], np.arange(5))
    with pytest.raises(ValueError, match="positions must have"):
        fit_dictionary(shapes, weights, shapes[0][:, :2])
    with pytest.raises(ValueError, match="shapes must be"):
        reduce_dictionary(shapes[0], weights, 10)
