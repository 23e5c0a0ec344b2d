# SPDX-License-Identifier: GPL-3.0-or-later
"""What a method's poses are worth: error on poses it was not given, recognition of those it was,
independence of the drag, and what a cold start costs.

Errors are distances of vertices in parts of the diagonal of the set's first pose. FBT's measure is
the largest distance over the square root of the true pose's area.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from continuity import draw_paths, farthest
from data import ExampleSet
from methods import Method, Tally, Tug, make
from rigs import Rig

DISTINCT = 0.01  # of the diagonal: handles of examples that can be told apart
DRAGS, DRAG_STEPS = 20, 5


@dataclass(frozen=True)
class HeldOut:
    """One pose posed from the others."""

    method: str
    pose: int
    mean: float
    largest: float
    fbt: float
    converged: bool
    rounds: int


@dataclass(frozen=True)
class Recognised:
    """One example posed from its own handles."""

    pose: int
    error: float  # largest, beyond `projection`
    projection: float  # largest error of the example in the dictionary's span
    blend: float | None  # mean over the groups of the example's own weight


@dataclass(frozen=True)
class ColdStart:
    """Frames of a path, each from nothing."""

    rounds_median: float
    rounds_largest: int
    milliseconds_median: float
    unconverged: int


def tally_of(method: Method) -> Tally:
    """The tally of a method of Tug, an empty one of any other."""
    return method.tally if isinstance(method, Tug) else Tally()


def surface_area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Of a mesh in the plane or in space."""
    first, second, third = (vertices[triangles[:, corner]] for corner in range(3))
    u, v = second - first, third - first
    squared = (u * u).sum(1) * (v * v).sum(1) - (u * v).sum(1) ** 2
    return float(0.5 * np.sqrt(np.maximum(squared, 0.0)).sum())


def leave_one_out(
    poses: ExampleSet,
    handles: np.ndarray,
    methods: Sequence[str],
    tally: Tally,
) -> list[HeldOut]:
    """Each pose, by each method, from its handles and all other poses; the first of those is the
    rest shape."""
    rigs: dict[int, Rig] = {}  # by their rest shape
    results = []
    for pose in range(len(poses.shapes)):
        others = np.delete(poses.shapes, pose, axis=0)
        rest = int(pose == 0)
        before = rigs.get(rest)
        rig = before.with_shapes(others) if before else Rig(others, poses.triangles, handles)
        rigs[rest] = rig
        for name in methods:
            method = make(name, rig)
            results.append(pose_held_out(poses, handles, name, method, pose))
            tally.add(tally_of(method))
            method.close()
    return results


def pose_held_out(
    poses: ExampleSet, handles: np.ndarray, name: str, method: Method, pose: int
) -> HeldOut:
    """One pose by a method that does not know it."""
    truth = poses.shapes[pose]
    outcome = method.solve(truth[handles])
    distance = np.linalg.norm(method.positions() - truth, axis=1)
    return HeldOut(
        name,
        pose,
        float(distance.mean() / poses.diagonal),
        float(distance.max() / poses.diagonal),
        float(distance.max() / np.sqrt(surface_area(truth, poses.triangles))),
        bool(outcome.converged),
        outcome.rounds,
    )


def distinct_poses(poses: ExampleSet, handles: np.ndarray) -> list[int]:
    """Examples whose handles are nowhere near those of another one, however that is moved."""
    seen = poses.shapes[:, handles]

    def differ(one: int, other: int) -> bool:
        return rigid_distance(seen[one], seen[other]) > DISTINCT * poses.diagonal

    numbers = range(len(seen))
    return [one for one in numbers if all(differ(one, other) for other in numbers if other != one)]


def rigid_distance(points: np.ndarray, others: np.ndarray) -> float:
    """Largest distance of points (#H by k) from others, moved rigidly onto them in the least
    squares sense."""
    points, others = points - points.mean(axis=0), others - others.mean(axis=0)
    left, _, right = np.linalg.svd(others.T @ points)
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return farthest(points, others @ (left @ right))


def recognise(poses: ExampleSet, handles: np.ndarray, method: Method) -> list[Recognised]:
    """Every example that can be told from the others, from its handles alone."""
    results = []
    # The dictionary has all W_h times all coordinates, so an example is in its span as far as one
    # is in that of the weights.
    off_one = 0.0
    if isinstance(method, Tug):
        weights = method.functions.weights
        one = np.ones(len(weights))
        off_one = np.abs(weights @ np.linalg.lstsq(weights, one, rcond=None)[0] - one)
    for pose in distinct_poses(poses, handles):
        truth = poses.shapes[pose]
        method.solve(truth[handles])
        projection = float((off_one * np.linalg.norm(truth, axis=1)).max() / poses.diagonal)
        error = farthest(method.positions(), truth) / poses.diagonal
        blend = float(method.solver.blend()[:, pose].mean()) if isinstance(method, Tug) else None
        results.append(Recognised(pose, max(error - projection, 0.0), projection, blend))
    return results


def drag_dependence(
    poses: ExampleSet, handles: np.ndarray, fresh: functools.partial[Method], tally: Tally
) -> float:
    """Largest distance, in parts of the diagonal, between the pose of some handles on a new solver
    and their pose at the end of 20 random drags."""
    goal = next(draw_paths(poses, handles, 1)).at(0.5)
    random = np.random.default_rng(0)
    method = fresh()
    method.solve(goal)
    cold, worst = method.positions(), 0.0
    for _ in range(DRAGS):
        for _ in range(DRAG_STEPS):
            blend = random.dirichlet(np.ones(len(poses.shapes)))
            noise = 0.05 * poses.diagonal * random.standard_normal(goal.shape)
            method.solve(np.tensordot(blend, poses.shapes[:, handles], 1) + noise)
        method.solve(goal)
        worst = max(worst, farthest(method.positions(), cold))
    tally.add(tally_of(method))
    method.close()
    return worst / poses.diagonal


def start_cold(poses: ExampleSet, handles: np.ndarray, method: Method, frames: int) -> ColdStart:
    """Rounds and time of the frames of the set's first path."""
    rounds, seconds, unconverged = [], [], 0
    for targets in next(draw_paths(poses, handles, 1)).frames(frames - 1):
        start = time.perf_counter()
        outcome = method.solve(targets)
        seconds.append(time.perf_counter() - start)
        rounds.append(outcome.rounds)
        unconverged += not outcome.converged
    return ColdStart(
        float(np.median(rounds)), max(rounds), 1e3 * float(np.median(seconds)), unconverged
    )
