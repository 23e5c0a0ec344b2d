# SPDX-License-Identifier: GPL-3.0-or-later
"""libtug through ctypes: where the library is found, what tug.h declares, errors as exceptions.

The declarations follow tug.h in its order, each below its C prototype. Nothing is loaded before
`library()` is called, so that the add-on registers without the library.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import POINTER, c_char_p, c_double, c_int, c_int32, c_size_t, c_void_p
from pathlib import Path

import numpy as np

ABI = 2

ERROR_ARGUMENT = 1
ERROR_MEMORY = 2
ERROR_CANCELLED = 3
ERROR_MESH = 4
ERROR_HANDLES = 5
ERROR_NUMERIC = 6
ERROR_BLOB = 7

Progress = Callable[[str, float], object]


def part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """The stretch of a progress that belongs to one of several long calls."""
    if progress is None:
        return None
    return lambda stage, fraction: progress(stage, start + (end - start) * fraction)


class TugError(Exception):
    """A call of libtug failed. code: one of the ERROR_ constants; reason: the text without the name
    of the function that it starts with."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.reason = text.partition(": ")[2] or text


class LibraryError(Exception):
    """libtug cannot be found, or is not the one this package was made for."""


# Structs, with the fields of tug.h -----------------------------------------------------------


class Sized(ctypes.Structure):
    """A struct that starts with its own size, which the library reads before anything else."""

    def __init__(self) -> None:
        super().__init__()
        self.struct_size = ctypes.sizeof(self)


class tug_mesh(ctypes.Structure):
    """Opaque."""


class tug_model(ctypes.Structure):
    """Opaque."""


class tug_solver(ctypes.Structure):
    """Opaque."""


class tug_points(ctypes.Structure):
    """Opaque."""


class tug_weights_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("tolerance", c_double),
        ("max_iterations", c_int32),
        ("threads", c_int32),
        ("follow_nearest", c_int32),
    ]


class tug_weights_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("converged", c_int32),
        ("iterations", c_int32),
        ("gap", c_double),
        ("kkt_residual", c_double),
        ("bound_violation", c_double),
    ]


class tug_eigenfunctions_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("constants", c_int32),
        ("solves", c_int32),
        ("residual", c_double),
    ]


class tug_skeleton_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("smoothness", c_double),
        ("tolerance", c_double),
        ("max_rounds", c_int32),
    ]


class tug_skeleton_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("converged", c_int32),
        ("rounds", c_int32),
        ("error", c_double),
        ("objective", c_double),
    ]


class tug_dictionary(ctypes.Structure):
    _fields_ = [
        ("shapes", POINTER(c_double)),
        ("weights", POINTER(c_double)),
        ("vertex_count", c_int32),
        ("dimension", c_int32),
        ("shape_count", c_int32),
        ("weight_count", c_int32),
    ]


class tug_rows(ctypes.Structure):
    _fields_ = [
        ("starts", POINTER(c_int32)),
        ("vertices", POINTER(c_int32)),
        ("values", POINTER(c_double)),
        ("count", c_int32),
    ]


class tug_model_sizes(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("vertices", c_int32),
        ("dimension", c_int32),
        ("shapes", c_int32),
        ("weights", c_int32),
        ("rows", c_int32),
        ("groups", c_int32),
        ("unknowns", c_int32),
        ("rank", c_int32),
    ]


class tug_solver_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("form", c_int32),
        ("squared", c_int32),
        ("single_blend", c_int32),
        ("warm_start", c_int32),
        ("scale", c_int32),
        ("max_rounds", c_int32),
        ("lambda", c_double),
        ("prior", c_double),
        ("tolerance", c_double),
    ]


class tug_solve_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("converged", c_int32),
        ("rounds", c_int32),
        ("objective", c_double),
        ("energy", c_double),
        ("gap", c_double),
        ("residual", c_double),
        ("increase", c_double),
    ]


class tug_blend_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("pivots", c_int32),
        ("objective", c_double),
        ("gap", c_double),
    ]


class tug_elastic_net_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t),
        ("converged", c_int32),
        ("rounds", c_int32),
        ("gap", c_double),
    ]


# Functions -----------------------------------------------------------------------------------

Status = type("Status", (c_int,), {})  # tells errcheck which results are a tug_status
tug_progress = ctypes.CFUNCTYPE(c_int, c_void_p, c_char_p, c_double)

# A wrong dtype or a strided array raises instead of being copied.
Vector = np.ctypeslib.ndpointer(np.float64, ndim=1, flags="C_CONTIGUOUS")
Matrix = np.ctypeslib.ndpointer(np.float64, ndim=2, flags="C_CONTIGUOUS")
Stack = np.ctypeslib.ndpointer(np.float64, ndim=3, flags="C_CONTIGUOUS")
Rotations = np.ctypeslib.ndpointer(np.float64, ndim=4, flags="C_CONTIGUOUS")
Indices = np.ctypeslib.ndpointer(np.int32, ndim=1, flags="C_CONTIGUOUS")
Triangles = np.ctypeslib.ndpointer(np.int32, ndim=2, flags="C_CONTIGUOUS")
Int = POINTER(c_int32)

