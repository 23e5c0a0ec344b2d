# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on bounded biharmonic weights: weights_20k, weights_100k."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from data import ExampleSet
from generated import tube
from library import Mesh, WeightsInfo, compute_weights
from suite import HANDLES, Row, Suite, compare
from weights_peers import solve_by_libigl, solve_by_piqp

REFERENCE_VERTICES = 2500
LIBIGL_ROUNDS = 8  # of its active set, as in its tutorial; it has then not converged


def solve_by_tug(mesh: ExampleSet, handles: np.ndarray) -> tuple[np.ndarray, float, WeightsInfo]:
    """The weights, seconds, and how it ended."""
    with Mesh(mesh.shapes[0], mesh.triangles) as native_mesh:
        start = time.perf_counter()
        weights, info = compute_weights(native_mesh, [[handle] for handle in handles])
        return weights, time.perf_counter() - start, info


def weights_rows(suite: Suite, name: str, vertices: int, repeats: int) -> Iterator[Row]:
    """Seconds on a mesh of this size, beside one handle of libigl's, times their number."""
    mesh = tube(int(suite.size * vertices), 1)
    handles = mesh.spread_handles(HANDLES)
    runs = [solve_by_tug(mesh, handles) for _ in range(repeats)]
    seconds, info = float(np.median([run[1] for run in runs])), runs[0][2]
    _, peer = solve_by_libigl(mesh, handles, LIBIGL_ROUNDS, 1)
    sizes = {
        "vertices": mesh.shapes.shape[1],
        "handles": HANDLES,
        "iterations": info.iterations,
        "gap": info.gap,
    }
    label = f"libigl's bbw, {LIBIGL_ROUNDS} rounds, one handle times {HANDLES}"
    peer_seconds = HANDLES * peer
    yield compare(name, "weights", "s", seconds, label, peer_seconds, info.converged, sizes)
    yield Row(name, "relative duality gap", "", info.gap, converged=info.converged, sizes=sizes)


def reference_rows(name: str) -> Iterator[Row]:
    """The same on a mesh that is small enough for a general solver and its eleven digits."""
    mesh = tube(REFERENCE_VERTICES, 1)
    handles = mesh.spread_handles(HANDLES)
    weights, seconds, info = solve_by_tug(mesh, handles)
    exact, peer_seconds, peer_converged = solve_by_piqp(mesh, handles)
    sizes = {
        "vertices": mesh.shapes.shape[1],
        "handles": HANDLES,
        "peer_converged": peer_converged,
    }
    metric = "weights, small mesh"
    yield compare(name, metric, "s", seconds, "PIQP", peer_seconds, info.converged, sizes)
    difference = float(np.abs(weights - exact).max())
    metric = "largest difference from the exact weights, small mesh"
    yield Row(name, metric, "", difference, sizes=sizes)
