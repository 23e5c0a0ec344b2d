# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on what a registration does besides solving: nearest_25k, other_rows."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
from generated import tube
from library import (
    Mesh,
    Model,
    Points,
    Rows,
    Solver,
    cluster_by_eigenfunctions,
    compute_eigenfunctions,
)
from scipy.spatial import cKDTree
from suite import HANDLES, Row, Suite, compare

REPEATS = 7


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


def other_rows_rows(suite: Suite) -> Iterator[Row]:
    """A row that is let go, and a row more, beside a model from the mesh; #S 6, #W 15."""
    poses = tube(int(suite.size * 25_000), 6)
    vertices = poses.spread_handles(HANDLES + 1)
    fewer, more = Rows.pin(vertices[:-1]), Rows.pin(vertices)
    firmness = np.full(HANDLES, np.inf)
    firmness[-1] = 0.0
    with Mesh(poses.shapes[0], poses.triangles) as mesh:
        values, functions, _ = compute_eigenfunctions(mesh, 15)
        groups = cluster_by_eigenfunctions(mesh, values, functions, 20)
        given = (mesh, poses.shapes, functions)
        with Model(*given, fewer, groups) as model, Solver(model) as solver:
            anew = 1e3 * median_seconds(lambda: Model(*given, fewer, groups).close())
            sizes = vars(model.sizes)
            for metric, call in (
                ("a row let go, tug_set_firmness", lambda: solver.set_firmness(firmness)),
                ("a row more, tug_change_rows", lambda: model.change_rows(more).close()),
            ):
                both = (1e3 * median_seconds(call), "a new model", anew)
                yield compare("other_rows", metric, "ms", *both, None, sizes)
