# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 2: five methods on the squares while the right handle is dragged out and back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from paths import Jump, Trace, follow, line, worst_jump
from problems import Method, Problem
from project import Form, squares

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STEPS, POSES = 240, 9
ROWS = {
    "a": "without\nrotations",
    "b": "with\nrotations",
    "c": "energy\ninterpolation",
    "d": "linear\nshape space",
    "e": "nonlinear\nshape space",
}


@dataclass(frozen=True)
class Row:
    """trace: the whole drag; jump: None for a method that remembers the pose before."""

    trace: Trace
    jump: Jump | None


@dataclass(frozen=True)
class Drag:
    problem: Problem
    stops: np.ndarray  # 3: the dragged handle's x in the examples
    places: np.ndarray  # #T: its x at the times
    rows: dict[str, Row]


def methods(problem: Problem) -> dict[str, Method]:
    """Row d begins each frame where the last one ended, as the paper's system does: with lambda = 0
    there is nothing else that tells one exact mixture from another. Row d_cold is not drawn."""
    linear = {"name": "linear_shape_space", "single_blend": True}
    return {
        "a": problem.tug(form=Form.NO_ROTATIONS, single_blend=True),
        "b": problem.tug(single_blend=True),
        "c": problem.peer("energy_interpolation"),
        "d": problem.peer(**linear, warm_start=True),
        "d_cold": problem.peer(**linear),
        "e": problem.peer("nonlinear_shape_space"),
    }


def measure(steps: int = STEPS) -> Drag:
    problem = Problem.of(squares.sample())
    examples = problem.shapes[:, problem.handles]
    way = line(examples[[0, 1, 2, 1, 0]])
    times = np.linspace(0, 4, steps + 1)
    rows = {}
    for name, method in methods(problem).items():
        trace = follow(method, way, times)
        rows[name] = Row(trace, None if name == "d" else worst_jump(method, way, trace))
    places = np.array([way(time)[-1, 0] for time in times])
    return Drag(problem, examples[:, -1, 0], places, rows)


def numbers(drag: Drag) -> dict[str, dict[str, float]]:
    """For each row: largest change of a weight in a step, and what is left of the worst step after
    halving; distance of the weights from piecewise linear; greatest weight of the puffed square;
    greatest objective."""
    hats = np.stack([np.interp(drag.places, drag.stops, hat) for hat in np.eye(3)], axis=1)
    table = {}
    for name, row in drag.rows.items():
        blends = row.trace.blends
        table[name] = {
            "largest_weight_step": row.trace.largest_weight_step(),
            "from_piecewise_linear": float(np.abs(blends - hats).max()),
            "puffed_at_most": float(blends[:, 1].max()),
            "puffed_mean": float(blends[:, 1].mean()),
            "objective_at_most": float(row.trace.objectives.max()),
        }
        if row.jump is not None:
            table[name]["weight_jump"] = row.jump.weight
            table[name]["jump_at"] = float(np.interp(row.jump.time, row.trace.times, drag.places))
            table[name]["objective_jump"] = float(np.ptp(row.jump.objectives))
    return table


def draw(drag: Drag, path: Path) -> None:
    import drawing
    from amrap_1 import WINDOW

    figure = drawing.plt.figure(figsize=(13.5, 6.6))
    rows = figure.add_gridspec(len(ROWS), 2, width_ratios=[2.2, 1.25 * POSES])
    rows.update(left=0.115, right=0.995, top=0.985, bottom=0.065, wspace=0.035, hspace=0.22)
    steps = np.linspace(0, len(drag.places) - 1, POSES).round().astype(int)
    for number, (name, title) in enumerate(ROWS.items()):
        row = drag.rows[name]
        graph = figure.add_subplot(rows[number, 0])
        draw_graph(graph, row.trace, last=number == len(ROWS) - 1)
        drawing.row_label(figure, graph, f"({name})", title)
        poses = rows[number, 1].subgridspec(1, POSES, wspace=0.04)
        for column, step in enumerate(steps):
            axes = figure.add_subplot(poses[column])
            pose, blend = row.trace.poses[step], row.trace.blends[step]
            drawing.draw_grid(axes, pose, drag.problem.sample.faces, blend @ drawing.SHAPE_COLORS)
            drawing.draw_handles(axes, pose[drag.problem.handles])
            drawing.frame(axes, WINDOW)
    drawing.save(figure, path)


def draw_graph(axes: Axes, trace: Trace, last: bool) -> None:
    """The weights over time."""
    import drawing

    for blend, color in zip(trace.blends.T, drawing.SHAPE_COLORS, strict=True):
        axes.plot(trace.times / trace.times[-1], blend, color=color, linewidth=1.5)
    axes.set(xlim=(0, 1), ylim=(-0.05, 1.05), yticks=(0, 1), xticks=(0, 0.5, 1))
    axes.tick_params(length=2, labelbottom=last)
    if last:
        axes.set_xticklabels(("start", "farthest", "back"))
