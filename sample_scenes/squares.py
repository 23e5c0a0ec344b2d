# SPDX-License-Identifier: GPL-3.0-or-later
"""The three squares of AMRAP, Figure 1: at rest, puffed outward, then thinned inward.

Handles in the middle of the left side, of the square and of the right side; the right one is
dragged. All three shapes agree at the other two, so that the dragged handle alone tells them apart,
and one blend serves the whole square, as in the paper's section 4: its weights are then piecewise
linear in the dragged position.
"""

from __future__ import annotations

import numpy as np

from .sample import BASIS, Sample, Waypoint, grid_quads, nearest_vertex

SIDE = 31  # vertices along a side; odd, so that one of them is in the middle
PUFFED, THINNED = "Puffed", "Thinned"


def stretched(rest: np.ndarray, length: float, bulge: float) -> np.ndarray:
    """The square's right half drawn out by `length`, its middle taller (or lower) by the fraction
    `bulge`."""
    x, y, z = rest.T
    drawn = x + length * 2 * np.maximum(x - 0.5, 0)
    return np.stack([drawn, y * (1 + bulge * np.sin(np.pi * x)), z], axis=1)


def sample() -> Sample:
    """A unit square in the XY plane."""
    step = np.linspace(0, 1, SIDE)
    x, y = np.meshgrid(step, step - 0.5)
    rest = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    column, row = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    ruled = ((column % 5 == 0) | (row % 5 == 0)).ravel()
    return Sample(
        name="squares",
        faces=grid_quads(SIDE, SIDE),
        shapes={
            BASIS: rest,
            PUFFED: stretched(rest, 0.4, 0.5),
            THINNED: stretched(rest, 0.8, -0.5),
        },
        handles={
            "Left": nearest_vertex(rest, (0, 0, 0)),
            "Centre": nearest_vertex(rest, (0.5, 0, 0)),
            "Right": nearest_vertex(rest, (1, 0, 0)),
        },
        motion=[
            Waypoint(1, BASIS),
            Waypoint(13, PUFFED),
            Waypoint(25, THINNED),
            Waypoint(37, PUFFED),
            Waypoint(48, BASIS),
        ],
        colors=np.where(ruled[:, None], (0.02, 0.05, 0.12), (0.18, 0.42, 0.68)),
        view=(0, 90),
        single_blend=True,
    )
