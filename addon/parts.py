# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose parts of a mesh, as eyes and teeth are: what happens to those without a handle.

The conventions are those of solver.py.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .dictionaries import Dictionary, Functions, make_functions
from .geometry import Mesh, Points
from .native import Progress

FLOATING = 1e-10  # of the square of a function, what may be left where it should be nothing


def make_followed_functions(
    kind: Dictionary,
    mesh: Mesh,
    shapes: np.ndarray,
    handles: Sequence[int],
    *,
    group_count: int = 0,
    progress: Progress | None = None,
) -> Functions:
    """As make_functions, of the parts with a handle alone; each other part moves with the vertex of
    those that is nearest to it."""
    component = mesh.components()
    kept = np.isin(component, component[handles])
    vertices, numbers = np.flatnonzero(kept), np.cumsum(kept) - 1
    inside = kept[mesh.triangles[:, 0]]
    with Mesh(shapes[0, vertices], numbers[mesh.triangles[inside]]) as piece:
        made = make_functions(
            *(kind, piece, shapes[:, vertices], numbers[handles]),
            group_count=group_count,
            progress=progress,
        )
    leader = np.where(kept, np.arange(len(kept)), -1)
    nearest, distances = Points(shapes[0, vertices]).nearest(shapes[0])
    for part in np.unique(component[~kept]):
        members = np.flatnonzero(component == part)
        leader[members] = vertices[nearest[members[distances[members].argmin()]]]
    group_of_vertex = np.zeros(len(kept), np.int32)
    group_of_vertex[mesh.triangles[inside]] = made.groups[:, None]
    groups = group_of_vertex[leader[mesh.triangles[:, 0]]]
    groups[inside] = made.groups
    return Functions(made.weights[numbers[leader]], groups)


def find_floating(mesh: Mesh, weights: np.ndarray, handles: Sequence[int]) -> int:
    """The first vertex of a part that no handle holds, or -1.

    Parts float where some combination of the weights is zero on all parts with a handle and
    constant on each of the others: it moves those at no cost.
    """
    component = mesh.components()
    kept = np.isin(component, component[handles])
    if kept.all():
        return -1
    functions, _ = np.linalg.qr(weights)
    counts = np.bincount(component)
    means = np.stack([np.bincount(component, column) / counts for column in functions.T], axis=1)
    rest = functions - np.where(kept[:, None], 0, means[component])
    squares, combinations = np.linalg.eigh(rest.T @ rest)
    if squares[0] > FLOATING:
        return -1
    moved = np.abs(functions @ combinations[:, 0]).argmax()
    return int(np.flatnonzero(component == component[moved])[0])
