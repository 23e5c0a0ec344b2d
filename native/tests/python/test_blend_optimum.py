# SPDX-License-Identifier: GPL-3.0-or-later
"""(A 20) against a general conic solver, on the full problem in transforms and blend.

The reference knows nothing of the library's reduction: it is written from (A 6), (A 9), (A 20) on
the mesh's own edges, with the rotations and costs that the library ended on.
"""

from __future__ import annotations

import clarabel
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from addon.solver import Form, Mesh, Model, Rows, Solver
from addon.weights import cluster_triangles, compute_weights

AROUND, ALONG = 8, 13  # vertices of a tube
LAMBDA = 0.5


def tube() -> tuple[np.ndarray, np.ndarray]:
    """An open tube along x, of length 6 and radius 1."""
    turn, x = np.meshgrid(2 * np.pi * np.arange(AROUND) / AROUND, np.linspace(0, 6, ALONG))
    vertices = np.stack([x.ravel(), np.cos(turn).ravel(), np.sin(turn).ravel()], axis=1)
    ring = np.arange(AROUND)
    corners = [ring, np.roll(ring, -1), np.roll(ring, -1) + AROUND, ring + AROUND]
    a, b, c, d = (
        np.concatenate([corner + AROUND * i for i in range(ALONG - 1)]) for corner in corners
    )
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return vertices, triangles.astype(np.int32)


def examples(rest: np.ndarray) -> np.ndarray:
    """Rest, bent upwards, bulged and drawn out, twisted and thinned: #S by #V by 3."""
    x, y, z = rest.T
    angle, radius = x / 4, 4.0
    bent = np.stack([(radius - z) * np.sin(angle), y, radius - (radius - z) * np.cos(angle)], 1)
    bulge = 1 + 0.5 * np.sin(np.pi * x / 6)
    bulged = np.stack([1.3 * x, bulge * y, bulge * z], 1)
    turn, thin = x / 3, 1 - 0.3 * np.sin(np.pi * x / 6)
    twisted = np.stack(
        [
            0.9 * x,
            thin * (np.cos(turn) * y - np.sin(turn) * z),
            thin * (np.sin(turn) * y + np.cos(turn) * z),
        ],
        axis=1,
    )
    return np.stack([rest, bent, bulged, twisted])


