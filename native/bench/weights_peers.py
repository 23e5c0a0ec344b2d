# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounded biharmonic weights by others: PIQP, to more digits than are compared, and libigl."""

from __future__ import annotations

import time

import igl
import numpy as np
import piqp
import scipy.sparse
from conic import rigidity
from data import ExampleSet

REFERENCE_TOLERANCE = 1e-11


def bilaplacian(vertices: np.ndarray, triangles: np.ndarray) -> scipy.sparse.csc_matrix:
    """L M^-1 L with cotangent L and a third of each triangle's area at its corners; scaled so that
    its diagonal is about one."""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    mass = np.bincount(triangles.ravel(), np.repeat(area / 3, 3), len(vertices))
    L = rigidity(vertices, triangles)
    Q = (L @ scipy.sparse.diags(1.0 / mass) @ L).tocsc()
    return Q / np.median(Q.diagonal())


def solve_by_piqp(mesh: ExampleSet, handles: np.ndarray) -> tuple[np.ndarray, float, bool]:
    """#V by #H with rows that sum to one, seconds, and whether all handles converged."""
    start = time.perf_counter()
    Q = bilaplacian(mesh.shapes[0], mesh.triangles)
    free = np.delete(np.arange(Q.shape[0]), handles)
    weights = np.zeros((Q.shape[0], len(handles)))
    weights[handles, np.arange(len(handles))] = 1.0
    converged = True
    for column in range(len(handles)):
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = REFERENCE_TOLERANCE
        linear = Q[free][:, handles] @ weights[handles, column]
        nothing, everything = np.zeros(len(free)), np.ones(len(free))
        solver.setup(Q[free][:, free], linear, x_l=nothing, x_u=everything)
        converged &= solver.solve() == piqp.PIQP_SOLVED
        weights[free, column] = solver.result.x
    seconds = time.perf_counter() - start
    return weights / weights.sum(axis=1, keepdims=True), seconds, converged


def solve_by_libigl(
    mesh: ExampleSet, handles: np.ndarray, rounds: int, columns: int
) -> tuple[np.ndarray, float]:
    """The first columns of the weights, #V by columns and not divided by their sum, with so many
    rounds of its active set; and seconds."""
    values = np.eye(len(handles))[:, :columns].copy()
    start = time.perf_counter()
    weights = igl.bbw(
        mesh.shapes[0],
        mesh.triangles.astype(np.int64),
        handles.astype(np.int64),
        values,
        max_iter=rounds,
    )
    return weights, time.perf_counter() - start
