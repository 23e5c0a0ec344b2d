# SPDX-License-Identifier: GPL-3.0-or-later
"""Which handle is under the mouse."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

REACH = 14  # pixels from a handle's middle that still count as on it


@dataclass(frozen=True)
class Picked:
    """A handle of a bound rig, and where it is on the screen, in pixels of the region."""

    obj: bpy.types.Object
    empty: bpy.types.Object
    at: Vector
    radius: float


def handle_at(context: bpy.types.Context, mouse: Vector) -> Picked | None:
    """The handle that the mouse, in pixels of the region, is on."""
    mouse = Vector(mouse)
    near = [picked for picked in _shown(context) if (picked.at - mouse).length <= picked.radius]
    return min(near, key=lambda picked: (picked.at - mouse).length, default=None)


def bound_rigs(scene: bpy.types.Scene) -> Iterator[bpy.types.Object]:
    """Objects that share a mesh show the pose of the first of them."""
    meshes = set()
    for obj in scene.objects:
        if obj.type == "MESH" and obj.tug.bound and obj.data not in meshes:
            meshes.add(obj.data)
            yield obj


def _shown(context: bpy.types.Context) -> Iterator[Picked]:
    for obj in bound_rigs(context.scene):
        for handle in obj.tug.handles:
            if handle.empty is not None and _can_be_pulled(handle.empty, context):
                picked = _on_screen(context, obj, handle.empty)
                if picked is not None:
                    yield picked


def _can_be_pulled(empty: bpy.types.Object, context: bpy.types.Context) -> bool:
    return empty.library is None and empty.visible_get(viewport=context.space_data)


def _on_screen(
    context: bpy.types.Context, obj: bpy.types.Object, empty: bpy.types.Object
) -> Picked | None:
    region, view = context.region, context.region_data
    place = empty.matrix_world.translation
    at = view3d_utils.location_3d_to_region_2d(region, view, place)
    if at is None:
        return None
    right = view.view_matrix.inverted().col[0].xyz
    size = empty.empty_display_size * max(empty.matrix_world.to_scale())
    edge = view3d_utils.location_3d_to_region_2d(region, view, place + size * right)
    drawn = (edge - at).length if edge is not None else 0.0
    reach = REACH * context.preferences.system.ui_scale
    return Picked(obj, empty, at, max(drawn, reach))