class Case:
    """The tube with four handles, and the quadratic form of (A 9) in vec(T, B)."""

    def __init__(self) -> None:
        rest, self.triangles = tube()
        self.shapes = examples(rest)
        self.handles = [0, 4 * AROUND + 2, 8 * AROUND + 5, 12 * AROUND + 3]
        self.mesh = Mesh(rest, self.triangles)
        self.weights, _ = compute_weights(self.mesh, [[h] for h in self.handles])
        self.groups = cluster_triangles(self.mesh, self.weights, 6)
        self.model = Model(
            self.mesh, self.shapes, self.weights, Rows.pin(self.handles), self.groups
        )
        columns = [
            self.weights,
            *(self.weights * p[:, [axis]] for p in self.shapes for axis in range(3)),
        ]
        # Any basis of the same span is the same problem; this one suits the reference solver.
        self.dictionary = scipy.linalg.orth(np.concatenate(columns, axis=1))

    def edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ends (#E by 2), weights and groups of every triangle's three edges."""
        ends, weights = [], []
        for corner in range(3):
            a, b, opposite = (self.triangles[:, (corner + i) % 3] for i in (1, 2, 0))
            u = self.shapes[0][a] - self.shapes[0][opposite]
            v = self.shapes[0][b] - self.shapes[0][opposite]
            cotangent = np.sum(u * v, axis=1) / np.linalg.norm(np.cross(u, v), axis=1)
            ends.append(np.stack([a, b], 1))
            weights.append(cotangent / 2)
        return np.concatenate(ends), np.concatenate(weights), np.tile(self.groups, 3)

    def quadratic_form(self, rotations: np.ndarray) -> np.ndarray:
        """A with E_d = |A z|^2 for z = (T by columns, B by rows)."""
        ends, weights, groups = self.edges()
        count, (G, S) = self.dictionary.shape[1], rotations.shape[:2]
        along = self.dictionary[ends[:, 0]] - self.dictionary[ends[:, 1]]
        form = np.zeros((3 * count + G * S,) * 2)
        for axis in range(3):
            rows = np.zeros((len(ends), 3 * count + G * S))
            rows[:, axis * count : (axis + 1) * count] = along
            for s in range(S):
                edge = self.shapes[s][ends[:, 0]] - self.shapes[s][ends[:, 1]]
                turned = np.einsum("eb,eb->e", rotations[groups, s, axis], edge)
                rows[np.arange(len(ends)), 3 * count + groups * S + s] = -turned
            form += 0.5 * rows.T @ (weights[:, None] * rows)
        values, vectors = np.linalg.eigh(form)
        keep = values > 1e-14 * values[-1]
        return np.sqrt(values[keep])[:, None] * vectors[:, keep].T

    def optimum(self, targets: np.ndarray, rotations: np.ndarray, costs: np.ndarray) -> float:
        """Of min |A z| + lambda sum B sqrt(D), X T = Y, B in the simplices.

        The solver's unknowns are (t, y, B): T = T0 + N y with X N = 0, and |A z| <= t.
        """
        A = self.quadratic_form(rotations)
        G, S = costs.shape
        X = self.dictionary[self.handles]
        kernel, start = scipy.linalg.null_space(X), np.linalg.lstsq(X, targets, rcond=None)[0]
        basis = scipy.linalg.block_diag(kernel, kernel, kernel, np.eye(G * S))
        fixed = A @ np.concatenate([start.T.ravel(), np.zeros(G * S)])
        free = np.linalg.qr(np.column_stack([A @ basis, fixed]), mode="r")
        size = basis.shape[1]
        blend_sums = np.hstack([np.zeros((G, size - G * S)), np.kron(np.eye(G), np.ones(S))])
        blends = np.eye(size)[size - G * S :]
        blocks = [
            np.hstack([np.zeros((G, 1)), blend_sums]),
            np.hstack([np.zeros((G * S, 1)), -blends]),
            -np.eye(1, size + 1),
            np.hstack([np.zeros((len(free), 1)), -free[:, :-1]]),
        ]
        b = np.concatenate([np.ones(G), np.zeros(G * S), [0.0], free[:, -1]])
        cones = [
            clarabel.ZeroConeT(G),
            clarabel.NonnegativeConeT(G * S),
            clarabel.SecondOrderConeT(1 + len(free)),
        ]
        q = np.concatenate([[1.0], np.zeros(size - G * S), LAMBDA * costs.ravel()])
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
        zero = scipy.sparse.csc_matrix((size + 1, size + 1))
        constraints = scipy.sparse.csc_matrix(np.vstack(blocks))
        found = clarabel.DefaultSolver(zero, q, constraints, b, cones, settings).solve()
        assert str(found.status) == "Solved"
        return found.obj_val


@pytest.fixture(scope="module")
def case() -> Case:
    return Case()


def handle_positions(case: Case, number: int) -> np.ndarray:
    """The handles of an example for the first four, else of a random mixture with noise."""
    rest = case.shapes[:, case.handles]
    if number < len(rest):
        return rest[number]
    random = np.random.default_rng(number)
    mixed = np.tensordot(random.dirichlet(np.ones(len(rest))), rest, 1)
    return mixed + 0.3 * random.standard_normal(mixed.shape)


@pytest.mark.parametrize("form", [Form.NO_ROTATIONS, Form.PAPER])
@pytest.mark.parametrize("number", range(50))
def test_the_optimum_is_that_of_a_conic_solver(case, form, number):
    targets = handle_positions(case, number)
    with Solver(case.model, form=form, max_rounds=3, lambda_=LAMBDA) as solver:
        info = solver.solve(targets)
        expected = case.optimum(targets, solver.rotations(), solver.costs())
    # At an example the optimum is zero: there the unit is the mesh's own size.
    scale = max(expected, np.linalg.norm(np.ptp(case.shapes[0], axis=0)))
    assert abs(info.objective - expected) <= 1e-7 * scale
    assert info.gap <= 1e-8 * scale
