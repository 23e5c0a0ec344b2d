# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool of the 3D viewport's toolbar: handles light up under the mouse and are pulled."""

from __future__ import annotations

from typing import ClassVar

import bpy
from mathutils import Vector

from . import drawing
from .overlay_drag import handle_radius
from .picking import handle_at


class TUG_WT_drag(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "tug.drag"
    bl_label = "Tug"
    bl_description = "Pull the handles of a bound mesh: it follows in the manner of its shape keys"
    bl_icon = "ops.transform.push_pull"
    # A press beside all handles goes to the selection tool.
    bl_options: ClassVar = {"KEYMAP_FALLBACK"}
    bl_keymap = (("tug.drag", {"type": "LEFTMOUSE", "value": "PRESS"}, None),)

    @staticmethod
    def draw_settings(
        context: bpy.types.Context, layout: bpy.types.UILayout, _tool: bpy.types.WorkSpaceTool
    ) -> None:
        layout.prop(context.window_manager, "tug_colours", text="Colours")

    @staticmethod
    def draw_cursor(
        context: bpy.types.Context, _tool: bpy.types.WorkSpaceTool, xy: tuple[int, int]
    ) -> None:
        """The handle under the mouse, until it is dragged; coordinates are the window's."""
        if any(running.bl_idname == "TUG_OT_drag" for running in context.window.modal_operators):
            return
        corner = Vector((context.region.x, context.region.y))
        picked = handle_at(context, Vector(xy) - corner)
        if picked is None:
            return
        at = picked.at + corner
        drawing.ring(at, handle_radius(), 2.0, drawing.theme_colour("gizmo_hi"))
        drawing.label(at + Vector((handle_radius() + 6, 0)), picked.empty.name)


def register() -> None:
    bpy.utils.register_tool(TUG_WT_drag, after={"builtin.transform"}, separator=True)


def unregister() -> None:
    _put_away()
    bpy.utils.unregister_tool(TUG_WT_drag)


def _put_away() -> None:
    """Blender would go on drawing the cursor of a tool that is gone."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            tool = window.workspace.tools.from_space_view3d_mode("OBJECT")
            if area.type == "VIEW_3D" and tool and tool.idname == TUG_WT_drag.bl_idname:
                with bpy.context.temp_override(window=window, area=area):
                    bpy.ops.wm.tool_set_by_id(name="builtin.select_box")
