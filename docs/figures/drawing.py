# SPDX-License-Identifier: GPL-3.0-or-later
"""What all pictures share: the look of the page, of flat meshes, of meshes in space, of handles."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image
from problems import Problem
from shading import Camera, render

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

# The three squares: at rest, puffed, thinned.
SHAPE_COLORS = np.array([[0.80, 0.16, 0.13], [0.16, 0.58, 0.24], [0.14, 0.34, 0.76]])
GREY = "0.45"
DPI = 110

plt.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.linewidth": 0.7,
    }
)

Window = tuple[float, float, float, float]  # left, right, bottom, top


def window_around(point_sets: Sequence[np.ndarray], margin: float = 0.04) -> Window:
    """What holds all points (each #P by 2 or more), and a margin in parts of the larger side."""
    points = np.concatenate([points[:, :2] for points in point_sets])
    low, high = points.min(axis=0), points.max(axis=0)
    room = margin * (high - low).max()
    return low[0] - room, high[0] + room, low[1] - room, high[1] + room


def frame(axes: Axes, window: Window) -> None:
    """Shows the window at equal scales, with nothing around it."""
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    axes.axis("off")


def screen_colors(linear: np.ndarray) -> np.ndarray:
    """From linear RGB to what a screen shows."""
    return np.clip(linear, 0.0, 1.0) ** (1 / 2.2)


def draw_flat(
    axes: Axes, points: np.ndarray, faces: Sequence[Sequence[int]], colors: np.ndarray
) -> None:
    """A mesh in the plane. colors: RGB of the whole, or #V by 3."""
    corners = np.array(faces)
    filled = colors if colors.ndim == 1 else colors[corners].mean(axis=1)
    axes.add_collection(
        PolyCollection(points[corners], facecolor=filled, edgecolor=filled, linewidth=0.3)
    )


def draw_grid(
    axes: Axes, points: np.ndarray, faces: Sequence[Sequence[int]], color: np.ndarray
) -> None:
    """A mesh in the plane as a pale fill with its edges."""
    corners, pale = np.array(faces), 0.42 * color + 0.58
    axes.add_collection(
        PolyCollection(points[corners], facecolor=pale, edgecolor=color, linewidth=0.18)
    )


def draw_solid(
    axes: Axes, seen: np.ndarray, triangles: np.ndarray, colors: np.ndarray, window: Window
) -> None:
    """A mesh in space as Camera.project sees it (#V by 3); colors: #V by 3 linear RGB."""
    axes.apply_aspect()
    box = axes.get_window_extent()
    resolution = box.width * DPI / axes.figure.dpi / (window[1] - window[0])
    picture = render(seen, triangles, colors, window, resolution)
    axes.imshow(np.clip(picture, 0, 1), extent=window, interpolation="antialiased")


def draw_pose(axes: Axes, problem: Problem, seen: np.ndarray, window: Window) -> None:
    """A pose of a painted scene with its handles: #V by 2, or #V by 3 as Camera.project sees it."""
    frame(axes, window)
    sample = problem.sample
    if seen.shape[1] == 2:
        draw_flat(axes, seen, sample.faces, screen_colors(sample.colors))
    else:
        draw_solid(axes, seen, problem.triangles, sample.colors, window)
    draw_handles(axes, seen[problem.handles])
    frame(axes, window)


def draw_handles(
    axes: Axes, points: np.ndarray, size: float = 4.0, color: object = "black"
) -> None:
    """Dots, with a pale rim that keeps them apart from dark meshes."""
    axes.plot(
        *points[:, :2].T,
        "o",
        color=color,
        markersize=size,
        markeredgecolor="white",
        markeredgewidth=0.6,
        linestyle="none",
        clip_on=False,
        zorder=5,
    )


def row_label(figure: Figure, axes: Axes, letter: str, text: str) -> None:
    """Writes to the left of axes."""
    box = axes.get_position()
    middle = 0.5 * (box.y0 + box.y1)
    figure.text(0.008, middle, letter, va="center", fontsize=9.5, fontweight="bold")
    figure.text(0.030, middle, text, va="center", fontsize=9.5)


def save(figure: Figure, path: Path) -> None:
    """A PNG of 256 colours."""
    memory = BytesIO()
    figure.savefig(memory, dpi=DPI, facecolor="white")
    plt.close(figure)
    picture = Image.open(memory).convert("RGB")
    picture.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
        path, optimize=True
    )


__all__ = [
    "Axes",
    "Camera",
    "Figure",
    "GREY",
    "SHAPE_COLORS",
    "draw_flat",
    "draw_grid",
    "draw_handles",
    "draw_pose",
    "draw_solid",
    "frame",
    "plt",
    "row_label",
    "save",
    "screen_colors",
    "window_around",
]
