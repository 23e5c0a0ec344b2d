# SPDX-License-Identifier: GPL-3.0-or-later
"""solve_elastic_net beside scikit-learn's, and (F 22) beside NumPy's pseudo-inverse."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.linear_model import ElasticNet, Lasso

from addon.native import TugError
from addon.solver import solve_elastic_net


def question(rows: int, unknowns: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.normal(size=(rows, unknowns)), random.normal(size=(rows, 3))


@pytest.mark.parametrize("rows, unknowns", [(40, 15), (10, 52), (25, 100)])
@pytest.mark.parametrize("sparsity", [0.1, 1.0, 10.0])
def test_it_is_the_elastic_net_of_scikit_learn(rows, unknowns, sparsity):
    """Whose penalty is a l |t|_1 + a (1 - l) |t|^2 / 2, where the squares are divided by the number
    of rows."""
    X, Y = question(rows, unknowns, seed=unknowns)
    T, info = solve_elastic_net(X, Y, np.ones(unknowns), smoothness=0.7, sparsity=sparsity)
    total = sparsity + 0.7
    exact = {"fit_intercept": False, "tol": 1e-14, "max_iter": 10**6}
    peer = ElasticNet(alpha=total / rows, l1_ratio=sparsity / total, **exact)
    assert info.converged
    np.testing.assert_allclose(T, peer.fit(X, Y).coef_.T, atol=1e-6)
    assert (T != 0).sum() < T.size


@pytest.mark.parametrize("sparsity", [0.1, 1.0, 10.0])
def test_any_penalty_is_that_of_more_rows(sparsity):
    """Lambda = P^T P is the Lasso with sqrt(smoothness) P below X and zeros below Y."""
    X, Y = question(20, 40, seed=1)
    P = np.random.default_rng(2).normal(size=(30, 40))
    T, _ = solve_elastic_net(X, Y, P.T @ P, fit=3.0, smoothness=0.5, sparsity=sparsity)
    rows = np.concatenate([np.sqrt(3.0) * X, np.sqrt(0.5) * P])
    wanted = np.concatenate([np.sqrt(3.0) * Y, np.zeros((30, 3))])
    peer = Lasso(alpha=sparsity / 50, fit_intercept=False, tol=1e-14, max_iter=10**6)
    np.testing.assert_allclose(T, peer.fit(rows, wanted).coef_.T, atol=1e-6)


@pytest.mark.parametrize("rows, unknowns", [(40, 15), (10, 52)])
@pytest.mark.parametrize("smoothness", [0.0, 0.5])
def test_without_sparsity_it_is_the_least_squares_of_f_22(rows, unknowns, smoothness):
    X, Y = question(rows, unknowns, seed=3)
    penalty = np.arange(unknowns, dtype=float)
    T, info = solve_elastic_net(X, Y, penalty, fit=2.0, smoothness=smoothness)
    both = 2.0 * X.T @ X + smoothness * np.diag(penalty)
    expected = np.linalg.pinv(both, rcond=1e-12, hermitian=True) @ (2.0 * X.T @ Y)
    np.testing.assert_allclose(T, expected, atol=1e-9)
    assert info.converged and info.rounds == 0


def test_columns_of_a_dictionary_may_be_collinear():
    """An example that is there twice, and its coordinates' sum."""
    X, Y = question(12, 20, seed=4)
    X = np.concatenate([X, X[:, :10], X.sum(axis=1, keepdims=True)], axis=1)
    T, info = solve_elastic_net(X, Y, np.zeros(31), sparsity=0.2)
    slack = X.T @ (Y - X @ T)
    assert info.converged
    assert np.abs(slack).max() <= 0.2 + 1e-11
    np.testing.assert_allclose(slack[T != 0], 0.2 * np.sign(T[T != 0]), atol=1e-11)


def test_a_penalty_of_another_size_is_refused():
    X, Y = question(5, 4, seed=5)
    with pytest.raises(ValueError, match="4 columns"):
        solve_elastic_net(X, Y, np.zeros(3))


def test_values_that_are_not_finite_are_named():
    X, Y = question(5, 4, seed=6)
    X[2, 1] = np.nan
    with pytest.raises(TugError, match="row 2 of X"):
        solve_elastic_net(X, Y, np.zeros(4))