FUNCTIONS: dict[str, tuple] = {
    # int32_t tug_abi(void);
    "tug_abi": (c_int32,),
    # const char *tug_version(void);
    "tug_version": (c_char_p,),
    # const char *tug_error_text(void);
    "tug_error_text": (c_char_p,),
    # tug_status tug_create_mesh(const double *vertices, int32_t vertex_count, int32_t dimension,
    #                            const int32_t *triangles, int32_t triangle_count,
    #                            tug_mesh **out);
    "tug_create_mesh": (
        *(Status, Matrix, c_int32, c_int32, Triangles, c_int32),
        POINTER(POINTER(tug_mesh)),
    ),
    # void tug_destroy_mesh(tug_mesh *mesh);
    "tug_destroy_mesh": (None, POINTER(tug_mesh)),
    # tug_status tug_check_mesh(const tug_mesh *mesh, char *text, size_t capacity,
    #                           int32_t *errors, int32_t *warnings);
    "tug_check_mesh": (Status, POINTER(tug_mesh), c_char_p, c_size_t, Int, Int),
    # tug_status tug_find_components(const tug_mesh *mesh, int32_t *component, int32_t *count);
    "tug_find_components": (Status, POINTER(tug_mesh), Indices, Int),
    # tug_status tug_spread_vertices(const tug_mesh *mesh, int32_t first, int32_t count,
    #                                int32_t *vertices);
    "tug_spread_vertices": (Status, POINTER(tug_mesh), c_int32, c_int32, Indices),
    # tug_status tug_find_distances(const tug_mesh *mesh, const int32_t *sources, int32_t count,
    #                               double *distances, int32_t *nearest);
    "tug_find_distances": (
        *(Status, POINTER(tug_mesh), Indices, c_int32, Vector, POINTER(c_int32)),
    ),
    # tug_status tug_find_areas(const tug_mesh *mesh, double *areas);
    "tug_find_areas": (Status, POINTER(tug_mesh), Vector),
    # tug_status tug_get_cotangents(const tug_mesh *mesh, double *half_cotangents);
    "tug_get_cotangents": (Status, POINTER(tug_mesh), Matrix),
    # tug_status tug_find_normals(const tug_mesh *mesh, const double *positions, double *normals);
    "tug_find_normals": (Status, POINTER(tug_mesh), Matrix, Matrix),
    # void tug_default_weights_options(tug_weights_options *options);
    "tug_default_weights_options": (None, POINTER(tug_weights_options)),
    # tug_status tug_compute_weights(const tug_mesh *mesh, const int32_t *handle_starts,
    #                                const int32_t *handle_vertices, int32_t handle_count,
    #                                const tug_weights_options *options, tug_progress progress,
    #                                void *user, double *weights, tug_weights_info *info);
    "tug_compute_weights": (
        *(Status, POINTER(tug_mesh), Indices, Indices, c_int32, POINTER(tug_weights_options)),
        *(tug_progress, c_void_p, Matrix, POINTER(tug_weights_info)),
    ),
    # tug_status tug_compute_eigenfunctions(const tug_mesh *mesh, int32_t count,
    #                                       tug_progress progress, void *user, double *values,
    #                                       double *functions, tug_eigenfunctions_info *info);
    "tug_compute_eigenfunctions": (
        *(Status, POINTER(tug_mesh), c_int32, tug_progress, c_void_p),
        *(Vector, Matrix, POINTER(tug_eigenfunctions_info)),
    ),
    # void tug_default_skeleton_options(tug_skeleton_options *options);
    "tug_default_skeleton_options": (None, POINTER(tug_skeleton_options)),
    # tug_status tug_find_skeleton(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
    #                              int32_t wanted, const tug_skeleton_options *options,
    #                              tug_progress progress, void *user, double *weights,
    #                              int32_t *bone_count, tug_skeleton_info *info);
    "tug_find_skeleton": (
        *(Status, POINTER(tug_mesh), Stack, c_int32, c_int32, POINTER(tug_skeleton_options)),
        *(tug_progress, c_void_p, Matrix, Int, POINTER(tug_skeleton_info)),
    ),
    # tug_status tug_cluster_triangles(const tug_mesh *mesh, const double *weights,
    #                                  int32_t weight_count, int32_t wanted,
    #                                  tug_progress progress, void *user, int32_t *groups,
    #                                  int32_t *group_count);
    "tug_cluster_triangles": (
        *(Status, POINTER(tug_mesh), Matrix, c_int32, c_int32),
        *(tug_progress, c_void_p, Indices, Int),
    ),
    # tug_status tug_reduce_dictionary(const tug_dictionary *dictionary, int32_t wanted,
    #                                  tug_progress progress, void *user, int32_t *atoms);
    "tug_reduce_dictionary": (
        *(Status, POINTER(tug_dictionary), c_int32, tug_progress, c_void_p, Indices),
    ),
    # tug_status tug_fit_dictionary(const tug_dictionary *dictionary, const int32_t *atoms,
    #                               int32_t atom_count, const double *positions,
    #                               tug_progress progress, void *user, double *transforms,
    #                               double *fitted);
    "tug_fit_dictionary": (
        *(Status, POINTER(tug_dictionary), Int, c_int32, Matrix),
        *(tug_progress, c_void_p, Matrix, Matrix),
    ),
    # tug_status tug_create_model(const tug_mesh *mesh, const double *shapes, int32_t shape_count,
    #                             const double *weights, int32_t weight_count,
    #                             const tug_rows *rows, const int32_t *groups,
    #                             int32_t group_count, const double *stiffness,
    #                             double smoothness, tug_progress progress, void *user,
    #                             tug_model **out);
    "tug_create_model": (
        *(Status, POINTER(tug_mesh), Stack, c_int32, Matrix, c_int32, POINTER(tug_rows)),
        *(Indices, c_int32, POINTER(c_double), c_double),
        *(tug_progress, c_void_p, POINTER(POINTER(tug_model))),
    ),
    # tug_status tug_change_rows(const tug_model *model, const tug_rows *rows,
    #                            const double *firmness, tug_model **out);
    "tug_change_rows": (
        *(Status, POINTER(tug_model), POINTER(tug_rows), POINTER(c_double)),
        POINTER(POINTER(tug_model)),
    ),
    # void tug_destroy_model(tug_model *model);
    "tug_destroy_model": (None, POINTER(tug_model)),
    # tug_status tug_get_model_sizes(const tug_model *model, tug_model_sizes *sizes);
    "tug_get_model_sizes": (Status, POINTER(tug_model), POINTER(tug_model_sizes)),
    # size_t tug_model_blob_size(const tug_model *model);
    "tug_model_blob_size": (c_size_t, POINTER(tug_model)),
    # tug_status tug_save_model(const tug_model *model, void *blob, size_t size);
    "tug_save_model": (Status, POINTER(tug_model), c_void_p, c_size_t),
    # tug_status tug_load_model(const void *blob, size_t size, tug_model **out);
    "tug_load_model": (Status, c_void_p, c_size_t, POINTER(POINTER(tug_model))),
    # void tug_default_solver_options(tug_solver_options *options);
    "tug_default_solver_options": (None, POINTER(tug_solver_options)),
    # tug_status tug_create_solver(const tug_model *model, const tug_solver_options *options,
    #                              tug_solver **out);
    "tug_create_solver": (
        *(Status, POINTER(tug_model), POINTER(tug_solver_options)),
        POINTER(POINTER(tug_solver)),
    ),
    # void tug_destroy_solver(tug_solver *solver);
    "tug_destroy_solver": (None, POINTER(tug_solver)),
    # tug_status tug_set_firmness(tug_solver *solver, const double *firmness);
    "tug_set_firmness": (Status, POINTER(tug_solver), Vector),
    # tug_status tug_set_orientations(tug_solver *solver, const double *orientations,
    #                                 const double *firmness);
    "tug_set_orientations": (Status, POINTER(tug_solver), Stack, Vector),
    # tug_status tug_solve(tug_solver *solver, const double *targets, tug_solve_info *info);
    "tug_solve": (Status, POINTER(tug_solver), Matrix, POINTER(tug_solve_info)),
    # tug_status tug_solve_from(tug_solver *solver, const double *targets,
    #                           const double *rotations, tug_solve_info *info);
    "tug_solve_from": (
        *(Status, POINTER(tug_solver), Matrix, Rotations),
        POINTER(tug_solve_info),
    ),
    # tug_status tug_find_rotations(const tug_mesh *mesh, const double *shapes,
    #                               int32_t shape_count, const int32_t *groups,
    #                               int32_t group_count, const double *positions,
    #                               double *rotations);
    "tug_find_rotations": (
        *(Status, POINTER(tug_mesh), Stack, c_int32, Indices, c_int32, Matrix, Rotations),
    ),
    # tug_status tug_pose(tug_solver *solver, const double *targets, const double *blend,
    #                     const double *rotations);
    "tug_pose": (Status, POINTER(tug_solver), Matrix, Matrix, Rotations),
    # tug_status tug_get_positions(const tug_solver *solver, double *positions);
    "tug_get_positions": (Status, POINTER(tug_solver), Matrix),
    # tug_status tug_get_blend(const tug_solver *solver, double *blend);
    "tug_get_blend": (Status, POINTER(tug_solver), Matrix),
    # tug_status tug_get_costs(const tug_solver *solver, double *costs);
    "tug_get_costs": (Status, POINTER(tug_solver), Matrix),
    # tug_status tug_get_rotations(const tug_solver *solver, double *rotations);
    "tug_get_rotations": (Status, POINTER(tug_solver), Rotations),
    # tug_status tug_get_scale(const tug_solver *solver, double *scale);
    "tug_get_scale": (Status, POINTER(tug_solver), POINTER(c_double)),
    # tug_status tug_minimise_blend(int32_t group_count, int32_t shape_count, const double *Q,
    #                               const double *c, double r, const double *d, double lambda,
    #                               int32_t squared, double *blend, tug_blend_info *info);
    "tug_minimise_blend": (
        *(Status, c_int32, c_int32, Matrix, Vector, c_double, Vector, c_double, c_int32),
        *(Vector, POINTER(tug_blend_info)),
    ),
    # tug_status tug_solve_elastic_net(int32_t rows, int32_t unknowns, int32_t columns,
    #                                  const double *X, const double *Y, const double *Lambda,
    #                                  double fit, double smoothness, double sparsity, double *T,
    #                                  tug_elastic_net_info *info);
    "tug_solve_elastic_net": (
        *(Status, c_int32, c_int32, c_int32, Matrix, Matrix, Matrix),
        *(c_double, c_double, c_double, Matrix, POINTER(tug_elastic_net_info)),
    ),
    # tug_status tug_create_points(const double *points, int32_t count, int32_t dimension,
    #                              tug_points **out);
    "tug_create_points": (Status, Matrix, c_int32, c_int32, POINTER(POINTER(tug_points))),
    # void tug_destroy_points(tug_points *points);
    "tug_destroy_points": (None, POINTER(tug_points)),
    # tug_status tug_find_nearest(const tug_points *points, const double *queries, int32_t count,
    #                             double limit, int32_t *nearest, double *distances);
    "tug_find_nearest": (
        *(Status, POINTER(tug_points), Matrix, c_int32, c_double),
        *(Indices, Vector),
    ),
}


