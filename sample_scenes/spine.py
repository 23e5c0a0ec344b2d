# SPDX-License-Identifier: GPL-3.0-or-later
"""A curve in the plane from its direction along its length: what flat drawings are built on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Along = Callable[[np.ndarray], np.ndarray]

FINE = 20  # steps of integration between two points


def spine(direction: Along, speed: Along, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`count` points of a curve that begins at the origin, and the unit vectors to its left there:
    both #P by 2.

    direction: u in 0..1 -> angle in radians
    speed: u in 0..1 -> length of the curve per u
    """
    fine = np.linspace(0.0, 1.0, 1 + FINE * (count - 1))
    middle = (fine[1:] + fine[:-1]) / 2
    angle, step = direction(middle), speed(middle) / len(middle)
    steps = np.stack([step * np.cos(angle), step * np.sin(angle)], axis=1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])[::FINE]
    angle = direction(fine[::FINE])
    return points, np.stack([-np.sin(angle), np.cos(angle)], axis=1)
