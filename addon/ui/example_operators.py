# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape keys poses draw on."""

from __future__ import annotations

from bpy.props import StringProperty
from bpy.types import Context, Object, Operator

from ..rigging import inputs
from . import state
from .rig_operator import RigOperator


class TUG_OT_tick_example(RigOperator, Operator):
    """Let poses draw on this shape key, or leave it out. Applies when the mesh is bound again"""

    bl_idname = "tug.tick_example"
    bl_label = "Use as Example"
    needs = (state.local, state.keys)

    key: StringProperty(name="Shape Key", options={"SKIP_SAVE"})

    def act(self, _context: Context, obj: Object) -> None:
        inputs.tick(obj, self.key, use=self.key not in inputs.ticked(obj))


CLASSES = (TUG_OT_tick_example,)
