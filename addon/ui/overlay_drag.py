# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen while a handle is dragged: a ring around it, the axis it is kept on, and how much of
each example is in the mesh around it."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from ..rigging import blends
from . import drawing
from .drag import Drag
from .pull import AXES, Pull

ROWS = 8  # at most
LEAST = 0.005  # weights below are not shown
BAR_WIDTH, BAR_HEIGHT, ROW_HEIGHT, MARGIN, AWAY = 60, 7, 16, 8, 24  # pixels at a scale of one


class DragOverlay:
    """Drawn in the region of the drag from `show` to `hide`."""

    def __init__(self, region: bpy.types.Region, drag: Drag, pull: Pull) -> None:
        self.region, self.drag, self.pull = region, drag, pull
        self._handler: object = None

    def show(self) -> None:
        self._handler = bpy.types.SpaceView3D.draw_handler_add(
            self._draw, (), "WINDOW", "POST_PIXEL"
        )
        self.region.tag_redraw()

    def hide(self) -> None:
        if self._handler is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
            self._handler = None
            self.region.tag_redraw()

    def _draw(self) -> None:
        if bpy.context.region != self.region:
            return
        view = bpy.context.region_data
        place = self.drag.empty.matrix_world.translation
        at = view3d_utils.location_3d_to_region_2d(self.region, view, place)
        if at is None:
            return
        if self.pull.axis:
            self._draw_axis(view, at)
        drawing.ring(at, handle_radius(), 2.5, drawing.theme_colour("gizmo_hi"))
        rows = weights_shown(*blends.around(self.drag.obj, self.drag.empty))
        if rows:
            draw_bars(at, self.region, rows)

    def _draw_axis(self, view: bpy.types.RegionView3D, at: Vector) -> None:
        """Lines of the world are lines on the screen: two points are enough."""
        letters = [a for a in AXES if (a == self.pull.axis) != self.pull.across]
        for letter in letters:
            step = 0.01 * view.view_distance * AXES[letter]
            place = self.drag.empty.matrix_world.translation + step
            beside = view3d_utils.location_3d_to_region_2d(self.region, view, place)
            if beside is None or (beside - at).length < 0.01:
                continue
            reach = (beside - at).normalized() * (self.region.width + self.region.height)
            colour = drawing.theme_colour(f"axis_{letter.lower()}", 0.7)
            drawing.line((at - reach, at + reach), 1.5, colour)


def handle_radius() -> float:
    return 10 * drawing.scale()


def weights_shown(names: Sequence[str], weights: np.ndarray) -> list[tuple[str, float, np.ndarray]]:
    """Name, weight and colour of the largest weights, in the order of the keys."""
    largest = np.argsort(-weights, kind="stable")[:ROWS]
    colours = drawing.shape_colours(len(names))
    return [
        (names[number], float(weights[number]), colours[number])
        for number in sorted(largest)
        if weights[number] >= LEAST
    ]


def draw_bars(
    at: Vector, region: bpy.types.Region, rows: Sequence[tuple[str, float, np.ndarray]]
) -> None:
    """A bar for each row, to the right of a point, or to its left where there is no room."""
    unit = drawing.scale()
    background, foreground = drawing.tooltip_colours()
    widest = max(drawing.text_size(name).x for name, _, _ in rows)
    percents = drawing.text_size("100%").x
    width = widest + percents + (BAR_WIDTH + 4 * MARGIN) * unit
    height = (len(rows) * ROW_HEIGHT + MARGIN) * unit
    away = AWAY * unit
    has_room = at.x + away + width < region.width
    low = Vector((at.x + away if has_room else at.x - away - width, at.y - height / 2))
    low.y = max(0, min(low.y, region.height - height))
    drawing.box(low, low + Vector((width, height)), background, 6 * unit)
    left = low.x + MARGIN * unit
    middle = low.x + width - percents - (BAR_WIDTH + 2 * MARGIN) * unit
    for number, (name, weight, colour) in enumerate(rows):
        base = low.y + height - (MARGIN / 2 + (number + 0.75) * ROW_HEIGHT) * unit
        drawing.text(Vector((left, base)), name, foreground)
        start, size = Vector((middle, base)), Vector((BAR_WIDTH, BAR_HEIGHT)) * unit
        drawing.box(start, start + size, (*foreground[:3], 0.15), 2 * unit)
        size.x *= min(weight, 1.0)
        drawing.box(start, start + size, (*colour, 1.0), 2 * unit)
        percent = f"{100 * weight:.0f}%"
        right = low.x + width - MARGIN * unit - drawing.text_size(percent).x
        drawing.text(Vector((right, base)), percent, foreground)
