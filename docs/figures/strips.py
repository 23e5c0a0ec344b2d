# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of shapes in space, each row at one scale: what FBT's figures look like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

import drawing
import numpy as np
from drawing import Axes, Camera, Figure
from matplotlib.patches import FancyBboxPatch

WIDTH = 13.5  # of a page, in inches
TITLE, GAP, SPACE = 0.36, 0.12, 0.15  # inches above a row, between shapes, and beside a box
LETTER = 0.082  # inches that a letter of a title takes at most
STONE = np.array((0.42, 0.42, 0.44))  # of what is given, or true
POINT, OTHER = (0.85, 0.1, 0.1), (0.1, 0.3, 0.85)


@dataclass(frozen=True)
class Panel:
    """A shape (#V by 3) in the colours of each vertex, with dots (#P by 3), red, and others,
    blue; without triangles these alone. boxed: in a box with its neighbours that are."""

    title: str
    shape: np.ndarray
    triangles: np.ndarray
    colors: np.ndarray
    dots: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    boxed: bool = False
    others: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))


@dataclass(frozen=True)
class Strip:
    """Panels side by side, seen from one side, at one scale. tallest: inches of the highest."""

    camera: Camera
    panels: Sequence[Panel]
    tallest: float = 2.4


def draw(strips: Sequence[Strip], path: Path) -> None:
    """One strip above the other, each as wide as the page if it is not too tall then."""
    layouts = [_Layout(strip) for strip in strips]
    height = sum(layout.height for layout in layouts)
    figure = drawing.plt.figure(figsize=(WIDTH, height))
    top = height
    for layout in layouts:
        layout.draw(figure, top)
        top -= layout.height
    drawing.save(figure, path)


class _Layout:
    """Where the panels of a strip are; lengths in inches."""

    def __init__(self, strip: Strip) -> None:
        self.strip = strip
        seen = [strip.camera.project(panel.shape) for panel in strip.panels]
        self.windows = [drawing.window_around([points], 0.01) for points in seen]
        self.seen = seen
        self.gaps = [
            SPACE if before.boxed != after.boxed else GAP
            for before, after in zip(strip.panels, strip.panels[1:], strict=False)
        ]
        tallest = max(window[3] - window[2] for window in self.windows)
        self.scale = self._largest_scale(strip.tallest / tallest)
        self.widths = self._widths(self.scale)
        self.height = TITLE + self.scale * tallest + SPACE

    def _largest_scale(self, scale: float) -> float:
        """That fits the page, and is not above the given one."""
        while sum(self._widths(scale)) + sum(self.gaps) > WIDTH - 2 * SPACE:
            scale *= 0.99
        return scale

    def _widths(self, scale: float) -> list[float]:
        """Of the panels: of the shape or of the title."""
        titles = [max(map(len, panel.title.split("\n"))) for panel in self.strip.panels]
        return [
            max(scale * (window[1] - window[0]), LETTER * letters)
            for window, letters in zip(self.windows, titles, strict=True)
        ]

    def draw(self, figure: Figure, top: float) -> None:
        left = 0.5 * (WIDTH - sum(self.widths) - sum(self.gaps))
        boxes = []
        for panel, seen, window, width, gap in zip(
            *(self.strip.panels, self.seen, self.windows, self.widths, [*self.gaps, 0]), strict=True
        ):
            wide, rise = (self.scale * (window[i + 1] - window[i]) for i in (0, 2))
            middle = top - TITLE - 0.5 * (self.height - TITLE - SPACE)
            box = (left + 0.5 * (width - wide), middle - 0.5 * rise, wide, rise)
            axes = figure.add_axes(_parts(figure, box))
            _draw_panel(axes, panel, seen, self.strip.camera, window)
            figure.text(
                *_parts(figure, (left + 0.5 * width, top - 0.05)),
                *(panel.title,),
                **{"ha": "center", "va": "top", "linespacing": 1.15},
            )
            boxes.append((left, width))
            left += width + gap
        for boxed, group in groupby(
            zip(self.strip.panels, boxes, strict=True), lambda p: p[0].boxed
        ):
            if boxed:
                inner = [box for _, box in group]
                self._frame(figure, inner[0][0], sum(inner[-1]), top)

    def _frame(self, figure: Figure, left: float, right: float, top: float) -> None:
        pad = 0.4 * SPACE
        low, high = top - self.height + 0.3 * SPACE, top - TITLE + pad
        x, y, width, height = _parts(figure, (left - pad, low, right - left + 2 * pad, high - low))
        figure.add_artist(
            FancyBboxPatch(
                *((x, y), width, height),
                **{"boxstyle": "round,pad=0,rounding_size=0.004", "transform": figure.transFigure},
                **{"facecolor": "0.965", "edgecolor": "0.75", "linewidth": 0.8, "zorder": -1},
            )
        )


def _draw_panel(
    axes: Axes, panel: Panel, seen: np.ndarray, camera: Camera, window: drawing.Window
) -> None:
    drawing.frame(axes, window)
    if len(panel.triangles):
        drawing.draw_solid(axes, seen, panel.triangles, panel.colors, window)
    drawing.draw_handles(axes, camera.project(panel.dots), 5.5, POINT)
    drawing.draw_handles(axes, camera.project(panel.others), 5.5, OTHER)
    drawing.frame(axes, window)


def _parts(figure: Figure, lengths: Sequence[float]) -> tuple[float, ...]:
    """From inches to parts of the figure: x and y by turns."""
    sides = (*figure.get_size_inches(), *figure.get_size_inches())
    return tuple(length / side for length, side in zip(lengths, sides, strict=False))
