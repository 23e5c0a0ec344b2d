# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample character, to try Tug with."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from .. import sample
from .rig_operator import EXPECTED


class TUG_OT_open_sample(Operator):
    """Open a fox with shape keys and handles in a scene of its own, to try Tug with"""

    bl_idname = "tug.open_sample"
    bl_label = "Open Sample"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: Context) -> set[str]:
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            obj = sample.add_scene()
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if context.window is not None:
            layer = context.window.view_layer
            layer.objects.active = obj
            obj.select_set(True, view_layer=layer)
            show(context)
        return {"FINISHED"}


def show(context: Context) -> None:
    """Frame the whole scene in the viewports, in the colours of the character, ready to drag."""
    for area in context.window.screen.areas:
        if area.type != "VIEW_3D":
            continue
        area.spaces.active.shading.color_type = "VERTEX"
        region = next(region for region in area.regions if region.type == "WINDOW")
        with context.temp_override(area=area, region=region):
            bpy.ops.view3d.view_all()
            bpy.ops.wm.tool_set_by_id(name="tug.drag")


CLASSES = (TUG_OT_open_sample,)
