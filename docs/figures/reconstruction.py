# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes from few points of another size: what FBT's Figures 3 and 4 have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fitting import Found, Stages, Task


@dataclass(frozen=True)
class Reconstruction:
    """What was found for a task; and the scales found for its examples in the task's size."""

    task: Task
    found: Found
    of_examples: np.ndarray


def measure(tasks: Mapping[str, Task]) -> dict[str, Reconstruction]:
    """By the pose that is looked for."""
    results = {}
    for name, task in tasks.items():
        stages = Stages(task)
        known = [stages.solve(task.size * shape[task.features]) for shape in task.examples]
        scales = np.array([found.scale for found in known])
        results[name] = Reconstruction(task, stages.solve(task.targets), scales)
    return results


def numbers(results: Mapping[str, Reconstruction]) -> dict[str, dict[str, float]]:
    """For each pose the scale that was found, in parts of the true one; how far an example's is
    from the true one at most; mean and largest distance of a vertex from the truth, in parts of the
    root of its area."""
    return {
        name: {
            "scale": result.found.scale / result.task.size,
            "scale_of_examples_off": float(np.abs(result.of_examples / result.task.size - 1).max()),
            **result.task.error(result.found.positions),
        }
        for name, result in results.items()
    }


def draw(result: Reconstruction, view: tuple[float, float], path: Path) -> None:
    """Examples, points, what was found, and the truth, all at one scale."""
    from drawing import Camera
    from strips import STONE, Panel, Strip
    from strips import draw as draw_strips

    task, found = result.task, result.found
    none, colors = np.empty((0, 3), int), task.sample.colors
    truth = task.size * task.truth
    panels = [
        *(
            Panel(name, shape, task.triangles, colors, boxed=True)
            for name, shape in zip(task.names, task.examples, strict=True)
        ),
        Panel(f"{len(task.features)} points", truth, none, colors, task.targets),
        Panel(
            f"found, scale {found.scale:.3f}", found.positions, task.triangles, colors, task.targets
        ),
        Panel("truth", truth, task.triangles, np.tile(STONE, (len(truth), 1))),
    ]
    draw_strips([Strip(Camera(*view), panels)], path)
