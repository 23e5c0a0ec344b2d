# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 7: a fox that moves one paw, by blends that vary over the body (above) and by one
blend for the whole body (below)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from problems import Problem, mean_distance
from project import creature

PAW, LIFTED = "Front Paw.L", "Stepping"
BODIES = ("Basis", "Looking Left", "Sitting")
ROWS = {"varying": "varying\nblend", "single": "single\nblend"}
VIEW = (62, 10)


@dataclass(frozen=True)
class Lifts:
    """poses: for each row one for each of BODIES."""

    problem: Problem
    poses: dict[str, list[np.ndarray]]


def targets(problem: Problem, body: str) -> np.ndarray:
    """All handles where `body` has them, but the paw where it is lifted."""
    paw = list(problem.sample.handles).index(PAW)
    wanted = problem.targets(body)
    wanted[paw] = problem.targets(LIFTED)[paw]
    return wanted


def measure() -> Lifts:
    problem = Problem.of(creature.sample())
    poses = {}
    for name, options in (("varying", {}), ("single", {"single_blend": True})):
        with problem.tug(**options) as solver:
            poses[name] = []
            for body in BODIES:
                solver.solve(targets(problem, body))
                poses[name].append(solver.positions())
    return Lifts(problem, poses)


def numbers(lifts: Lifts) -> dict[str, dict[str, float]]:
    """How far the moved leg is from the lifted leg of the example, the mean over its vertices after
    the best rigid motion, in parts of the rest shape's diagonal."""
    problem = lifts.problem
    leg = problem.functions.weights[:, list(problem.sample.handles).index(PAW)] > 0.5
    return {
        row: {
            body: mean_distance(pose[leg], problem.shape(LIFTED)[leg]) / problem.diagonal
            for body, pose in zip(BODIES, poses, strict=True)
        }
        for row, poses in lifts.poses.items()
    }


def draw(lifts: Lifts, path: Path) -> None:
    import drawing

    camera = drawing.Camera(*VIEW)
    seen = {row: [camera.project(pose) for pose in poses] for row, poses in lifts.poses.items()}
    columns = [drawing.window_around(pair, 0.03) for pair in zip(*seen.values(), strict=True)]
    bottom, top = min(w[2] for w in columns), max(w[3] for w in columns)
    widths = [window[1] - window[0] for window in columns]
    figure, grid = drawing.plt.subplots(2, 3, figsize=(11.5, 6.5), width_ratios=widths)
    figure.subplots_adjust(0.085, 0.005, 0.998, 0.998, 0.02, 0.02)
    for letter, (row, poses), axes_row in zip("ab", seen.items(), grid, strict=True):
        for axes, pose, window in zip(axes_row, poses, columns, strict=True):
            drawing.draw_pose(axes, lifts.problem, pose, (*window[:2], bottom, top))
        drawing.row_label(figure, axes_row[0], f"({letter})", ROWS[row])
    drawing.save(figure, path)
