# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounded biharmonic weights by others: PIQP, to more digits than are compared, OSQP, libigl."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Self

import igl
import numpy as np
import osqp
import piqp
import scipy.sparse
from conic import rigidity
from data import ExampleSet

REFERENCE_TOLERANCE = 1e-11
OSQP_TOLERANCE, OSQP_ITERATIONS = 1e-6, 20_000
LIBIGL_ROUNDS = 8  # of its active set, as in its tutorial


def lumped_mass(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Voronoi areas: of each triangle what is nearest to a corner, a quarter to a half."""
    corners = vertices[triangles]
    sides = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)  # opposite of each corner
    double_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)[:, None]
    dots = -np.einsum("fcd,fcd->fc", np.roll(sides, -1, axis=1), np.roll(sides, 1, axis=1))
    parts = dots / double_area * np.einsum("fcd,fcd->fc", sides, sides) / 8
    nearest = np.roll(parts, -1, axis=1) + np.roll(parts, 1, axis=1)
    at_obtuse = np.where(dots < 0, 1 / 2, 1 / 4) * double_area / 2
    shares = np.where((dots < 0).any(axis=1, keepdims=True), at_obtuse, nearest)
    return np.bincount(triangles.ravel(), shares.ravel(), len(vertices))


def bilaplacian(vertices: np.ndarray, triangles: np.ndarray) -> scipy.sparse.csc_matrix:
    """L M^-1 L with cotangent L and lumped mass, scaled so that its diagonal is about one."""
    mass = lumped_mass(vertices, triangles)
    L = rigidity(vertices, triangles)
    Q = (L @ scipy.sparse.diags(1.0 / mass) @ L).tocsc()
    return Q / np.median(Q.diagonal())


@dataclass(frozen=True)
class Found:
    """Weights (#V by #H, rows that sum to one), seconds, and whether every handle's converged."""

    weights: np.ndarray
    seconds: float
    converged: bool


@dataclass(frozen=True)
class Programs:
    """min 1/2 w^T Q w + linear_h^T w within [0, 1] for each handle h, at the vertices that are no
    handle's: #free by #free, #free by #H."""

    Q: scipy.sparse.csc_matrix
    linear: np.ndarray
    free: np.ndarray
    handles: np.ndarray

    @classmethod
    def of(cls, mesh: ExampleSet, handles: np.ndarray) -> Self:
        """Scaled so that the diagonal of Q is about one."""
        Q = bilaplacian(mesh.shapes[0], mesh.triangles)
        free = np.delete(np.arange(Q.shape[0]), handles)
        return cls(Q[free][:, free].tocsc(), Q[free][:, handles].toarray(), free, handles)

    def complete(self, free_weights: np.ndarray) -> np.ndarray:
        """#V by #H with rows that sum to one, from those of the free vertices."""
        count = len(self.handles)
        weights = np.zeros((len(self.free) + count, count))
        weights[self.handles] = np.eye(count)
        weights[self.free] = free_weights
        return weights / weights.sum(axis=1, keepdims=True)


def solve_by_piqp(mesh: ExampleSet, handles: np.ndarray) -> Found:
    """The reference."""
    start = time.perf_counter()
    programs = Programs.of(mesh, handles)
    zero, one = np.zeros(len(programs.free)), np.ones(len(programs.free))
    columns, converged = [], True
    for linear in programs.linear.T:
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = REFERENCE_TOLERANCE
        solver.setup(programs.Q, linear, x_l=zero, x_u=one)
        converged &= solver.solve() == piqp.PIQP_SOLVED
        columns.append(solver.result.x)
    weights = programs.complete(np.stack(columns, axis=1))
    return Found(weights, time.perf_counter() - start, converged)


def solve_by_osqp(mesh: ExampleSet, handles: np.ndarray) -> Found:
    """With one factorisation for all handles, as far as OSQP keeps it."""
    start = time.perf_counter()
    programs = Programs.of(mesh, handles)
    zero, one = np.zeros(len(programs.free)), np.ones(len(programs.free))
    solver = osqp.OSQP()
    solver.setup(
        scipy.sparse.triu(programs.Q, format="csc"),
        np.ascontiguousarray(programs.linear[:, 0]),
        scipy.sparse.eye(len(zero), format="csc"),
        zero,
        one,
        verbose=False,
        eps_abs=OSQP_TOLERANCE,
        eps_rel=OSQP_TOLERANCE,
        max_iter=OSQP_ITERATIONS,
    )
    columns, converged = [], True
    for linear in programs.linear.T:
        solver.update(q=np.ascontiguousarray(linear))
        found = solver.solve()
        converged &= found.info.status == "solved"
        columns.append(np.clip(found.x, 0.0, 1.0))
    weights = programs.complete(np.stack(columns, axis=1))
    return Found(weights, time.perf_counter() - start, converged)


def solve_by_libigl(mesh: ExampleSet, handles: np.ndarray, columns: int) -> Found:
    """The first columns of the weights, not divided by their sum; after its rounds the active set
    has not converged."""
    values = np.eye(len(handles))[:, :columns].copy()
    start = time.perf_counter()
    weights = igl.bbw(
        mesh.shapes[0],
        mesh.triangles.astype(np.int64),
        handles.astype(np.int64),
        values,
        max_iter=LIBIGL_ROUNDS,
    )
    return Found(weights, time.perf_counter() - start, False)
