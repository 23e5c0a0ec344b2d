# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 4: a hand of 70 % of the size of its seven examples, from six points."""

from __future__ import annotations

from pathlib import Path

import hand
import reconstruction
from fitting import Task
from project import BASIS
from reconstruction import Reconstruction, numbers

__all__ = ["draw", "measure", "numbers", "tasks"]

SIZE, FEATURES = 0.7, 6
DRAWN = "Four"


def tasks() -> dict[str, Task]:
    """Each pose but the rest pose from all others."""
    sample = hand.sample()
    names = [name for name in sample.shapes if name != BASIS]
    return {
        name: Task.of(
            *(sample, [other for other in sample.shapes if other != name]),
            *(sample.shapes[name], FEATURES, SIZE),
        )
        for name in names
    }


def measure() -> dict[str, Reconstruction]:
    return reconstruction.measure(tasks())


def draw(results: dict[str, Reconstruction], path: Path) -> None:
    reconstruction.draw(results[DRAWN], hand.VIEW, path)
