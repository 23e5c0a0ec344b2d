# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing without Blender: libtug with NumPy arrays in and out.

    mesh + handles -> compute_weights -> cluster_triangles -> Model -> Solver -> positions

`make_solver` does all of it at once; meshes and rows are those of geometry.py. #V vertices, #F
triangles, k dimensions (2 or 3), #S shapes, #W weight functions, #H constraint rows, #G edge
groups; lengths in any unit. Mesh, Points, Model and Solver own memory of the library: close them,
or use them as context managers. Every function may raise native.TugError with the library's own
words, and native.LibraryError where there is no library.

A `progress` is called as progress(stage, fraction) at least every 0.1 s or so, with a short English
phrase and 0 to 1; an exception it raises cancels the call and comes out of it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, byref, c_int32
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

import numpy as np

from . import native
from .geometry import Mesh, Rows
from .native import Progress
from .objects import Memory, Owner, as_matrix, fields_of, offsets, set_options


class Form(IntEnum):
    """What a solve minimises: tug_form of tug.h."""

    STEADY = 0
    PAPER = 1
    NO_ROTATIONS = 2
    TRUST_REGION = 3
    AVERAGE = 4
    MINIMAL = 5
    CLOSEST = 6


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


@dataclass(frozen=True)
class ModelSizes:
    """Counts of a model: see tug_model_sizes."""

    vertices: int
    dimension: int
    shapes: int
    weights: int
    rows: int
    groups: int
    unknowns: int
    rank: int


@dataclass(frozen=True)
class SolveInfo:
    """How a solve ended: see tug_solve_info."""

    converged: bool
    rounds: int
    objective: float
    energy: float
    gap: float
    residual: float
    increase: float


@dataclass(frozen=True)
class BlendInfo:
    """How a blend's optimum was found: see tug_blend_info."""

    pivots: int
    objective: float
    gap: float


@dataclass(frozen=True)
class ElasticNetInfo:
    """How an elastic net ended: see tug_elastic_net_info."""

    converged: bool
    rounds: int
    gap: float


class Model(Owner):
    """The constants of a solve; its size does not depend on #V but for the dictionary.

    shapes: #S by #V by k, the rest shape first. weights: #V by #W, whose span holds the constant.
    groups: #F, as from cluster_triangles. A weight function that no row pins is a free handle.
    stiffness: #F factors of the triangles' energies, or None for one: stiff regions deform less.
    smoothness: beta_sm of (F 10), what uneven influences of shapes and translation cost.
    O(#V (#W #S k)^2). The mesh may be closed afterwards.
    """

    def __init__(
        self,
        mesh: Mesh,
        shapes: np.ndarray,
        weights: np.ndarray,
        rows: Rows,
        groups: np.ndarray,
        *,
        stiffness: np.ndarray | None = None,
        smoothness: float = 0.0,
        progress: Progress | None = None,
    ) -> None:
        shapes = as_shapes(mesh, shapes)
        weights = as_matrix(weights, np.float64, rows=mesh.vertex_count)
        groups = as_groups(mesh, groups)
        if stiffness is not None:
            stiffness = _fitting("stiffness", stiffness, mesh.triangle_count)
        factors = None if stiffness is None else stiffness.ctypes.data_as(POINTER(ctypes.c_double))
        out = POINTER(native.tug_model)()
        with native.reporting(progress) as callback:
            native.library().tug_create_model(
                *(mesh._pointer, shapes, len(shapes), weights, weights.shape[1]),
                *(byref(_native_rows(rows)), groups, int(groups.max(initial=-1)) + 1),
                *(factors, smoothness, callback, None, byref(out)),
            )
        super().__init__(Memory(out, native.library().tug_destroy_model))

    @property
    def sizes(self) -> ModelSizes:
        sizes = native.tug_model_sizes()
        native.library().tug_get_model_sizes(self._pointer, byref(sizes))
        return ModelSizes(**fields_of(sizes))

    def change_rows(self, rows: Rows, firmness: np.ndarray | None = None) -> Self:
        """The same model with other rows, without the mesh: some tens of milliseconds. firmness:
        #H, beta_lc of (F 10), for rows that may be many; None pins them."""
        if firmness is not None:
            firmness = _fitting("firmness", firmness, len(rows))
        factors = None if firmness is None else firmness.ctypes.data_as(POINTER(ctypes.c_double))
        out = POINTER(native.tug_model)()
        native.library().tug_change_rows(
            self._pointer, byref(_native_rows(rows)), factors, byref(out)
        )
        return self._own(out)

    def save(self) -> bytes:
        """The model as one versioned and checksummed blob, in this machine's byte order."""
        size = native.library().tug_model_blob_size(self._pointer)
        blob = ctypes.create_string_buffer(size)
        native.library().tug_save_model(self._pointer, blob, size)
        return blob.raw

    @classmethod
    def load(cls, blob: bytes) -> Self:
        """The model of `save`. Anything but a whole, unchanged blob of this version fails."""
        out = POINTER(native.tug_model)()
        native.library().tug_load_model(bytes(blob), len(blob), byref(out))
        return cls._own(out)

    @classmethod
    def _own(cls, out: object) -> Self:
        model = cls.__new__(cls)
        Owner.__init__(model, Memory(out, native.library().tug_destroy_model))
        return model


