# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on bounded biharmonic weights: weights_20k, weights_100k."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from data import ExampleSet
from generated import tube
from library import Mesh, WeightsInfo, compute_weights
from suite import HANDLES, Row, Suite, compare
from weights_peers import (
    LIBIGL_ROUNDS,
    OSQP_TOLERANCE,
    solve_by_libigl,
    solve_by_osqp,
    solve_by_piqp,
)

REFERENCE_VERTICES = 2500
LIBIGL = f"libigl's bbw, {LIBIGL_ROUNDS} rounds"


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
    peer = solve_by_libigl(mesh, handles, 1)
    sizes = {
        "vertices": mesh.shapes.shape[1],
        "handles": HANDLES,
        "iterations": info.iterations,
        "gap": info.gap,
    }
    beside = sizes | {"peer_converged": peer.converged}
    label = f"{LIBIGL}, one handle times {HANDLES}"
    peer_seconds = HANDLES * peer.seconds
    yield compare(name, "weights", "s", seconds, label, peer_seconds, info.converged, beside)
    yield Row(name, "relative duality gap", "", info.gap, converged=info.converged, sizes=sizes)


def reference_rows(name: str) -> Iterator[Row]:
    """The same on a mesh that is small enough for general solvers, and for PIQP's eleven digits."""
    mesh = tube(REFERENCE_VERTICES, 1)
    handles = mesh.spread_handles(HANDLES)
    weights, seconds, info = solve_by_tug(mesh, handles)
    exact = solve_by_piqp(mesh, handles)
    libigl = solve_by_libigl(mesh, handles, HANDLES)
    sums = libigl.weights.sum(axis=1, keepdims=True)
    peers = {
        "PIQP, 1e-11": exact,
        f"OSQP, {OSQP_TOLERANCE:g}": solve_by_osqp(mesh, handles),
        LIBIGL: replace(libigl, weights=libigl.weights / sums),
    }
    difference = float(np.abs(weights - exact.weights).max())
    metric = "largest difference from PIQP's weights, small mesh"
    for peer, found in peers.items():
        sizes = {"vertices": mesh.shapes.shape[1], "handles": HANDLES}
        sizes["peer_converged"] = found.converged
        both = (name, "weights, small mesh", "s", seconds, peer, found.seconds)
        yield compare(*both, info.converged, sizes)
        if found is not exact:
            peer_difference = float(np.abs(found.weights - exact.weights).max())
            both = (name, metric, "", difference, peer, peer_difference)
            yield compare(*both, info.converged, sizes)
