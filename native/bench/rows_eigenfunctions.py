# SPDX-License-Identifier: GPL-3.0-or-later
"""The row on eigenfunctions of the Laplace-Beltrami operator: eigenfunctions_25k."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from conic import rigidity
from data import ExampleSet
from generated import tube
from library import EigenfunctionsInfo, Mesh, compute_eigenfunctions
from suite import Row, Suite, compare
from weights_peers import lumped_mass

FUNCTIONS = 15  # the most that FBT takes
REPEATS = 3
LARGEST_RESIDUAL = 1e-9  # of what counts as converged


def solve_by_tug(mesh: ExampleSet) -> tuple[np.ndarray, float, EigenfunctionsInfo]:
    """Eigenvalues, seconds, and how it ended."""
    with Mesh(mesh.shapes[0], mesh.triangles) as native_mesh:
        start = time.perf_counter()
        values, _, info = compute_eigenfunctions(native_mesh, FUNCTIONS)
        return values, time.perf_counter() - start, info


def solve_by_scipy(mesh: ExampleSet) -> tuple[np.ndarray, float]:
    """The same by ARPACK with shift and inversion, from given matrices."""
    vertices, triangles = mesh.shapes[0], mesh.triangles
    mass = lumped_mass(vertices, triangles)
    L, M = rigidity(vertices, triangles).tocsc(), scipy.sparse.diags(mass / mass.sum()).tocsc()
    start = time.perf_counter()
    values, _ = scipy.sparse.linalg.eigsh(L, FUNCTIONS, M=M, sigma=-1.0)
    return values, time.perf_counter() - start


def eigenfunction_rows(suite: Suite, name: str, vertices: int) -> Iterator[Row]:
    """Seconds on a mesh of this size beside SciPy's, and whether both find the same."""
    mesh = tube(int(suite.size * vertices), 1)
    runs = [solve_by_tug(mesh) for _ in range(REPEATS)]
    peer_runs = [solve_by_scipy(mesh) for _ in range(REPEATS)]
    values, _, info = runs[0]
    seconds, peer_seconds = (float(np.median([run[1] for run in of])) for of in (runs, peer_runs))
    converged = info.residual < LARGEST_RESIDUAL
    sizes = {
        "vertices": mesh.shapes.shape[1],
        "functions": FUNCTIONS,
        "solves": info.solves,
        "residual": info.residual,
    }
    label = "SciPy's eigsh"
    yield compare(name, "eigenfunctions", "s", seconds, label, peer_seconds, converged, sizes)
    difference = float(np.abs(values[1:] / peer_runs[0][0][1:] - 1.0).max())
    metric = "largest relative difference from SciPy's eigenvalues"
    yield Row(name, metric, "", difference, sizes=sizes)
