# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses as places of handles: to take, mirror, key and bring back, and to keep as a shape key."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Vector

from . import handles, shape_keys
from .inputs import RigError

Places = dict[str, Vector]  # of handles by name, in the space of the object


def current(obj: Object, depsgraph: bpy.types.Depsgraph) -> Places:
    """Where the handles are."""
    into = obj.evaluated_get(depsgraph).matrix_world.inverted_safe()
    return {
        handle.empty.name: into @ handle.empty.evaluated_get(depsgraph).matrix_world.translation
        for handle in _there(obj)
    }


def of_key(obj: Object, name: str) -> Places:
    """Where a shape key has the handles."""
    block = obj.data.shape_keys.key_blocks.get(name)
    if block is None:
        raise RigError(f'"{obj.name}" has no shape key "{name}"')
    return {
        handle.empty.name: block.points[handle.vertex].co.copy()
        for handle in _there(obj)
        if handle.vertex < len(block.points)
    }


def rest(obj: Object) -> Places:
    return of_key(obj, obj.data.shape_keys.reference_key.name)


def mirrored(obj: Object, places: Places) -> Places:
    """The same across the object's X: sides, as in names with .L and .R, change over. What is
    mirrored is how far each handle is from rest, so that a mesh need not be quite symmetric."""
    home = rest(obj)
    result = {}
    for name, place in places.items():
        other = handles.flipped(name)
        if name in home and other in home:
            moved = place - home[name]
            result[other] = home[other] + Vector((-moved.x, moved.y, moved.z))
    return result


def put(obj: Object, places: Places) -> list[Object]:
    """Move the handles that have a place; the empties that those were."""
    found = [handle for handle in _there(obj) if handle.empty.name in places]
    for handle in found:
        handles.place(obj, handle, places[handle.empty.name])
    return [handle.empty for handle in found]


def keyframe(obj: Object) -> None:
    """Key the location of every handle at the current frame."""
    for handle in _there(obj):
        handle.empty.keyframe_insert("location", group=handle.empty.name)


def save(obj: Object, name: str) -> bpy.types.ShapeKey:
    """The pose that is shown, as a shape key that is an example from the next bind on."""
    pose = shape_keys.coordinates(obj.data.shape_keys.key_blocks[obj.tug.result])
    if not np.isfinite(pose).all():
        raise RigError(f'the pose of "{obj.name}" is not finite: reset it first')
    block = obj.shape_key_add(name=name, from_mix=False)
    block.value = 0.0
    shape_keys.write(obj.data, block, pose)
    if block.name in obj.tug.shapes:
        obj.tug.shapes[block.name].use = True
    return block


def _there(obj: Object) -> list[bpy.types.PropertyGroup]:
    return [handle for handle in obj.tug.handles if handle.empty is not None]
