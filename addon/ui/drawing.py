# SPDX-License-Identifier: GPL-3.0-or-later
"""What overlays are drawn with: rings, lines, boxes and text in pixels, in the theme's colours."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from math import cos, pi, sin

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

FONT = 0
TEXT_SIZE = 11  # points at a scale of one
SEGMENTS = 48  # of a circle
GOLDEN = 0.618034  # of a turn: hues that are far apart however many there are

Colour = Sequence[float]  # red, green, blue and opacity


def scale() -> float:
    return bpy.context.preferences.system.ui_scale


def theme_colour(name: str, opacity: float = 1.0) -> Colour:
    """Of the interface: gizmo_hi, axis_x and so on."""
    colour = getattr(bpy.context.preferences.themes[0].user_interface, name)
    return (*colour[:3], opacity)


def tooltip_colours() -> tuple[Colour, Colour]:
    """Background and text of the theme's tooltips."""
    widget = bpy.context.preferences.themes[0].user_interface.wcol_tooltip
    return (*widget.inner[:3], 0.85), (*widget.text, 1.0)


def shape_colours(count: int) -> np.ndarray:
    """One for each shape, #S by 3: grey for the rest shape, the others far apart."""
    hues = [(0.08 + GOLDEN * number) % 1.0 for number in range(count - 1)]
    return np.array([(0.62,) * 3, *(colorsys.hsv_to_rgb(hue, 0.62, 0.95) for hue in hues)])


def line(points: Sequence[Vector], width: float, colour: Colour) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width * scale())
    shader.uniform_float("color", colour)
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": [(*p[:2], 0.0) for p in points]})
    gpu.state.blend_set("ALPHA")
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def ring(middle: Vector, radius: float, width: float, colour: Colour) -> None:
    line(_arc(middle, radius, 0.0, 2 * pi, SEGMENTS), width, colour)


def box(low: Vector, high: Vector, colour: Colour, corner: float = 0.0) -> None:
    """A filled rectangle with round corners."""
    corner = min(corner, (high[0] - low[0]) / 2, (high[1] - low[1]) / 2)
    middles = (
        (high[0] - corner, high[1] - corner),
        (low[0] + corner, high[1] - corner),
        (low[0] + corner, low[1] + corner),
        (high[0] - corner, low[1] + corner),
    )
    outline = [
        point
        for quarter, middle in enumerate(middles)
        for point in _arc(Vector(middle), corner, quarter * pi / 2, (quarter + 1) * pi / 2, 6)
    ]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    fan = [(0, number, number + 1) for number in range(1, len(outline) - 1)]
    batch = batch_for_shader(
        shader, "TRIS", {"pos": [(*point, 0.0) for point in outline]}, indices=fan
    )
    shader.uniform_float("color", colour)
    gpu.state.blend_set("ALPHA")
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def text_size(text: str) -> Vector:
    """Its width, and the height of a capital letter."""
    blf.size(FONT, TEXT_SIZE * scale())
    return Vector((blf.dimensions(FONT, text)[0], blf.dimensions(FONT, "X")[1]))


def text(at: Vector, words: str, colour: Colour) -> None:
    """Words whose baseline begins at a point."""
    blf.size(FONT, TEXT_SIZE * scale())
    blf.color(FONT, *colour)
    blf.position(FONT, at[0], at[1], 0.0)
    blf.draw(FONT, words)


def label(at: Vector, words: str) -> None:
    """Words on a background, that begin at a point."""
    background, foreground = tooltip_colours()
    size, margin = text_size(words), 5 * scale()
    low = Vector(at) - Vector((0, size.y / 2 + margin))
    box(low, low + size + Vector((2 * margin, 2 * margin)), background, margin)
    text(low + Vector((margin, margin)), words, foreground)


def _arc(middle: Vector, radius: float, start: float, end: float, segments: int) -> list[Vector]:
    angles = [start + (end - start) * number / segments for number in range(segments + 1)]
    return [Vector(middle) + radius * Vector((cos(a), sin(a))) for a in angles]
