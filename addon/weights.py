# SPDX-License-Identifier: GPL-3.0-or-later
"""Weight functions on a mesh, #V by #W, and edge groups, #F, that fit them.

The conventions are those of solver.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_int32
from dataclasses import dataclass

import numpy as np

from . import native
from .geometry import Mesh, as_shapes
from .native import Progress
from .objects import as_matrix, fields_of, offsets, set_options


@dataclass(frozen=True)
class WeightsInfo:
    """How the weights' quadratic programs ended: see tug_weights_info."""

    converged: bool
    iterations: int
    gap: float
    kkt_residual: float
    bound_violation: float


@dataclass(frozen=True)
class EigenfunctionsInfo:
    """How eigenfunctions were found: see tug_eigenfunctions_info."""

    constants: int
    solves: int
    residual: float


@dataclass(frozen=True)
class SkeletonInfo:
    """How well bones explain the shapes: see tug_skeleton_info."""

    converged: bool
    rounds: int
    error: float
    objective: float


def compute_weights(
    mesh: Mesh,
    handles: Sequence[Sequence[int]],
    *,
    progress: Progress | None = None,
    **options: float,
) -> tuple[np.ndarray, WeightsInfo]:
    """Bounded biharmonic weights, #V by #W, rows summing to one. About a second at 20,000 vertices.

    handles: the vertices of each handle. Options, each with the library's default: tolerance,
    max_iterations, threads, follow_nearest (1: a component without a handle follows the nearest).
    """
    given, info = native.tug_weights_options(), native.tug_weights_info()
    native.library().tug_default_weights_options(byref(given))
    set_options(given, options)
    vertices = np.array([vertex for handle in handles for vertex in handle], np.int32)
    weights = np.empty((mesh.vertex_count, len(handles)))
    with native.reporting(progress) as callback:
        native.library().tug_compute_weights(
            *(mesh._pointer, offsets(handles), vertices, len(handles)),
            *(byref(given), callback, None, weights, byref(info)),
        )
    return weights, WeightsInfo(**fields_of(info))


def compute_eigenfunctions(
    mesh: Mesh, count: int, *, progress: Progress | None = None
) -> tuple[np.ndarray, np.ndarray, EigenfunctionsInfo]:
    """The `count` smallest eigenpairs of the Laplace-Beltrami operator, L f = mu M f: values mu
    (count, rising) and functions (#V by count, orthonormal in M). Fractions of a second.

    The mass is in parts of the whole area, so neither has a unit. The first function is 1; each
    further component of the mesh has one of eigenvalue 0.
    """
    values, functions = np.empty(max(count, 0)), np.empty((mesh.vertex_count, max(count, 0)))
    info = native.tug_eigenfunctions_info()
    with native.reporting(progress) as callback:
        native.library().tug_compute_eigenfunctions(
            mesh._pointer, count, callback, None, values, functions, byref(info)
        )
    return values, functions, EigenfunctionsInfo(**fields_of(info))


def find_skeleton(
    mesh: Mesh,
    shapes: np.ndarray,
    bones: int,
    *,
    progress: Progress | None = None,
    **options: float,
) -> tuple[np.ndarray, SkeletonInfo]:
    """Weights of rigid bones that explain the shapes (#S by #V by k, the rest shape first): #V by
    at most `bones`, with at most four in a row, which sum to one. Seconds at 25,000 vertices.

    Options, each with the library's default: smoothness, tolerance, max_rounds.
    """
    shapes = as_shapes(mesh, shapes)
    given, info = native.tug_skeleton_options(), native.tug_skeleton_info()
    native.library().tug_default_skeleton_options(byref(given))
    set_options(given, options)
    room, found = np.empty((mesh.vertex_count, max(bones, 0))), c_int32()
    with native.reporting(progress) as callback:
        native.library().tug_find_skeleton(
            *(mesh._pointer, shapes, len(shapes), bones, byref(given)),
            *(callback, None, room, byref(found), byref(info)),
        )
    weights = room.ravel()[: len(room) * found.value].reshape(len(room), found.value)
    return weights.copy(), SkeletonInfo(**fields_of(info))


def cluster_triangles(
    mesh: Mesh, weights: np.ndarray, count: int, *, progress: Progress | None = None
) -> np.ndarray:
    """Edge groups: #F numbers from 0, at most `count` different ones. O(rounds #F #W count)."""
    weights = as_matrix(weights, np.float64, rows=mesh.vertex_count)
    groups, found = np.empty(mesh.triangle_count, np.int32), c_int32()
    with native.reporting(progress) as callback:
        native.library().tug_cluster_triangles(
            *(mesh._pointer, weights, weights.shape[1], count),
            *(callback, None, groups, byref(found)),
        )
    return groups


def cluster_by_eigenfunctions(
    mesh: Mesh,
    values: np.ndarray,
    functions: np.ndarray,
    count: int,
    *,
    progress: Progress | None = None,
) -> np.ndarray:
    """Edge groups, as from cluster_triangles, where eigenfunctions are the weights.

    Triangles are near where f_i / mu_i are: the biharmonic distance (Lipman et al. 2010). Functions
    of eigenvalue 0 count as much as the first of another, which keeps components apart.
    """
    least = values[values > 0].min(initial=values.max() or 1.0)
    features = functions / np.maximum(values, least)
    return cluster_triangles(mesh, features, count, progress=progress)
