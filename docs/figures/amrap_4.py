# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 4: a snake held at its ends, the head drawn away from the tail, by AMRAP (above)
and in a nonlinear shape space (below)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from paths import Jump, Trace, follow, worst_jump
from problems import Problem
from project import snake

NEAR, FAR = 0.6, 6.2  # distances between the ends
SHOWN = (0.8, 1.45, 1.78, 2.2, 2.7, 3.3, 4.2, 5.4)
STEPS = 112
ROWS = {"ours": "AMRAP", "nonlinear": "nonlinear\nshape space"}


@dataclass(frozen=True)
class Row:
    trace: Trace
    jump: Jump
    shown: Trace


@dataclass(frozen=True)
class Pull:
    problem: Problem
    rows: dict[str, Row]


def ends(distance: float) -> np.ndarray:
    """Where tail and head are held."""
    return np.array([[0.0, 0.0], [distance, 0.0]])


def measure(steps: int = STEPS) -> Pull:
    problem = Problem.of(snake.sample(), ("Tail", "Head"))
    distances = np.linspace(NEAR, FAR, steps + 1)
    rows = {}
    for name, method in (
        ("ours", problem.tug()),
        ("nonlinear", problem.peer("nonlinear_shape_space")),
    ):
        trace = follow(method, ends, distances)
        jump = worst_jump(method, ends, trace)
        rows[name] = Row(trace, jump, follow(method, ends, np.array(SHOWN)))
    return Pull(problem, rows)


def numbers(pull: Pull) -> dict[str, dict[str, float]]:
    """For each row: what is left of the worst step after halving, and where; how much weight each
    drawing gets at most."""
    return {
        name: {
            "movement_jump": row.jump.movement,
            "weight_jump": row.jump.weight,
            "jump_at": row.jump.time,
            "largest_step": float(row.trace.movements().max()),
            "weights_at_most": row.trace.blends.max(axis=0).tolist(),
        }
        for name, row in pull.rows.items()
    }


def draw(pull: Pull, path: Path) -> None:
    import drawing

    colors = drawing.screen_colors(pull.problem.sample.colors)
    poses = {name: row.shown.poses for name, row in pull.rows.items()}
    windows = [
        drawing.window_around([shown[column] for shown in poses.values()], 0.02)
        for column in range(len(SHOWN))
    ]
    widths = [window[1] - window[0] for window in windows]
    bottom, top = min(w[2] for w in windows), max(w[3] for w in windows)
    figure, grid = drawing.plt.subplots(
        *(len(poses), len(SHOWN)), figsize=(13.5, 2.3), width_ratios=widths
    )
    figure.subplots_adjust(0.10, 0.02, 0.995, 0.98, 0.06, 0.04)
    for letter, row, (name, shown) in zip("ab", grid, poses.items(), strict=True):
        for axes, pose, distance, window in zip(row, shown, SHOWN, windows, strict=True):
            drawing.draw_flat(axes, pose, pull.problem.sample.faces, colors)
            drawing.draw_handles(axes, ends(distance), 4.5)
            drawing.frame(axes, (*window[:2], bottom, top))
        drawing.row_label(figure, row[0], f"({letter})", ROWS[name])
    drawing.save(figure, path)
