# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's minimal energy for one reference shape, whichever it is, in the dictionary of all (F 13):
what a comparison with one shape alone makes of its targets. Slow; for comparison only."""

from __future__ import annotations

import numpy as np
from fitting import Found, Stages
from project import find_rotations

ROUNDS, TOLERANCE = 1000, 1e-5


def edge_products(
    triangles: np.ndarray, rest: np.ndarray, first: np.ndarray, second: np.ndarray
) -> float:
    """Sum over the edges of all triangles of c <first, second>, c being half the cotangent of the
    opposite angle at rest. first, second: #F by 3 by 3, the edges of each triangle."""
    edges = edges_of(triangles, rest)
    across = -np.sum(np.roll(edges, 1, axis=1) * np.roll(edges, 2, axis=1), axis=2)
    doubled = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return float(np.sum(0.5 * across / doubled[:, None] * np.sum(first * second, axis=2)))


def edges_of(triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """#F by 3 by 3, each edge opposite to the corner of its number."""
    corners = positions[triangles]
    return np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)


def solve_with_one(stages: Stages, targets: np.ndarray, reference: int = 0) -> Found:
    """From the start of the stages, by turns: transforms, rotations, scale (F 17-19)."""
    body, solver = stages.body, stages.solvers[-1]
    sizes, groups = solver.sizes, body.functions.groups
    blend = np.zeros((sizes.groups, sizes.shapes))
    blend[:, reference] = 1.0
    edges = edges_of(body.triangles, body.shapes[reference])
    whole = edge_products(body.triangles, body.rest, edges, edges)
    rotations, scale = stages.start.rotations(targets), 1.0
    for _ in range(ROUNDS):
        solver.pose(targets / scale, blend, rotations)
        positions = solver.positions()
        rotations = find_rotations(body.mesh, body.shapes, groups, positions)
        turned = np.einsum("fij,fej->fei", rotations[groups, reference], edges)
        posed = edges_of(body.triangles, positions)
        growth = edge_products(body.triangles, body.rest, turned, posed) / whole
        scale *= growth
        if abs(growth - 1) < TOLERANCE:
            break
    return Found(scale / growth * positions, scale)
