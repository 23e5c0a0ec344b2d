# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys as arrays, and the one that shows the solved pose.

Blender shows Basis plus, for each key that is not muted, its value times its difference from the
key it is relative to. While a rig is bound its examples are muted, which keeps their values,
drivers and curves, and the result key stands at 1: the mesh is the pose, plus what the keys that
the artist left out of the examples (a blink, a correction) add on top.
"""

from __future__ import annotations

import bpy
import numpy as np

from . import vertex_groups


def coordinates(block: bpy.types.ShapeKey) -> np.ndarray:
    """#V by 3 float32, in object space."""
    flat = np.empty(3 * len(block.points), np.float32)
    block.points.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def write(mesh: bpy.types.Mesh, block: bpy.types.ShapeKey, positions: np.ndarray) -> None:
    block.points.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
    # Later versions do so by themselves, and faster: a tag of our own costs 15 ms in a scene of
    # 3000 objects.
    if bpy.app.version < (4, 3):
        mesh.update_tag()


def added_on_top(obj: bpy.types.Object, result: str) -> np.ndarray | float:
    """What the keys besides `result` add to the mesh as it is shown: #V by 3, or 0."""
    keys = obj.data.shape_keys
    total = 0.0
    for block in keys.key_blocks:
        if block in (keys.reference_key, keys.key_blocks.get(result)):
            continue
        if not block.mute and block.value:
            total += block.value * _difference(obj, block)
    return total


def displayed(obj: bpy.types.Object) -> np.ndarray:
    """The mix of all keys as it is shown, before any modifier: #V by 3."""
    if obj.show_only_shape_key:
        return coordinates(obj.active_shape_key)
    return coordinates(obj.data.shape_keys.reference_key) + added_on_top(obj, "")


def add_result(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    """A new key that starts as Basis, at value 1."""
    block = obj.shape_key_add(name="Tug", from_mix=False)
    block.value = 1.0
    return block


def _difference(obj: bpy.types.Object, block: bpy.types.ShapeKey) -> np.ndarray:
    difference = coordinates(block) - coordinates(block.relative_key)
    if block.vertex_group in obj.vertex_groups:
        difference *= vertex_groups.read(obj, [block.vertex_group])
    return difference
