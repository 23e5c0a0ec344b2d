# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 6: a chameleon's snout and a fox's ends on their way from the rest pose, by AMRAP,
by AMRAP without the costs (lambda = 0), and in a nonlinear shape space."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from paths import Jump, Trace, follow, line, worst_jump
from problems import Method, Problem, mean_distance
from project import chameleon, creature

STEPS, HASTE = 70, 10
WIDTH = 13.5  # of the picture, in inches
SHOWN = (0.0, 0.3, 0.5, 0.6, 0.7, 1.0)
DRAWN = ("chameleon", "fox")
ROWS = {"ours": "AMRAP", "linear": "linear\nshape space", "nonlinear": "nonlinear\nshape space"}
LATE, LATER = 0.7, 0.86  # times at which the fox should be curling up


@dataclass(frozen=True)
class Case:
    """jumps: of the methods that remember nothing."""

    problem: Problem
    goal: str
    traces: dict[str, Trace]
    jumps: dict[str, Jump]


def methods(problem: Problem) -> dict[str, Method]:
    """As in Figure 2, the linear shape space begins each frame where the last one ended."""
    return {
        "ours": problem.tug(),
        "linear": problem.peer("linear_shape_space", warm_start=True),
        "nonlinear": problem.peer("nonlinear_shape_space"),
    }


def drag(problem: Problem, goal: str, steps: int) -> Case:
    """All handles straight from the rest pose to where `goal` has them."""
    way = line(np.stack([problem.targets("Basis"), problem.targets(goal)]))
    traces, jumps = {}, {}
    for name, method in methods(problem).items():
        traces[name] = follow(method, way, np.linspace(0, 1, steps + 1))
        if name != "linear":
            jumps[name] = worst_jump(method, way, traces[name])
    return Case(problem, goal, traces, jumps)


def measure(steps: int = STEPS) -> dict[str, Case]:
    reptile = Problem.of(chameleon.sample(), ("Tail", "Hind Foot", "Snout"))
    fox = Problem.of(creature.sample(), ("Head", "Tail", "Front Paw.L", "Hind Paw.R"))
    pinned = Problem.of(chameleon.sample())
    return {
        "chameleon": drag(reptile, chameleon.SNAPPING, steps),
        "chameleon_all_handles": drag(pinned, chameleon.SNAPPING, steps),
        "fox": drag(fox, "Curled", steps),
        "fox_in_haste": drag(fox, "Curled", HASTE),
    }


def numbers(cases: dict[str, Case]) -> dict[str, dict[str, dict[str, float]]]:
    """For each character and method, lengths in parts of the rest pose's diagonal: what is left of
    the worst step after halving. Of the chameleon also how far the mouth opens at most, in parts of
    what the open drawing shows; of the fox, shortly before the end, the mean distance of the
    vertices from the curled pose, and that pose's weight then and a little later."""
    table = {}
    for character, case in cases.items():
        table[character] = {
            name: (gape if case.goal == chameleon.SNAPPING else curl)(case, trace)
            for name, trace in case.traces.items()
        }
        for name, jump in case.jumps.items():
            table[character][name]["movement_jump"] = jump.movement / case.problem.diagonal
            table[character][name]["jump_at"] = jump.time
    return table


def gape(case: Case, trace: Trace) -> dict[str, float]:
    """How far the jaws are apart at most."""
    upper, lower = chameleon.JAWS
    wide = np.linalg.norm(np.subtract(*case.problem.shape(chameleon.GAPING)[[upper, lower]]))
    apart = np.linalg.norm(trace.poses[:, upper] - trace.poses[:, lower], axis=1)
    return {"mouth": float(apart.max() / wide)}


def curl(case: Case, trace: Trace) -> dict[str, float]:
    """How near the pose is to the curled one."""
    late, later = (round(time * (len(trace.times) - 1)) for time in (LATE, LATER))
    goal = case.problem.number(case.goal)
    distance = mean_distance(trace.poses[late], case.problem.shapes[goal])
    return {
        "distance": distance / case.problem.diagonal,
        "weight": float(trace.blends[late, goal]),
        "later_weight": float(trace.blends[later, goal]),
    }


def draw(cases: dict[str, Case], path: Path) -> None:
    import drawing

    drawn = [cases[name] for name in DRAWN]
    shown = [shown_poses(case) for case in drawn]
    windows = [drawing.window_around(np.concatenate(list(rows.values())), 0.02) for rows in shown]
    heights = [(w[3] - w[2]) / (w[1] - w[0]) for w in windows]  # of a pose, in widths
    width = 0.9 * WIDTH / len(SHOWN)
    figure = drawing.plt.figure(figsize=(WIDTH, 1.03 * width * len(ROWS) * sum(heights)))
    parts = figure.add_gridspec(len(shown), 1, height_ratios=heights)
    parts.update(left=0.10, right=0.998, top=0.998, bottom=0.004, hspace=0.03)
    for part, case, rows, window in zip(parts, drawn, shown, windows, strict=True):
        grid = part.subgridspec(len(ROWS), len(SHOWN), wspace=0.03, hspace=0.03).subplots()
        for letter, (name, poses), row in zip("abc", rows.items(), grid, strict=True):
            for axes, pose in zip(row, poses, strict=True):
                drawing.draw_pose(axes, case.problem, pose, window)
            drawing.row_label(figure, row[0], f"({letter})", ROWS[name])
    drawing.save(figure, path)


def shown_poses(case: Case) -> dict[str, list[np.ndarray]]:
    """For each method the poses at the times of SHOWN, as they are seen."""
    import drawing

    camera = drawing.Camera(*case.problem.sample.view)
    solid = case.problem.shapes.shape[2] == 3
    steps = [round(time * STEPS) for time in SHOWN]
    return {
        name: [camera.project(pose) if solid else pose for pose in trace.poses[steps]]
        for name, trace in case.traces.items()
    }