def _file_name() -> str:
    return {"win32": "tug.dll", "darwin": "libtug.dylib"}.get(sys.platform, "libtug.so")


def candidates() -> list[Path]:
    """Every place where the library may lie, in the order of the search: what TUG_LIBRARY says,
    the wheel, beside this package, the build tree of a checkout."""
    if override := os.environ.get("TUG_LIBRARY"):
        return [Path(override)]
    name = _file_name()
    wheel = importlib.util.find_spec("tug_native")
    package = Path(__file__).resolve().parent
    build = package.parent / "build"
    return [
        (Path(wheel.origin).parent if wheel else Path("tug_native")) / name,
        package / "lib" / name,
        build / "release" / name,
        build / "debug" / name,
    ]


def _declare(loaded: ctypes.CDLL) -> None:
    def check(status: Status, function: object, arguments: tuple) -> None:
        if status.value:
            raise TugError(status.value, loaded.tug_error_text().decode())

    for name, (result, *arguments) in FUNCTIONS.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
        if result is Status:
            function.errcheck = check


@functools.cache
def library() -> ctypes.CDLL:
    """The library, loaded and declared at the first call.

    Raises LibraryError with every path tried where none has it, or where its ABI is another one.
    """
    places = candidates()
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        tried = "".join(f"\n  {place}" for place in places)
        raise LibraryError(f"the library of Tug was not found; tried:{tried}")
    try:
        loaded = ctypes.CDLL(str(path.resolve()))
        loaded.tug_abi.restype = c_int32
        abi = loaded.tug_abi()
        if abi == ABI:
            _declare(loaded)
            return loaded
    except (OSError, AttributeError) as error:
        raise LibraryError(f"the library of Tug at {path} cannot be loaded: {error}") from error
    raise LibraryError(
        f"the library of Tug at {path} has ABI {abi}, this package needs {ABI}: "
        "install the two from the same version, then restart"
    )


@contextmanager
def reporting(progress: Progress | None) -> Iterator[object]:
    """The tug_progress for one long call. What `progress` raises cancels the call and comes out
    of this context in place of the library's own error."""
    if progress is None:
        yield tug_progress()
        return
    raised: list[BaseException] = []

    def call(user: int | None, stage: bytes, fraction: float) -> int:
        try:
            progress(stage.decode(), fraction)
        except BaseException as error:  # ctypes would swallow it
            raised.append(error)
        return bool(raised)

    try:
        yield tug_progress(call)
    except TugError:
        if raised:
            raise raised[0] from None
        raise
