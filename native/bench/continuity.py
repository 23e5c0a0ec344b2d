# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a pose follows its handles without a jump.

A path carries the handles along straight lines from one example to another, while one of them
also swings out by a tenth of the diagonal. A step jumps where a vertex moves more than 12 times as
far as any handle, and still half as far after the step was bisected six times, each time towards
the half in which more happens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from data import ExampleSet
from methods import Method

STEPS = 96
BUMP = 0.1  # of the diagonal
STEEP = 12.0
BISECTIONS = 6


@dataclass(frozen=True)
class HandlePath:
    """Handle positions (#H by k) for a time from 0 to 1."""

    start: np.ndarray
    end: np.ndarray
    bump: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """The handles at a time."""
        line = self.start + time * (self.end - self.start)
        return line + np.sin(np.pi * time) * self.bump

    def frames(self, steps: int = STEPS) -> np.ndarray:
        """steps + 1 by #H by k, evenly in time."""
        return np.stack([self.at(time) for time in np.linspace(0.0, 1.0, steps + 1)])


@dataclass(frozen=True)
class Trace:
    """What was seen along one path."""

    jumps: int
    frames: int
    unconverged: int
    steepest: float  # largest ratio of a vertex's to the handles' movement in a step


def draw_paths(poses: ExampleSet, handles: np.ndarray, count: int) -> Iterator[HandlePath]:
    """The first `count` of the set's paths, the same at every run."""
    for number in range(count):
        random = np.random.default_rng(number)
        start, end = random.choice(len(poses.shapes), 2, replace=False)
        direction = random.standard_normal(poses.shapes.shape[2])
        bump = np.zeros_like(poses.shapes[0, handles])
        bump[random.integers(len(handles))] = direction / np.linalg.norm(direction)
        yield HandlePath(
            poses.shapes[start, handles],
            poses.shapes[end, handles],
            BUMP * poses.diagonal * bump,
        )


def follow(method: Method, path: HandlePath) -> Trace:
    """Pose every frame of a path and count its jumps."""
    times = np.linspace(0.0, 1.0, STEPS + 1)
    jumps, unconverged, steepest = 0, 0, 0.0
    before = None
    for number, time in enumerate(times):
        unconverged += not method.solve(path.at(time)).converged
        after = method.positions()
        if before is not None:
            handles = farthest(path.at(times[number - 1]), path.at(time))
            ratio = farthest(before, after) / handles
            steepest = max(steepest, ratio)
            jumps += ratio > STEEP and is_jump(method, path, times[number - 1], time, before, after)
        before = after
    return Trace(jumps, len(times), unconverged, steepest)


def is_jump(
    method: Method,
    path: HandlePath,
    start: float,
    end: float,
    before: np.ndarray,
    after: np.ndarray,
) -> bool:
    """Whether half of a step's movement is left when it is bisected again and again."""
    whole = farthest(before, after)
    for _ in range(BISECTIONS):
        middle = 0.5 * (start + end)
        method.solve(path.at(middle))
        between = method.positions()
        if farthest(before, between) >= farthest(between, after):
            end, after = middle, between
        else:
            start, before = middle, between
    return farthest(before, after) >= 0.5 * whole


def farthest(one: np.ndarray, other: np.ndarray) -> float:
    """Largest distance between points of the same number."""
    difference = one - other
    return float(np.sqrt(np.einsum("ij,ij->i", difference, difference).max()))
