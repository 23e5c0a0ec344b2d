# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 8: what becomes of Figures 3 and 4 without one part of the method each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import fbt_3
import fbt_4
import gallop
import hand
import numpy as np
from fitting import Found, Stages, Task
from one_reference import solve_with_one

FIGURES = {"fox": (fbt_3, gallop.VIEW), "hand": (fbt_4, hand.VIEW)}
TITLES = {
    "full": "full method",
    "one_example": "(A) one example",
    "one_reference": "(B) one reference",
    "no_scale": "(C) no scale",
    "no_sparsity": "(D) start not sparse",
}


@dataclass(frozen=True)
class Ablations:
    """found: by the part that is left out; of each of a figure's tasks."""

    task: Task
    found: dict[str, Found]

    def mean_error(self, method: str) -> float:
        return self.task.error(self.found[method].positions)["mean"]


def ablate(task: Task) -> Ablations:
    whole, targets = Stages(task), task.targets
    return Ablations(
        task,
        {
            "full": whole.solve(targets),
            "one_example": Stages(task, examples=task.examples[:1]).solve(targets),
            "one_reference": solve_with_one(whole, targets),
            "no_scale": Stages(task, scale=False).solve(targets),
            "no_sparsity": Stages(task, sparsity=0.0).solve(targets),
            "ten_rounds": Stages(task, rounds=10).solve(targets),
            "ten_rounds_no_sparsity": Stages(task, sparsity=0.0, rounds=10).solve(targets),
        },
    )


def measure() -> dict[str, dict[str, Ablations]]:
    """For each body, by the pose to find."""
    return {
        name: {pose: ablate(task) for pose, task in figure.tasks().items()}
        for name, (figure, _) in FIGURES.items()
    }


def numbers(measured: dict[str, dict[str, Ablations]]) -> dict[str, dict]:
    """For each body and method (with ten rounds it is the paper's schedule to the letter): scale
    and errors of the drawn pose, as in Figures 3 and 4, and the mean error over all poses."""
    table: dict[str, dict] = {}
    for name, by_pose in measured.items():
        drawn = by_pose[FIGURES[name][0].DRAWN]
        table[name] = {
            method: {
                "scale": found.scale / drawn.task.size,
                **drawn.task.error(found.positions),
                "mean_over_all": float(
                    np.mean([one.mean_error(method) for one in by_pose.values()])
                ),
            }
            for method, found in drawn.found.items()
        }
    return table


def mean_over_all(by_pose: dict[str, Ablations], method: str) -> float:
    return float(np.mean([one.mean_error(method) for one in by_pose.values()]))


def draw(measured: dict[str, dict[str, Ablations]], path: Path) -> None:
    from drawing import Camera
    from strips import STONE, Panel, Strip
    from strips import draw as draw_strips

    strips = []
    for name, (figure, view) in FIGURES.items():
        one = measured[name][figure.DRAWN]
        task = one.task
        truth = task.size * task.truth
        panels = [Panel("truth", truth, task.triangles, np.tile(STONE, (len(truth), 1)))]
        for method, title in TITLES.items():
            found = one.found[method]
            error = 100 * task.error(found.positions)["mean"]
            panels.append(
                Panel(
                    f"{title}\n{error:.1f} %",
                    *(found.positions, task.triangles, task.sample.colors, task.targets),
                )
            )
        strips.append(Strip(Camera(*view), panels))
    draw_strips(strips, path)