class Solver(Owner):
    """A workspace on a model, for one thread at a time. The model may be closed before it.

    Options, each with the library's default: form (a Form), squared, single_blend, warm_start,
    scale (1: the shapes may be larger or smaller), max_rounds, lambda_ (weight of the costs), prior
    (of the steady form), tolerance (radians).
    """

    def __init__(self, model: Model, **options: float) -> None:
        self.sizes = model.sizes
        given = native.tug_solver_options()
        native.library().tug_default_solver_options(byref(given))
        set_options(given, options)
        out = POINTER(native.tug_solver)()
        native.library().tug_create_solver(model._pointer, byref(given), byref(out))
        super().__init__(Memory(out, native.library().tug_destroy_solver, model._memory))

    def set_firmness(self, firmness: np.ndarray) -> None:
        """How firmly each row is held from here on, #H: inf, as at first, pins it, 0 lets it go,
        and w between is a spring, w times as stiff as the surface there. Nothing is bound anew."""
        firmness = _fitting("firmness", firmness, self.sizes.rows)
        native.library().tug_set_firmness(self._pointer, firmness)

    def set_orientations(self, orientations: np.ndarray, firmness: np.ndarray) -> None:
        """How the surface around each row is turned from here on, #H by k by k rotations from the
        rest shape, and how firmly, #H: 0, as at first, not at all, 1 as stiff as the surface, inf
        exactly. Each acts on the edge group nearest to its row."""
        rows, k = self.sizes.rows, self.sizes.dimension
        orientations = _fitting("orientations", orientations, rows, k, k)
        firmness = _fitting("firmness", firmness, rows)
        native.library().tug_set_orientations(self._pointer, orientations, firmness)

    def solve(self, targets: np.ndarray, start: np.ndarray | None = None) -> SolveInfo:
        """Find the pose for targets, #H by k. Time does not depend on #V. A solve that failed
        leaves the last pose as it was.

        start: rotations to start from, #G by #S by k by k, in place of a cold start, as those of a
        solver on a smaller dictionary of the same groups and shapes. The pose is then a function of
        targets and start."""
        targets = _fitting("targets", targets, self.sizes.rows, self.sizes.dimension)
        info = native.tug_solve_info()
        if start is None:
            native.library().tug_solve(self._pointer, targets, byref(info))
        else:
            start = self._fitting_rotations("start", start)
            native.library().tug_solve_from(self._pointer, targets, start, byref(info))
        return SolveInfo(**fields_of(info))

    def pose(self, targets: np.ndarray, blend: np.ndarray, rotations: np.ndarray) -> None:
        """Instead of a solve, the pose of least energy for targets, a blend and rotations, of the
        shapes that `blend` and `rotations` give: to mix those of several solves."""
        sizes = self.sizes
        targets = _fitting("targets", targets, sizes.rows, sizes.dimension)
        blend = _fitting("blend", blend, sizes.groups, sizes.shapes)
        rotations = self._fitting_rotations("rotations", rotations)
        native.library().tug_pose(self._pointer, targets, blend, rotations)

    def _fitting_rotations(self, name: str, rotations: np.ndarray) -> np.ndarray:
        sizes, k = self.sizes, self.sizes.dimension
        return _fitting(name, rotations, sizes.groups, sizes.shapes, k, k)

    def positions(self) -> np.ndarray:
        """#V by k positions of the last solve. O(#V #W #S k)."""
        positions = np.empty((self.sizes.vertices, self.sizes.dimension))
        native.library().tug_get_positions(self._pointer, positions)
        return positions

    def blend(self) -> np.ndarray:
        """#G by #S weights of the shapes in the last solve; rows sum to one."""
        blend = np.empty((self.sizes.groups, self.sizes.shapes))
        native.library().tug_get_blend(self._pointer, blend)
        return blend

    def costs(self) -> np.ndarray:
        """#G by #S costs of the shapes in the last solve: sqrt(D_gs) of (A 10), D_gs if squared."""
        costs = np.empty((self.sizes.groups, self.sizes.shapes))
        native.library().tug_get_costs(self._pointer, costs)
        return costs

    def rotations(self) -> np.ndarray:
        """#G by #S by k by k rotations of the last solve."""
        k = self.sizes.dimension
        rotations = np.empty((self.sizes.groups, self.sizes.shapes, k, k))
        native.library().tug_get_rotations(self._pointer, rotations)
        return rotations

    def scale(self) -> float:
        """How much larger the shapes are in the last pose than given: 1 but with `scale`."""
        scale = ctypes.c_double()
        native.library().tug_get_scale(self._pointer, byref(scale))
        return scale.value


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


