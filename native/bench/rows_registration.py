# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on what a registration does besides solving: nearest_25k, cholesky_update."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterator

import numpy as np
from generated import tube
from library import CHECKOUT, Mesh, Points
from scipy.spatial import cKDTree
from suite import Row, Suite, compare, not_run

REPEATS = 7
UPDATE = CHECKOUT / "build" / "release" / "native" / "time_cholesky_update"


def nearest_rows(suite: Suite) -> Iterator[Row]:
    """The vertices of a pose looked up among those of another, by position, and by position and
    normal: far off, as a registration starts, and near, as it ends."""
    poses = tube(int(suite.size * 25_000), 2)
    with Mesh(poses.shapes[0], poses.triangles) as mesh:
        normals = [0.1 * poses.diagonal * mesh.normals(shape) for shape in poses.shapes]
    for what, parts in (("positions", 1), ("positions and normals", 2)):
        points, far = (
            np.concatenate([shape, normal][:parts], axis=1)
            for shape, normal in zip(poses.shapes, normals, strict=True)
        )
        near = points + 1e-3 * poses.diagonal * np.random.default_rng(0).normal(size=points.shape)
        sizes = {"points": len(points), "dimension": points.shape[1]}
        for metric, *seconds in nearest_seconds(points, {"far": far, "near": near}):
            both = (1e3 * seconds[0], "SciPy's cKDTree", 1e3 * seconds[1])
            yield compare("nearest_25k", f"{metric}, {what}", "ms", *both, None, sizes)


def nearest_seconds(
    points: np.ndarray, queries: dict[str, np.ndarray]
) -> Iterator[tuple[str, float, float]]:
    """Of a tree and of its queries, by the library and by SciPy."""
    yield "a tree", *(median_seconds(lambda make=make: make(points)) for make in (Points, cKDTree))
    ours, theirs = Points(points), cKDTree(points)
    for name, wanted in queries.items():
        calls = [lambda at=wanted: ours.nearest(at), lambda at=wanted: theirs.query(at)]
        yield f"nearest to {name} points", *map(median_seconds, calls)


def median_seconds(call: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def update_rows() -> Iterator[Row]:
    """Ten rows added to and dropped from a factor, beside making it anew."""
    if not UPDATE.exists():
        yield not_run("cholesky_update", f"{UPDATE} was not built")
        return
    run = subprocess.run([UPDATE], check=True, capture_output=True, text=True)
    for line in run.stdout.splitlines():
        what, size, update, *anew = line.split()
        metric = f"10 rows {what}, {size} unknowns"
        for peer, microseconds in zip(("our factorisation", "LAPACK's"), anew, strict=True):
            both = (float(update), peer, float(microseconds))
            yield compare("cholesky_update", metric, "us", *both, None, {})
