# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 2: poses that are not among the examples, and the shapes nearest to them in the
example-based dictionary of fifteen eigenfunctions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import gallop
import hand
import numpy as np
from fitting import Task
from project import Mesh, compute_eigenfunctions, creature, fit_dictionary

FUNCTIONS = 15
VIEWS = {"fox": gallop.VIEW, "hand": hand.VIEW}


@dataclass(frozen=True)
class Nearest:
    """fitted: for each number of examples, from one to all, the nearest shape, #V by 3."""

    task: Task
    fitted: list[np.ndarray]


def tasks() -> dict[str, Task]:
    fox, five = creature.sample(), hand.sample()
    return {
        "fox": Task.of(fox, gallop.EXAMPLES, gallop.shapes()["Gathered"], 1),
        "hand": Task.of(five, ("Basis", "Fist", "Pinch", "Hook"), five.shapes["Two"], 1),
    }


def measure() -> dict[str, Nearest]:
    return {name: Nearest(task, nearest(task)) for name, task in tasks().items()}


def nearest(task: Task) -> list[np.ndarray]:
    with Mesh(task.examples[0], task.triangles) as mesh:
        _, functions, _ = compute_eigenfunctions(mesh, FUNCTIONS)
    counts = range(1, 1 + len(task.examples))
    return [fit_dictionary(task.examples[:count], functions, task.truth)[1] for count in counts]


def numbers(found: dict[str, Nearest]) -> dict[str, dict[str, dict[str, float]]]:
    """For each body, by the number of examples, the mean and the largest distance of a vertex from
    the truth, in parts of the root of its area."""
    return {
        name: {str(count): one.task.error(fitted) for count, fitted in enumerate(one.fitted, 1)}
        for name, one in found.items()
    }


def draw(found: dict[str, Nearest], path: Path) -> None:
    from drawing import Camera
    from strips import STONE, Panel, Strip
    from strips import draw as draw_strips

    strips = []
    for name, one in found.items():
        task, grey = one.task, np.tile(STONE, (len(one.task.truth), 1))
        error = 100 * task.error(one.fitted[-1])["largest"]
        strips.append(
            Strip(
                Camera(*VIEWS[name]),
                [
                    *(
                        Panel(title, shape, task.triangles, task.sample.colors, boxed=True)
                        for title, shape in zip(task.names, task.examples, strict=True)
                    ),
                    Panel("true pose", task.truth, task.triangles, grey),
                    Panel(
                        f"nearest shape,\n{error:.1f} % off at most",
                        *(one.fitted[-1], task.triangles, task.sample.colors),
                    ),
                ],
            )
        )
    draw_strips(strips, path)
