# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 3: a fox half as large again as its four examples, from six points."""

from __future__ import annotations

from pathlib import Path

import gallop
import reconstruction
from fitting import Task
from project import creature
from reconstruction import Reconstruction, numbers

__all__ = ["draw", "measure", "numbers", "tasks"]

SIZE, FEATURES = 1.5, 6
DRAWN = "Flying"
FAR = ("Looking Left", "Sitting", "Curled")  # from all four examples


def tasks() -> dict[str, Task]:
    """By the pose to find."""
    fox = creature.sample()
    poses = gallop.shapes() | {name: fox.shapes[name] for name in FAR}
    return {
        name: Task.of(fox, gallop.EXAMPLES, pose, FEATURES, SIZE) for name, pose in poses.items()
    }


def measure() -> dict[str, Reconstruction]:
    return reconstruction.measure(tasks())


def draw(results: dict[str, Reconstruction], path: Path) -> None:
    reconstruction.draw(results[DRAWN], gallop.VIEW, path)
