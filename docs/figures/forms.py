# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample creature's motion in the steady form and in the paper's own: poses, and how far a
vertex moves in each step, so that jumps show."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from paths import Jump, Trace, Way, follow, worst_jump
from problems import Problem
from project import Form, creature, farthest

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STEPS_A_FRAME = 4
POSES = 8
FORMS = {"steady": Form.STEADY, "paper": Form.PAPER}
LABELS = {"steady": "steady\nform", "paper": "paper's\nform"}


@dataclass(frozen=True)
class Motion:
    """handles: how far the handle that moves furthest goes in each step."""

    problem: Problem
    traces: dict[str, Trace]
    jumps: dict[str, Jump]
    handles: np.ndarray


def path_of(problem: Problem) -> tuple[Way, np.ndarray]:
    """Handle positions at a frame, straight between the scene's waypoints; and their frames."""
    motion = problem.sample.motion
    frames = np.array([waypoint.frame for waypoint in motion], float)
    stops = np.stack([list(problem.sample.handle_positions(w).values()) for w in motion])

    def at(frame: float) -> np.ndarray:
        first = min(np.searchsorted(frames, frame, side="right") - 1, len(frames) - 2)
        share = (frame - frames[first]) / (frames[first + 1] - frames[first])
        return stops[first] + share * (stops[first + 1] - stops[first])

    return at, frames


def measure(steps_a_frame: int = STEPS_A_FRAME) -> Motion:
    problem = Problem.of(creature.sample())
    at, frames = path_of(problem)
    times = np.linspace(frames[0], frames[-1], round(frames[-1] - frames[0]) * steps_a_frame + 1)
    traces, jumps = {}, {}
    for name, form in FORMS.items():
        method = problem.tug(form=form)
        traces[name] = follow(method, at, times)
        jumps[name] = worst_jump(method, at, traces[name])
    handles = np.array([farthest(at(a), at(b)) for a, b in pairwise(times)])
    return Motion(problem, traces, jumps, handles)


def numbers(motion: Motion) -> dict[str, dict[str, float]]:
    """For each form, lengths in parts of the rest shape's diagonal: the largest movement of a
    vertex in a step, the same over that of the handles, what is left of the worst step after
    halving, and how many of the solves did not converge."""
    diagonal = motion.problem.diagonal
    table = {}
    for name, trace in motion.traces.items():
        movements = trace.movements()
        table[name] = {
            "largest_step": float(movements.max() / diagonal),
            "steepest": float((movements / motion.handles).max()),
            "movement_jump": motion.jumps[name].movement / diagonal,
            "jump_at": motion.jumps[name].time,
            "unconverged": trace.unconverged,
            "solves": len(trace.times),
        }
    return table


def draw(motion: Motion, path: Path) -> None:
    import drawing

    problem, camera = motion.problem, drawing.Camera(*motion.problem.sample.view)
    edges = np.linspace(0, len(motion.handles), POSES + 1).round().astype(int)
    seen = {
        name: [camera.project(pose) for pose in trace.poses[edges[1:]]]
        for name, trace in motion.traces.items()
    }
    window = drawing.window_around([pose for poses in seen.values() for pose in poses], 0.02)
    figure = drawing.plt.figure(figsize=(13.5, 6.0))
    rows = figure.add_gridspec(3, 1, height_ratios=[1, 1, 0.85])
    rows.update(left=0.075, right=0.995, top=0.995, bottom=0.085, hspace=0.16)
    for number, (name, poses) in enumerate(seen.items()):
        tiles = rows[number].subgridspec(1, POSES, wspace=0.03).subplots()
        moved = motion.traces[name].movements() / problem.diagonal
        for axes, pose, (start, end) in zip(tiles, poses, pairwise(edges), strict=True):
            drawing.draw_pose(axes, problem, pose, window)
            axes.text(
                *(0.5, -0.02, f"{100 * moved[start:end].max():.1f} %"),
                **{"transform": axes.transAxes, "ha": "center", "va": "top"},
            )
        drawing.row_label(figure, tiles[0], f"({'ab'[number]})", LABELS[name])
    draw_graph(figure.add_subplot(rows[2]), motion, edges)
    drawing.save(figure, path)


def draw_graph(axes: Axes, motion: Motion, edges: np.ndarray) -> None:
    """Movement in each step over the frames."""
    import drawing

    times = next(iter(motion.traces.values())).times
    percent = 100 / motion.problem.diagonal
    middle = 0.5 * (times[1:] + times[:-1])
    for name, color in (("paper", drawing.SHAPE_COLORS[0]), ("steady", drawing.SHAPE_COLORS[2])):
        moved = percent * motion.traces[name].movements()
        axes.plot(middle, moved, color=color, linewidth=1.3, label=LABELS[name].replace("\n", " "))
    axes.plot(middle, percent * motion.handles, color=drawing.GREY, linewidth=1, label="handles")
    axes.vlines(times[edges], 0, 1, color="0.88", transform=axes.get_xaxis_transform(), zorder=0)
    axes.set(xlim=times[[0, -1]], ylim=(0, None), xlabel="frame")
    axes.set_ylabel("furthest vertex,\n% of the diagonal")
    axes.legend(frameon=False, loc="upper left", ncols=3)
