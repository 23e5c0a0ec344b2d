# SPDX-License-Identifier: GPL-3.0-or-later
"""Times of single calls of libtug, without what Python adds: functions without argument checks,
arrays given by address. What is left of ctypes and the clock is below a microsecond a call."""

from __future__ import annotations

import ctypes
import functools
import time
from collections.abc import Callable

import numpy as np
from library import Solver, native


@functools.cache
def bare_library() -> ctypes.CDLL:
    """The library that native.library() has loaded, its functions undeclared."""
    return ctypes.CDLL(native.library()._name)


def seconds_of(call: Callable[[], object], repeats: int) -> np.ndarray:
    """The time of each of `repeats` calls."""
    times = np.empty(repeats)
    for number in range(repeats):
        start = time.perf_counter_ns()
        call()
        times[number] = time.perf_counter_ns() - start
    return 1e-9 * times


def solve_seconds(solver: Solver, frames: np.ndarray, repeats: int = 1) -> np.ndarray:
    """Of tug_solve on each of the frames (#T by #H by k): #T, the least of the repeats."""
    frames = np.ascontiguousarray(frames, np.float64)
    function, info = bare_library().tug_solve, native.tug_solve_info()
    size = frames[0].nbytes
    times = [
        seconds_of(
            functools.partial(
                function,
                solver._pointer,
                ctypes.c_void_p(frames.ctypes.data + number * size),
                ctypes.byref(info),
            ),
            repeats,
        ).min()
        for number in range(len(frames))
    ]
    return np.array(times)


def position_seconds(solver: Solver, repeats: int) -> np.ndarray:
    """Of tug_get_positions: `repeats` times."""
    positions = np.empty((solver.sizes.vertices, solver.sizes.dimension))
    call = functools.partial(
        bare_library().tug_get_positions, solver._pointer, ctypes.c_void_p(positions.ctypes.data)
    )
    return seconds_of(call, repeats)
