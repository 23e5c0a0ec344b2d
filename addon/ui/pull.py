# SPDX-License-Identifier: GPL-3.0-or-later
"""From the mouse to how far a handle is pulled: in the plane of the view, along an axis, or in the
plane across one."""

from __future__ import annotations

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector
from mathutils.geometry import intersect_line_plane

PRECISION = 0.1  # how much of a movement counts while Shift is held
# Sine of the angle between axis and line of sight below which the mouse cannot follow the axis.
END_ON = 0.05
AXES = {"X": Vector((1, 0, 0)), "Y": Vector((0, 1, 0)), "Z": Vector((0, 0, 1))}


class Pull:
    """place: of the handle at the start, in the world. mouse: in pixels of the region.

    axis is "" or a letter; across: whether the plane across the axis is meant instead of it.
    """

    def __init__(
        self, region: bpy.types.Region, view: bpy.types.RegionView3D, place: Vector, mouse: Vector
    ) -> None:
        self.region, self.view, self.place = region, view, place.copy()
        self.axis, self.across = "", False
        self._start = self._last = self._pointer = Vector(mouse)
        self._offset = Vector((0, 0, 0))

    @property
    def offset(self) -> Vector:
        """How far the handle is from its first place, in the world."""
        return self._offset

    def move(self, mouse: Vector, precise: bool) -> None:
        mouse = Vector(mouse)
        self._pointer = self._pointer + (mouse - self._last) * (PRECISION if precise else 1.0)
        self._last = mouse
        self._update()

    def constrain(self, axis: str, across: bool) -> None:
        """To the axis, to the plane across it, or to neither where it was asked for already."""
        if (self.axis, self.across) == (axis, across):
            axis, across = "", False
        self.axis, self.across = axis, across
        self._offset = Vector((0, 0, 0))
        self._update()

    def _update(self) -> None:
        """Where the mouse points at nothing, as beyond a horizon, the handle stays."""
        first, now = self._hit(self._start), self._hit(self._pointer)
        if first is not None and now is not None:
            self._offset = now - first

    def _hit(self, pointer: Vector) -> Vector | None:
        """The place that a pointer means, up to what is the same for all of them."""
        if not self.axis:
            return view3d_utils.region_2d_to_location_3d(
                self.region, self.view, pointer, self.place
            )
        axis = AXES[self.axis]
        eye = view3d_utils.region_2d_to_origin_3d(self.region, self.view, pointer)
        sight = view3d_utils.region_2d_to_vector_3d(self.region, self.view, pointer)
        side = sight.cross(axis)
        if self.across:
            return _in_front(eye, sight, self.place, axis)
        if side.length < END_ON:
            return None
        # In the plane through the axis that is seen most from the front.
        hit = _in_front(eye, sight, self.place, axis.cross(side))
        return None if hit is None else axis * (hit - self.place).dot(axis)


def _in_front(eye: Vector, sight: Vector, place: Vector, normal: Vector) -> Vector | None:
    """Where a line of sight meets a plane."""
    if abs(sight.dot(normal)) < END_ON * normal.length:
        return None
    hit = intersect_line_plane(eye, eye + sight, place, normal)
    return hit if hit is not None and (hit - eye).dot(sight) > 0 else None
