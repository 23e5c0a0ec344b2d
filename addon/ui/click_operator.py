# SPDX-License-Identifier: GPL-3.0-or-later
"""Add handles by clicks on the surface."""

from __future__ import annotations

import bpy
from bpy.types import Context, Event, Object, Operator
from bpy_extras import view3d_utils

from ..rigging import handles
from ..rigging.inputs import RigError
from . import state
from .rig_operator import EXPECTED, RigOperator

HELP = "Click on the mesh: Add Handle     Enter, Esc or Right Mouse: Finish"


class TUG_OT_click_handles(RigOperator, Operator):
    """Click on the mesh to add handles, as many as you like. Enter or Esc ends it"""

    bl_idname = "tug.click_handles"
    bl_label = "Add Handles by Click"
    bl_options = {"REGISTER"}  # each click is an undo step of its own
    needs = (state.local, state.keys, state.out_of_edit_mode)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        self._identity = state.rig_of(context).session_uid
        context.workspace.status_text_set(HELP)
        context.window.cursor_modal_set("CROSSHAIR")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def act(self, _context: Context, _obj: Object) -> None:
        raise RigError("handles are added by the mouse: start it from the panel or the menu")

    def modal(self, context: Context, event: Event) -> set[str]:
        obj = state.find(self._identity)
        if obj is None or event.type in {"ESC", "RET", "NUMPAD_ENTER", "RIGHTMOUSE"}:
            self._end(context)
            return {"FINISHED"}
        region = viewport_at(context, event)
        if event.type != "LEFTMOUSE" or event.value != "PRESS" or region is None:
            return {"PASS_THROUGH"}
        try:
            self._add(context, obj, *region, event)
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
        return {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        self._end(context)

    def _end(self, context: Context) -> None:
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()

    def _add(
        self,
        context: Context,
        obj: Object,
        region: bpy.types.Region,
        view: bpy.types.RegionView3D,
        event: Event,
    ) -> None:
        vertex = vertex_under(
            *(obj, context.evaluated_depsgraph_get(), region, view),
            (event.mouse_x - region.x, event.mouse_y - region.y),
        )
        if vertex is None:
            return
        if handles.add_on(obj, [vertex]):
            bpy.ops.ed.undo_push(message=self.bl_label)
        else:
            self.report({"INFO"}, "There is a handle already")


def viewport_at(
    context: Context, event: Event
) -> tuple[bpy.types.Region, bpy.types.RegionView3D] | None:
    """The 3D view under the mouse, without the panels that lie over it."""
    for area in context.window.screen.areas:
        if area.type != "VIEW_3D":
            continue
        under = [region for region in area.regions if _holds(region, event)]
        if under and all(region.type == "WINDOW" for region in under):
            return under[0], under[0].data
    return None


def vertex_under(
    obj: Object,
    depsgraph: bpy.types.Depsgraph,
    region: bpy.types.Region,
    view: bpy.types.RegionView3D,
    place: tuple[float, float],
) -> int | None:
    """The vertex nearest to where the mesh is seen at a place of the region, if it is."""
    into = obj.matrix_world.inverted_safe()
    origin = into @ view3d_utils.region_2d_to_origin_3d(region, view, place)
    direction = into.to_3x3() @ view3d_utils.region_2d_to_vector_3d(region, view, place)
    hit, where, *_ = obj.ray_cast(origin, direction.normalized(), depsgraph=depsgraph)
    return handles.nearest_vertex(obj, where, depsgraph) if hit else None


def _holds(region: bpy.types.Region, event: Event) -> bool:
    return (
        0 <= event.mouse_x - region.x < region.width
        and 0 <= event.mouse_y - region.y < region.height
    )


CLASSES = (TUG_OT_click_handles,)
