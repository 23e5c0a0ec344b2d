# SPDX-License-Identifier: GPL-3.0-or-later
"""The Mesh Cache modifier that shows a bake."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

NAME = "Tug Bake"


def set_up(obj: bpy.types.Object, path: Path, first: int) -> None:
    """Show the first frame of the PC2 file at frame `first`, and so on; before and after, the first
    and last stay."""
    modifier = obj.modifiers.get(NAME) or obj.modifiers.new(NAME, "MESH_CACHE")
    modifier.cache_format, modifier.filepath = "PC2", _relative(path)
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    modifier.frame_start, modifier.frame_scale = first, 1.0
    modifier.deform_mode, modifier.interpolation = "OVERWRITE", "LINEAR"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    # First of all: it stands for the shape keys, and needs the vertices as they are before others.
    obj.modifiers.move(obj.modifiers.find(NAME), 0)


def shown(obj: bpy.types.Object, mode: str) -> bool:
    """Whether a bake is what is seen of the object. mode: of a depsgraph, VIEWPORT or RENDER."""
    modifier = obj.modifiers.get(NAME)
    if modifier is None:
        return False
    enabled = modifier.show_render if mode == "RENDER" else modifier.show_viewport
    return enabled and os.path.isfile(bpy.path.abspath(modifier.filepath))


def _relative(path: Path) -> str:
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:  # on another drive
        return str(path)