def reduce_dictionary(
    shapes: np.ndarray, weights: np.ndarray, count: int, *, progress: Progress | None = None
) -> np.ndarray:
    """Numbers of `count` atoms of the dictionary of shapes (#S by #V by k) and weights (#V by #W)
    that stand for all, by k-medoids; see tug_reduce_dictionary. O(#V b^2), b = #W (1 + #S k).

    Atom h (1 + #S k) is weight function h; the next #S k are that times each coordinate.
    """
    given, _keep = _native_dictionary(shapes, weights)
    atoms = np.empty(max(count, 0), np.int32)
    with native.reporting(progress) as callback:
        native.library().tug_reduce_dictionary(byref(given), count, callback, None, atoms)
    return atoms


def fit_dictionary(
    shapes: np.ndarray,
    weights: np.ndarray,
    positions: np.ndarray,
    atoms: np.ndarray | None = None,
    *,
    progress: Progress | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Change of dictionary, (F 24): transforms T (#W (1 + #S k) by k) and the positions D T nearest
    to `positions` (#V by k), those of a pose in another dictionary for instance.

    atoms: the only ones to use, as from reduce_dictionary; all of them where it is None.
    """
    given, _keep = _native_dictionary(shapes, weights)
    positions = as_matrix(positions, np.float64, rows=given.vertex_count)
    if positions.shape[1] != given.dimension:
        raise ValueError(f"positions must have {given.dimension} columns, not {positions.shape[1]}")
    chosen = None if atoms is None else np.ascontiguousarray(atoms, np.int32)
    columns = given.weight_count * (1 + given.shape_count * given.dimension)
    transforms, fitted = np.empty((columns, given.dimension)), np.empty_like(positions)
    with native.reporting(progress) as callback:
        native.library().tug_fit_dictionary(
            byref(given),
            None if chosen is None else chosen.ctypes.data_as(POINTER(c_int32)),
            *(0 if chosen is None else len(chosen), positions),
            *(callback, None, transforms, fitted),
        )
    return transforms, fitted


def make_solver(
    shapes: np.ndarray,
    triangles: np.ndarray,
    handles: Sequence[int],
    *,
    free: Sequence[int] = (),
    stiffness: np.ndarray | None = None,
    progress: Progress | None = None,
    **options: float,
) -> Solver:
    """From shapes (#S by #V by k, the rest shape first), triangles and handle vertices to a Solver.

    Each handle has one weight function and each that is not in `free` (numbers of handles) one row,
    in order; there are twice as many groups as handles. stiffness is that of Model, options are
    those of Solver. Seconds.
    """
    pinned = [vertex for number, vertex in enumerate(handles) if number not in set(free)]
    with Mesh(shapes[0], triangles) as mesh:
        weights, _ = compute_weights(mesh, [[vertex] for vertex in handles], progress=progress)
        groups = cluster_triangles(mesh, weights, 2 * len(handles), progress=progress)
        rows = Rows.pin(pinned)
        with Model(
            mesh, shapes, weights, rows, groups, stiffness=stiffness, progress=progress
        ) as model:
            return Solver(model, **options)


def minimise_blend(
    quadratic: np.ndarray,
    linear: np.ndarray,
    constant: float,
    costs: np.ndarray,
    blend: np.ndarray,
    *,
    lambda_: float = 0.5,
    squared: bool = False,
) -> tuple[np.ndarray, BlendInfo]:
    """The optimum of (A 20) with the transforms eliminated, from `blend` (#G by #S) on.

    quadratic: n by n, n = #G #S; linear, costs: n.
    """
    count, shapes = blend.shape
    result, info = np.array(blend, np.float64).ravel(), native.tug_blend_info()
    quadratic = as_matrix(quadratic, np.float64, rows=count * shapes)
    linear, costs = (np.ascontiguousarray(vector, np.float64) for vector in (linear, costs))
    if not quadratic.shape[1] == len(linear) == len(costs) == count * shapes:
        raise ValueError("the quadratic and linear parts and the costs must fit the blend")
    native.library().tug_minimise_blend(
        *(count, shapes, quadratic, linear, constant, costs, lambda_, squared, result, byref(info)),
    )
    return result.reshape(count, shapes), BlendInfo(**fields_of(info))


def solve_elastic_net(
    X: np.ndarray,
    Y: np.ndarray,
    penalty: np.ndarray,
    *,
    fit: float = 1.0,
    smoothness: float = 0.0,
    sparsity: float = 0.0,
) -> tuple[np.ndarray, ElasticNetInfo]:
    """(F 20-23): T, b by k, that minimises 1/2 fit |X T - Y|^2 + 1/2 smoothness tr(T^T Lambda T) +
    sparsity |T|_1, the weights being beta_lc, beta_sm and beta_sp.

    X: #H by b. Y: #H by k. penalty: Lambda, b by b and positive semidefinite, or its diagonal, b.
    With sparsity 0 it is (F 22), of least norm where that leaves T open.
    """
    X, Y = as_matrix(X, np.float64), as_matrix(Y, np.float64, rows=len(X))
    penalty = np.asarray(penalty, np.float64)
    penalty = np.ascontiguousarray(np.diag(penalty) if penalty.ndim == 1 else penalty)
    if penalty.shape != (X.shape[1], X.shape[1]):
        raise ValueError(f"the penalty must fit the {X.shape[1]} columns of X, not {penalty.shape}")
    T, info = np.empty((X.shape[1], Y.shape[1])), native.tug_elastic_net_info()
    native.library().tug_solve_elastic_net(
        *(*X.shape, Y.shape[1], X, Y, penalty, fit, smoothness, sparsity, T, byref(info))
    )
    return T, ElasticNetInfo(**fields_of(info))


def as_shapes(mesh: Mesh, shapes: np.ndarray) -> np.ndarray:
    shapes = np.ascontiguousarray(shapes, np.float64)
    if shapes.ndim != 3 or shapes.shape[1:] != (mesh.vertex_count, mesh.dimension):
        raise ValueError(
            f"shapes must be #S by {mesh.vertex_count} by {mesh.dimension}, not {shapes.shape}"
        )
    return shapes


def as_groups(mesh: Mesh, groups: np.ndarray) -> np.ndarray:
    groups = np.ascontiguousarray(groups, np.int32)
    if groups.shape != (mesh.triangle_count,):
        raise ValueError(f"groups must be #F = {mesh.triangle_count} numbers")
    return groups


def _fitting(name: str, array: np.ndarray, *shape: int) -> np.ndarray:
    array = np.ascontiguousarray(array, np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} must be {' by '.join(map(str, shape))}, not {array.shape}")
    return array


def _native_rows(rows: Rows) -> native.tug_rows:
    given = native.tug_rows(count=len(rows))
    given.starts = rows.starts.ctypes.data_as(POINTER(c_int32))
    given.vertices = rows.vertices.ctypes.data_as(POINTER(c_int32))
    given.values = rows.values.ctypes.data_as(POINTER(ctypes.c_double))
    return given


def _native_dictionary(
    shapes: np.ndarray, weights: np.ndarray
) -> tuple[native.tug_dictionary, tuple[np.ndarray, np.ndarray]]:
    """The struct, and the arrays that it borrows."""
    shapes = np.ascontiguousarray(shapes, np.float64)
    if shapes.ndim != 3:
        raise ValueError(f"shapes must be #S by #V by k, not {shapes.shape}")
    weights = as_matrix(weights, np.float64, rows=shapes.shape[1])
    count, vertices, dimension = shapes.shape
    given = native.tug_dictionary(
        vertex_count=vertices,
        dimension=dimension,
        shape_count=count,
        weight_count=weights.shape[1],
    )
    given.shapes = shapes.ctypes.data_as(POINTER(ctypes.c_double))
    given.weights = weights.ctypes.data_as(POINTER(ctypes.c_double))
    return given, (shapes, weights)
