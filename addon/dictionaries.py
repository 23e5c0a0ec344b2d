# SPDX-License-Identifier: GPL-3.0-or-later
"""Which weight functions, and edge groups with them, span the poses: one choice, whatever the
energy is.

The conventions are those of solver.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from .geometry import Mesh
from .native import Progress, part
from .objects import as_matrix
from .weights import (
    cluster_by_eigenfunctions,
    cluster_triangles,
    compute_eigenfunctions,
    compute_weights,
    find_skeleton,
)


class Dictionary(StrEnum):
    """What the weight functions are.

    HANDLES: bounded biharmonic, a function a handle: can be painted.
    EIGENFUNCTIONS: those of the Laplace-Beltrami operator, which need no handles.
    SKELETON: bones that the examples show.
    """

    HANDLES = "HANDLES"
    EIGENFUNCTIONS = "EIGENFUNCTIONS"
    SKELETON = "SKELETON"


GROUPS_A_HANDLE = 2
EIGENFUNCTIONS = 15  # as in F's experiments
EIGENFUNCTION_GROUPS = 15
BONES = 20


@dataclass(frozen=True)
class Functions:
    """Weight functions, #V by #W, whose span holds the constant, and edge groups, #F."""

    weights: np.ndarray
    groups: np.ndarray


def make_functions(
    kind: Dictionary,
    mesh: Mesh,
    shapes: np.ndarray,
    handles: Sequence[int],
    *,
    group_count: int = 0,
    progress: Progress | None = None,
) -> Functions:
    """The functions of a dictionary. Fractions of a second, with a skeleton seconds.

    shapes: #S by #V by k, the rest shape first; only a skeleton sees where the others are. handles:
    vertices; only their number matters but for HANDLES. group_count: groups at most; 0 takes as
    many as suit the dictionary.
    """
    finding, grouping = part(progress, 0.0, 0.8), part(progress, 0.8, 1.0)
    match Dictionary(kind):
        case Dictionary.HANDLES:
            weights, _ = compute_weights(mesh, [[handle] for handle in handles], progress=finding)
            group_count = group_count or GROUPS_A_HANDLE * weights.shape[1]
            return functions_of_weights(mesh, weights, group_count, progress=grouping)
        case Dictionary.EIGENFUNCTIONS:
            count = eigenfunction_count(mesh, shapes, len(handles))
            values, functions, _ = compute_eigenfunctions(mesh, count, progress=finding)
            groups = cluster_by_eigenfunctions(
                *(mesh, values, functions, group_count or EIGENFUNCTION_GROUPS), progress=grouping
            )
            return Functions(functions, groups)
        case Dictionary.SKELETON:
            weights, _ = find_skeleton(mesh, shapes, BONES, progress=finding)
            return functions_of_weights(mesh, weights, group_count, progress=grouping)


def functions_of_weights(
    mesh: Mesh, weights: np.ndarray, group_count: int = 0, *, progress: Progress | None = None
) -> Functions:
    """Given weights as a dictionary: those of an armature or any vertex groups, #V by #W, none
    negative, whose rows need not sum to one. group_count: 0 takes one group a function. Raises
    ValueError where a vertex has no weight."""
    weights = as_matrix(weights, np.float64, rows=mesh.vertex_count)
    if len(bad := np.flatnonzero(~(np.isfinite(weights) & (weights >= 0)).all(axis=1))):
        raise ValueError(
            f"vertex {bad[0]} has a weight that is negative or not finite: give it weights from 0 "
            "to 1"
        )
    sums = weights.sum(axis=1, keepdims=True)
    if len(lost := np.flatnonzero(sums[:, 0] <= 0)):
        raise ValueError(
            f"{len(lost)} vertices have no weight, the first is vertex {lost[0]}: give each a "
            "positive weight in one function or more"
        )
    weights = weights / sums
    count = group_count or weights.shape[1]
    return Functions(weights, cluster_triangles(mesh, weights, count, progress=progress))


def eigenfunction_count(mesh: Mesh, shapes: np.ndarray, handle_count: int) -> int:
    """As many as suit most meshes, beside those that tell loose parts from each other. Not more
    than the handles where the dictionary would have more columns than there are vertices; more for
    many handles, which must not depend on each other however alike the shapes are."""
    parts = int(mesh.components().max()) + 1
    columns = 1 + shapes.shape[0] * shapes.shape[2]  # a function
    wanted = min(EIGENFUNCTIONS + parts - 1, mesh.vertex_count // columns)
    needed = max(parts, min(handle_count, EIGENFUNCTIONS), (handle_count + 1) // 2)
    return min(max(wanted, needed), mesh.vertex_count)
