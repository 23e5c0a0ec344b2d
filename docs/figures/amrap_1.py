# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 1: the three squares."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from problems import Problem
from project import squares

WINDOW = (-0.1, 1.95, -0.82, 0.82)


def measure() -> Problem:
    return Problem.of(squares.sample())


def numbers(problem: Problem) -> dict[str, float]:
    """Width and height of each shape."""
    sizes = np.ptp(problem.shapes, axis=1)
    names = problem.sample.shapes
    return {name: size.tolist() for name, size in zip(names, sizes, strict=True)}


def draw(problem: Problem, path: Path) -> None:
    import drawing

    figure, row = drawing.plt.subplots(1, 3, figsize=(8, 2.5))
    for axes, shape, color, name in zip(
        row, problem.shapes, drawing.SHAPE_COLORS, problem.sample.shapes, strict=True
    ):
        drawing.draw_grid(axes, shape, problem.sample.faces, color)
        drawing.draw_handles(axes, shape[problem.handles], 5)
        drawing.frame(axes, WINDOW)
        axes.set_title(name, fontsize=10, color=color)
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.88, 0.02)
    drawing.save(figure, path)
