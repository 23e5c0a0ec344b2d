# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison systems with the face of addon.solver.Solver.

A class for each method, in METHODS by name. All are made from the same things: shapes (#S by #V by
k, the rest shape first), triangles (#F by 3), handles (a vertex for each target), weights (#V by
#W, whose span holds the constant) and groups (#F). Every solve starts cold.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_size_t
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import numpy as np
from library import Mesh, Model, Rows, SolveInfo, Solver, native


@dataclass(frozen=True)
class Info:
    """How a solve ended: see tug_baseline_info."""

    converged: bool
    rounds: int
    objective: float
    residual: float
    increase: float


class tug_baseline(ctypes.Structure):
    """Opaque."""


class tug_baseline_problem(ctypes.Structure):
    _fields_ = [
        ("shapes", POINTER(c_double)),
        ("triangles", POINTER(c_int32)),
        ("handles", POINTER(c_int32)),
        ("weights", POINTER(c_double)),
        ("groups", POINTER(c_int32)),
        ("shape_count", c_int32),
        ("vertex_count", c_int32),
        ("dimension", c_int32),
        ("triangle_count", c_int32),
        ("handle_count", c_int32),
        ("weight_count", c_int32),
        ("group_count", c_int32),
    ]


class tug_baseline_options(native.Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("local_global", c_int32),
        ("max_rounds", c_int32),
        ("tolerance", c_double),
    ]


class tug_baseline_info(native.Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("converged", c_int32),
        ("rounds", c_int32),
        ("objective", c_double),
        ("residual", c_double),
        ("increase", c_double),
    ]


FUNCTIONS: dict[str, tuple] = {
    "tug_error_text": (c_char_p,),
    # void tug_baseline_default_options(tug_baseline_options *options);
    "tug_baseline_default_options": (None, POINTER(tug_baseline_options)),
    # tug_status tug_baseline_create(int32_t method, const tug_baseline_problem *problem,
    #                                const tug_baseline_options *options, tug_baseline **out);
    "tug_baseline_create": (
        *(native.Status, c_int32, POINTER(tug_baseline_problem), POINTER(tug_baseline_options)),
        POINTER(POINTER(tug_baseline)),
    ),
    # tug_status tug_baseline_change_rows(tug_baseline *baseline, const tug_rows *rows,
    #                                     const double *firmness);
    "tug_baseline_change_rows": (
        *(native.Status, POINTER(tug_baseline), POINTER(native.tug_rows), native.Vector),
    ),
    # void tug_baseline_destroy(tug_baseline *baseline);
    "tug_baseline_destroy": (None, POINTER(tug_baseline)),
    # tug_status tug_baseline_solve(tug_baseline *baseline, const double *targets,
    #                               tug_baseline_info *info);
    "tug_baseline_solve": (
        *(native.Status, POINTER(tug_baseline), native.Matrix, POINTER(tug_baseline_info)),
    ),
    # tug_status tug_baseline_get_positions(const tug_baseline *baseline, double *positions);
    "tug_baseline_get_positions": (native.Status, POINTER(tug_baseline), native.Matrix),
    # tug_status tug_baseline_get_blend(const tug_baseline *baseline, double *blend);
    "tug_baseline_get_blend": (native.Status, POINTER(tug_baseline), native.Vector),
}


@functools.cache
def library() -> ctypes.CDLL:
    """libtug_baselines, which the build leaves beside libtug."""
    places = [place.with_name("libtug_baselines.so") for place in native.candidates()]
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        raise native.LibraryError(f"no libtug_baselines.so; tried: {', '.join(map(str, places))}")
    loaded = ctypes.CDLL(str(Path(path).resolve()))

    def check(status: native.Status, function: object, arguments: tuple) -> None:
        if status.value:
            raise native.TugError(status.value, loaded.tug_error_text().decode())

    for name, (result, *arguments) in FUNCTIONS.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
        if result is native.Status:
            function.errcheck = check
    return loaded


def _pointer(array: np.ndarray, kind: type) -> object:
    return array.ctypes.data_as(POINTER(kind))


class Baseline:
    """A method of libtug_baselines. Options, each with the library's default: local_global,
    max_rounds, tolerance."""

    number: ClassVar[int]  # of the method in baselines.h

    def __init__(
        self,
        shapes: np.ndarray,
        triangles: np.ndarray,
        handles: Sequence[int],
        weights: np.ndarray,
        groups: np.ndarray,
        **options: float,
    ) -> None:
        shapes, weights = (np.ascontiguousarray(array, np.float64) for array in (shapes, weights))
        triangles, handles, groups = (
            np.ascontiguousarray(array, np.int32) for array in (triangles, handles, groups)
        )
        self.shape_count, self.vertex_count, self.dimension = shapes.shape
        self.row_count = len(handles)
        if len(weights) != self.vertex_count or groups.shape != (len(triangles),):
            raise ValueError("weights must have a row for each vertex, groups one for each face")
        problem = tug_baseline_problem(
            *(_pointer(shapes, c_double), _pointer(triangles, c_int32)),
            *(_pointer(handles, c_int32), _pointer(weights, c_double), _pointer(groups, c_int32)),
            *(*shapes.shape, len(triangles), len(handles), weights.shape[1]),
            int(groups.max(initial=-1)) + 1,
        )
        given = tug_baseline_options()
        library().tug_baseline_default_options(byref(given))
        for name, value in options.items():
            setattr(given, name, value)
        self._baseline = POINTER(tug_baseline)()
        library().tug_baseline_create(
            self.number, byref(problem), byref(given), byref(self._baseline)
        )

    def solve(self, targets: np.ndarray) -> Info:
        """Find the pose for targets, #H by k, from a cold start."""
        targets = np.ascontiguousarray(targets, np.float64)
        if targets.shape != (self.row_count, self.dimension):
            raise ValueError(f"targets must be {self.row_count} by {self.dimension}")
        info = tug_baseline_info()
        library().tug_baseline_solve(self._baseline, targets, byref(info))
        return Info(bool(info.converged), info.rounds, info.objective, info.residual, info.increase)

    def positions(self) -> np.ndarray:
        """#V by k positions of the last solve."""
        positions = np.empty((self.vertex_count, self.dimension))
        library().tug_baseline_get_positions(self._baseline, positions)
        return positions

    def blend(self) -> np.ndarray:
        """#S weights of the shapes in the last solve; they sum to one."""
        blend = np.empty(self.shape_count)
        library().tug_baseline_get_blend(self._baseline, blend)
        return blend

    def close(self) -> None:
        """Free the library's memory; again is allowed."""
        library().tug_baseline_destroy(self._baseline)
        self._baseline = POINTER(tug_baseline)()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Fast(Baseline):
    """Jacobson et al. 2012: as rigid as possible, the rest shape alone."""

    number = 0


class EnergyInterpolation(Baseline):
    """Chao et al. 2010, equation 2 of AMRAP: the shape of least energy alone."""

    number = 1


class NonlinearShapeSpace(Baseline):
    """Schumacher et al. 2012: the distance from a nonlinear blend of the shapes' features."""

    number = 2


class MeshIk(Baseline):
    """Sumner et al. 2005, in the space of all vertices."""

    number = 3


class ReducedDeformable(Baseline):
    """Der et al. 2006: MeshIK on a skinned model of the rest shape."""

    number = 4

    def change_rows(self, rows: Rows, firmness: np.ndarray) -> None:
        """Hold it by these rows from here on, softly: see addon.solver.Model.change_rows."""
        firmness = np.ascontiguousarray(firmness, np.float64)
        if firmness.shape != (len(rows),):
            raise ValueError(f"the firmness must be {len(rows)} numbers, not {firmness.shape}")
        given = native.tug_rows(
            *(_pointer(rows.starts, c_int32), _pointer(rows.vertices, c_int32)),
            *(_pointer(rows.values, c_double), len(rows)),
        )
        library().tug_baseline_change_rows(self._baseline, byref(given), firmness)
        self.row_count = len(rows)


class BlendShapes(Baseline):
    """Linear blend shapes, what they miss of the handles spread by the weights."""

    number = 5


class LinearShapeSpace:
    """Tug with lambda = 0: the distance from the linear blends of the turned shapes.

    Nothing else is in it that knows what a shape costs, so no rotation prior either. It converges
    where the paper's own form with lambda = 0 does not, to nearly the same poses. Options are those
    of addon.solver.Solver.
    """

    def __init__(
        self,
        shapes: np.ndarray,
        triangles: np.ndarray,
        handles: Sequence[int],
        weights: np.ndarray,
        groups: np.ndarray,
        **options: float,
    ) -> None:
        rows = Rows.pin(handles)
        with (
            Mesh(shapes[0], triangles) as mesh,
            Model(mesh, shapes, weights, rows, groups) as model,
        ):
            self._solver = Solver(model, **{"lambda_": 0.0, "prior": 0.0, **options})

    def solve(self, targets: np.ndarray) -> SolveInfo:
        """Find the pose for targets, #H by k, from a cold start."""
        return self._solver.solve(targets)

    def positions(self) -> np.ndarray:
        """#V by k positions of the last solve."""
        return self._solver.positions()

    def blend(self) -> np.ndarray:
        """#S weights of the shapes in the last solve, the mean over the groups."""
        return self._solver.blend().mean(axis=0)

    def close(self) -> None:
        """Free the library's memory; again is allowed."""
        self._solver.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


METHODS: dict[str, type] = {
    "fast": Fast,
    "energy_interpolation": EnergyInterpolation,
    "linear_shape_space": LinearShapeSpace,
    "nonlinear_shape_space": NonlinearShapeSpace,
    "mesh_ik": MeshIk,
    "reduced_deformable": ReducedDeformable,
    "blend_shapes": BlendShapes,
}
