# SPDX-License-Identifier: GPL-3.0-or-later
"""Following a pose while its handles go along a path, and telling jumps from steep places.

A step of a path is halved again and again, each time to the half in which the pose moves further.
Where the pose is continuous the movement that is left goes to zero; at a jump it does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from problems import Method, mean_blend
from project import farthest

HALVINGS = 14
STEPS_LOOKED_AT = 3

Way = Callable[[float], np.ndarray]  # time -> handle positions, #H by k


@dataclass(frozen=True)
class Jump:
    """What is left of a step after halving: where it is, the vertex that moves furthest, the
    largest change of a weight. At its two ends: poses, and objectives of the solves."""

    time: float
    movement: float
    weight: float
    poses: tuple[np.ndarray, np.ndarray]
    objectives: tuple[float, float]


@dataclass(frozen=True)
class Trace:
    """times (#T), mean blends (#T by #S), poses (#T by #V by k), objectives (#T), and how many of
    the solves did not converge."""

    times: np.ndarray
    blends: np.ndarray
    poses: np.ndarray
    objectives: np.ndarray
    unconverged: int

    def movements(self) -> np.ndarray:
        """#T - 1: how far the vertex that moves furthest goes in each step."""
        return np.array([farthest(*pair) for pair in zip(self.poses, self.poses[1:], strict=False)])

    def largest_weight_step(self) -> float:
        """Largest change of a weight from one time to the next."""
        return float(np.abs(np.diff(self.blends, axis=0)).max())


def line(stops: np.ndarray) -> Way:
    """Straight from one set of handle positions (#P by #H by k) to the next, one per unit."""

    def at(time: float) -> np.ndarray:
        first = min(int(time), len(stops) - 2)
        return stops[first] + (time - first) * (stops[first + 1] - stops[first])

    return at


def follow(method: Method, way: Way, times: np.ndarray) -> Trace:
    """Poses the method at the times, in this order."""
    blends, poses, infos = [], [], []
    for time in times:
        infos.append(method.solve(way(time)))
        blends.append(mean_blend(method))
        poses.append(method.positions())
    objectives = np.array([info.objective for info in infos])
    unconverged = sum(not info.converged for info in infos)
    return Trace(times, np.array(blends), np.array(poses), objectives, unconverged)


def worst_jump(method: Method, way: Way, trace: Trace) -> Jump:
    """Of the steps in which a vertex moves furthest, the one of which most is left. Only for a
    method without memory."""
    steps = np.argsort(trace.movements())[-STEPS_LOOKED_AT:]
    jumps = [halve(method, way, trace.times[i], trace.times[i + 1]) for i in steps]
    return max(jumps, key=lambda jump: jump.movement)


def halve(method: Method, way: Way, start: float, end: float) -> Jump:
    """What is left of one step."""
    (before, after) = (_look(method, way, time) for time in (start, end))
    for _ in range(HALVINGS):
        middle = 0.5 * (start + end)
        between = _look(method, way, middle)
        if farthest(before[0], between[0]) >= farthest(between[0], after[0]):
            end, after = middle, between
        else:
            start, before = middle, between
    return Jump(
        time=float(start),
        movement=farthest(before[0], after[0]),
        weight=float(np.abs(before[1] - after[1]).max()),
        poses=(before[0], after[0]),
        objectives=(before[2], after[2]),
    )


def _look(method: Method, way: Way, time: float) -> tuple[np.ndarray, np.ndarray, float]:
    info = method.solve(way(time))
    return method.positions(), mean_blend(method), info.objective
