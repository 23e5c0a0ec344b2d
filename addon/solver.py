# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing without Blender: libtug with NumPy arrays in and out.

    mesh + handles -> make_functions -> Model -> Solver -> positions

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
from .dictionaries import Dictionary, make_functions
from .geometry import Mesh, Rows, as_groups, as_shapes
from .native import Progress, part
from .objects import Memory, Owner, as_matrix, fields_of, set_options


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
        """#G by #S costs of the shapes in the last solve: sqrt(D_gs) of (A 10), D_gs if squared.
        The average, minimal and closest forms have none."""
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
    dictionary: Dictionary = Dictionary.EIGENFUNCTIONS,
    free: Sequence[int] = (),
    stiffness: np.ndarray | None = None,
    progress: Progress | None = None,
    **options: float,
) -> Solver:
    """From shapes (#S by #V by k, the rest shape first), triangles and handle vertices to a Solver.

    Each handle that is not in `free` (numbers of handles) has one row, in order; a free one has but
    the weight function that Dictionary.HANDLES gives to each. stiffness is that of Model, options
    are those of Solver. Seconds.
    """
    pinned = [vertex for number, vertex in enumerate(handles) if number not in set(free)]
    with Mesh(shapes[0], triangles) as mesh:
        finding, modelling = part(progress, 0.0, 0.6), part(progress, 0.6, 1.0)
        functions = make_functions(dictionary, mesh, shapes, handles, progress=finding)
        with Model(
            *(mesh, shapes, functions.weights, Rows.pin(pinned), functions.groups),
            stiffness=stiffness,
            progress=modelling,
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
