# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the animation of a rig, and go back to the live rig."""

from __future__ import annotations

from collections.abc import Iterator

from bpy.props import FloatProperty
from bpy.types import Context, Object, Operator

from .. import bake
from ..caches import mesh_cache
from . import state
from .film_operator import FilmOperator
from .rig_operator import RigOperator


class TUG_OT_bake(FilmOperator, Operator):
    """Write every frame to a file that plays back fast and renders safely"""

    bl_idname = "tug.bake"
    bl_label = "Bake Animation"
    needs = (state.bound, state.out_of_edit_mode, state.up_to_date)
    doing = "Baking"

    smoothing: FloatProperty(
        name="Smoothing",
        description="Over how many frames the choice of shape keys is averaged. Handles are met "
        "all the same",
        default=0.0,
        min=0.0,
        soft_max=10.0,
    )

    def roll(self, obj: Object) -> Iterator[tuple[str, float]]:
        paths = {obj: self.filepath}
        return bake.roll_rigs(paths, self.first, self.last, smoothing=self.smoothing)


class TUG_OT_remove_bake(RigOperator, Operator):
    """Take the bake off the mesh: it follows its handles again. The file stays"""

    bl_idname = "tug.remove_bake"
    bl_label = "Remove Bake"
    needs = (state.baked,)

    def act(self, _context: Context, obj: Object) -> None:
        obj.modifiers.remove(obj.modifiers[mesh_cache.NAME])


CLASSES = (TUG_OT_bake, TUG_OT_remove_bake)
