# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes `addon` and the sample scenes importable: these tests run in a plain Python, from any
folder."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


@dataclass(frozen=True)
class Animal:
    """shapes: #S by #V by 3. handles: their vertices, by name."""

    names: list[str]
    shapes: np.ndarray
    triangles: np.ndarray
    handles: dict[str, int]

    def without(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """All shapes but one, and that one."""
        number = self.names.index(name)
        return np.delete(self.shapes, number, axis=0), self.shapes[number]


@pytest.fixture(scope="session")
def creature() -> Animal:
    from sample_scenes import creature

    sample = creature.sample()
    shapes = np.stack(list(sample.shapes.values()))
    return Animal(list(sample.shapes), shapes, sample.triangles(), sample.handles)
