# SPDX-License-Identifier: GPL-3.0-or-later
"""(A 20) as a cone program for general solvers: on all transforms and blends, and with the
transforms eliminated.

Written from (A 6), (A 9) and (A 20) on the mesh's edges, with the rotations and costs that a solver
of Tug ended on. Lengths are in units of the rest shape's diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse
from data import ExampleSet
from library import Functions, Solver

LAMBDA = 0.5
DEPENDENT = 1e-12  # pivot below which a column of the dictionary is left out


@dataclass(frozen=True)
class ConeProgram:
    """min |F z + g| / sqrt(2) + cost^T z under A z = b; the last `blends` of z are not negative."""

    F: np.ndarray
    g: np.ndarray
    cost: np.ndarray
    A: np.ndarray
    b: np.ndarray
    blends: int


@dataclass(frozen=True)
class Instance:
    """One (A 20), #G by #S blends: `full` and `reduced` have the same optimum."""

    full: ConeProgram
    reduced: ConeProgram
    groups: int
    shapes: int


class Assembly:
    """What (A 20) needs of a mesh and its functions, whatever the pose."""

    def __init__(self, poses: ExampleSet, handles: np.ndarray, functions: Functions) -> None:
        self.handles, self.unit = handles, poses.diagonal
        shapes = (poses.shapes - poses.shapes[0].mean(axis=0)) / self.unit
        weights = functions.weights
        coordinates = np.concatenate(list(shapes), axis=1)
        products = weights[:, :, None] * coordinates[:, None, :]
        D = np.concatenate([weights, products.reshape(len(weights), -1)], axis=1)
        groups = [
            rigidity(shapes[0], poses.triangles[functions.groups == group])
            for group in range(functions.groups.max() + 1)
        ]
        total = sum(groups[1:], start=groups[0])
        self.D = D[:, independent_columns(D.T @ (total @ D), D[handles])]
        self.L = self.D.T @ (total @ self.D)
        self.H = [coordinates.T @ (group @ coordinates) for group in groups]
        self.K = [(group @ coordinates).T @ self.D for group in groups]
        self.count = len(shapes)

    def instance(self, solver: Solver, targets: np.ndarray) -> Instance:
        """(A 20) as it is after the solver's last solve, which was for `targets`."""
        rotations, G, S = solver.rotations(), len(self.H), self.count
        k = rotations.shape[2]
        L_root, order = pivoted_root(self.L)
        rank, size = L_root.shape
        # Column (g, s) of N_a is K_gs^T times row a of R_gs.
        N = np.stack(
            [
                [self.K[g][k * s : k * s + k].T @ rotations[g, s].T for s in range(S)]
                for g in range(G)
            ]
        ).reshape(G * S, size, k)
        X = [
            scipy.linalg.solve_triangular(L_root[:, :rank].T, N[:, order, a].T[:rank], lower=True)
            for a in range(k)
        ]
        left = blend_energies(self.H, rotations) - sum(x.T @ x for x in X)
        tails = np.concatenate([*X, symmetric_root(left)])
        heads = np.zeros((len(tails), k * size))
        for a in range(k):
            heads[a * rank : (a + 1) * rank, a * size : (a + 1) * size] = L_root
        tails[: k * rank] *= -1.0
        moved = (targets - targets.mean(axis=0)) / self.unit
        costs = LAMBDA * solver.costs().ravel() / self.unit
        full = assemble(heads, tails, self.D[self.handles][:, order], moved, costs, G, S)
        return Instance(full, eliminate_transforms(full, G, S), G, S)


def rigidity(vertices: np.ndarray, triangles: np.ndarray) -> scipy.sparse.csr_matrix:
    """The cotangent Laplacian of some triangles, #V by #V: x^T L x sums over their edges."""
    blocks = []
    for corner in range(3):
        opposite, a, b = (triangles[:, (corner + i) % 3] for i in range(3))
        u, v = vertices[a] - vertices[opposite], vertices[b] - vertices[opposite]
        dot = (u * v).sum(1)
        area = np.sqrt((u * u).sum(1) * (v * v).sum(1) - dot**2)
        half = 0.5 * dot / area
        blocks += [(a, a, half), (b, b, half), (a, b, -half), (b, a, -half)]
    row, column, value = (np.concatenate(part) for part in zip(*blocks, strict=True))
    return scipy.sparse.csr_matrix((value, (row, column)), shape=(len(vertices),) * 2)


def independent_columns(L: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Numbers of the dictionary's columns that do not depend on others."""
    form = L + np.trace(L) / max(np.trace(X.T @ X), 1e-300) * X.T @ X
    scale = 1.0 / np.sqrt(np.maximum(np.diag(form), 1e-300))
    _, pivots, rank, _ = scipy.linalg.lapack.dpstrf(
        scale[:, None] * form * scale, tol=DEPENDENT, lower=0
    )
    return np.sort(pivots[:rank] - 1)


def pivoted_root(L: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """U, rank by #columns and upper triangular, with U^T U = L in the order that comes with it."""
    root, pivots, rank, _ = scipy.linalg.lapack.dpstrf(L, tol=1e-13 * L.max(), lower=0)
    return np.triu(root)[:rank], pivots - 1


def symmetric_root(form: np.ndarray) -> np.ndarray:
    """R with R^T R = form, without what is negative by rounding."""
    values, vectors = np.linalg.eigh(0.5 * (form + form.T))
    return np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T


def blend_energies(H: list[np.ndarray], rotations: np.ndarray) -> np.ndarray:
    """tr(R_gs H_gst R_gt^T), block diagonal: #G #S square."""
    S, k = rotations.shape[1:3]
    blocks = [
        np.einsum("sab,sbtc,tac->st", turn, form.reshape(S, k, S, k), turn)
        for form, turn in zip(H, rotations, strict=True)
    ]
    return scipy.linalg.block_diag(*blocks)


def assemble(
    heads: np.ndarray,
    tails: np.ndarray,
    X: np.ndarray,
    targets: np.ndarray,
    costs: np.ndarray,
    G: int,
    S: int,
) -> ConeProgram:
    """The full problem in (T by coordinates, B)."""
    rows = scipy.linalg.block_diag(*[X] * targets.shape[1], np.kron(np.eye(G), np.ones(S)))
    return ConeProgram(
        np.concatenate([heads, tails], axis=1),
        np.zeros(len(heads)),
        np.concatenate([np.zeros(heads.shape[1]), costs]),
        rows,
        np.concatenate([targets.T.ravel(), np.ones(G)]),
        G * S,
    )


def eliminate_transforms(full: ConeProgram, G: int, S: int) -> ConeProgram:
    """The same in B alone: each T is the best one for its B."""
    size, handles = full.F.shape[1] - G * S, len(full.A) - G
    X, targets = full.A[:handles, :size], full.b[:handles]
    start = np.linalg.lstsq(X, targets, rcond=None)[0]
    heads, tails = full.F[:, :size], full.F[:, size:]
    span = scipy.linalg.orth(heads @ scipy.linalg.null_space(X), rcond=1e-12)
    affine = np.column_stack([tails, heads @ start])
    # Twice: what is left may be small beside what is taken away.
    for _ in range(2):
        affine = affine - span @ (span.T @ affine)
    root = np.linalg.qr(affine, mode="r")
    return ConeProgram(
        root[:, :-1],
        root[:, -1],
        full.cost[size:],
        full.A[handles:, size:],
        full.b[handles:],
        G * S,
    )
