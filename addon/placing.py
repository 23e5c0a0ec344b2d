# SPDX-License-Identifier: GPL-3.0-or-later
"""What rows must tell so that they place a body in space, whatever its pose is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .geometry import Mesh
from .parts import find_floating

# Of the spread across the line that fits best to that along it, below which points are on a line.
COLLINEAR = 1e-3


def leaves_turn_open(points: np.ndarray) -> bool:
    """Whether points (#P by k) are on one line, or in the plane at one place, so that a body held
    there may turn about it."""
    wanted = points.shape[1] - 1  # directions in which they must be spread
    if len(points) <= wanted:
        return True
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[wanted - 1] <= COLLINEAR * spread[0])


def check_parts(mesh: Mesh, weights: np.ndarray, vertices: Sequence[int], what: str) -> None:
    """Raises ValueError where a part of the mesh has none of these vertices, which `what` names in
    the singular, and moves by weights (#V by #W) of its own."""
    if not len(vertices):
        raise ValueError(f"there is no {what}: give each part of the mesh one")
    floating = find_floating(mesh, weights, vertices)
    if floating >= 0:
        parts = mesh.components().max() + 1
        raise ValueError(
            f"the mesh has {parts} parts that are not connected, and the one with vertex "
            f"{floating} has no {what}: give each part one"
        )


def check_vertices(vertices: Sequence[int], count: int, what: str) -> None:
    """Raises ValueError where one of them is not a number from 0 to count - 1."""
    if bad := [int(vertex) for vertex in vertices if not 0 <= vertex < count]:
        raise ValueError(f"there is no vertex {bad[0]} for a {what}, only 0 to {count - 1}")
