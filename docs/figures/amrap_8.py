# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 8: the blend of the three squares wherever the right handle is in the plane."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from paths import halve, line
from problems import Method, Problem, mean_blend
from project import Form, squares

WINDOW = (0.3, 2.5, -0.9, 0.9)
RESOLUTION = 90  # solves per unit along each axis
PURE = 0.99  # the weight from which a place belongs to one shape
PANELS = {
    "no_rotations_0.5": r"without rotations, $\lambda$ = 0.5",
    "no_rotations_10": r"without rotations, $\lambda$ = 10",
    "no_rotations_0.01": r"without rotations, $\lambda$ = 0.01",
    "steady_0.5": r"with rotations, $\lambda$ = 0.5",
}


@dataclass(frozen=True)
class Maps:
    """blends: for each panel #rows by #columns by 3, the lowest row first. jumps: what halving
    leaves of the largest change of a weight from a pixel to the next."""

    problem: Problem
    blends: dict[str, np.ndarray]
    jumps: dict[str, float]


def measure(resolution: float = RESOLUTION) -> Maps:
    problem = Problem.of(squares.sample())
    flat = {"form": Form.NO_ROTATIONS, "single_blend": True}
    solvers = {
        "no_rotations_0.5": problem.tug(**flat),
        "no_rotations_10": problem.tug(lambda_=10.0, **flat),
        "no_rotations_0.01": problem.tug(lambda_=0.01, **flat),
        "steady_0.5": problem.tug(single_blend=True),
    }
    blends = {name: scan(problem, solver, resolution) for name, solver in solvers.items()}
    jumps = {
        name: steepest_place(problem, solver, blends[name], resolution)
        for name, solver in solvers.items()
    }
    return Maps(problem, blends, jumps)


def places(resolution: float) -> tuple[np.ndarray, np.ndarray]:
    """The middles of the pixels, along x and y."""
    left, right, bottom, top = WINDOW
    x, y = (
        low + (np.arange(round(resolution * (high - low))) + 0.5) / resolution
        for low, high in ((left, right), (bottom, top))
    )
    return x, y


def scan(problem: Problem, method: Method, resolution: float) -> np.ndarray:
    x, y = places(resolution)
    targets = problem.targets("Basis")
    blends = np.empty((len(y), len(x), len(problem.shapes)))
    for row, column in np.ndindex(blends.shape[:2]):
        targets[-1] = x[column], y[row]
        method.solve(targets)
        blends[row, column] = mean_blend(method)
    return blends


def steepest_place(
    problem: Problem, method: Method, blends: np.ndarray, resolution: float
) -> float:
    """What is left of the largest change of a weight between neighbours along x."""
    x, y = places(resolution)
    change = np.abs(np.diff(blends, axis=1)).max(axis=2)
    row, column = np.unravel_index(change.argmax(), change.shape)
    ends = np.stack([problem.targets("Basis")] * 2)
    ends[:, -1] = [(x[column], y[row]), (x[column + 1], y[row])]
    return halve(method, line(ends), 0.0, 1.0).weight


def numbers(maps: Maps) -> dict[str, dict[str, float]]:
    """For each panel: the part of the plane where one shape has nearly all weight, the mean weight
    of the heaviest shape, the largest change of a weight from a pixel to the next, and what halving
    leaves of it."""
    return {
        name: {
            "one_shape": float((blends.max(axis=2) >= PURE).mean()),
            "heaviest": float(blends.max(axis=2).mean()),
            "largest_step": float(max(np.abs(np.diff(blends, axis=a)).max() for a in (0, 1))),
            "weight_jump": maps.jumps[name],
        }
        for name, blends in maps.blends.items()
    }


def draw(maps: Maps, path: Path) -> None:
    import drawing

    figure, grid = drawing.plt.subplots(2, 2, figsize=(9.2, 7.9))
    figure.subplots_adjust(0.005, 0.005, 0.995, 0.965, 0.02, 0.06)
    examples = maps.problem.shapes[:, maps.problem.handles]
    for axes, (name, blends) in zip(grid.flat, maps.blends.items(), strict=True):
        axes.imshow(
            blends @ drawing.SHAPE_COLORS,
            extent=WINDOW,
            origin="lower",
            interpolation="nearest",
        )
        drawing.draw_handles(axes, examples[:, -1], 6)
        drawing.draw_handles(axes, examples[0, 1:2], 3)
        drawing.frame(axes, WINDOW)
        axes.set_title(PANELS[name], fontsize=11)
    drawing.save(figure, path)
