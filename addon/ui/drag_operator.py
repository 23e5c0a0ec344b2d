# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that pulls a handle by the mouse."""

from __future__ import annotations

from typing import ClassVar

import bpy
from bpy.props import FloatVectorProperty, StringProperty
from mathutils import Vector

from ..native import LibraryError
from ..rigging import live
from ..rigging.inputs import RigError
from .drag import Drag
from .overlay_drag import DragOverlay
from .picking import bound_rigs, handle_at
from .pull import AXES, Pull

KEYS = "X Y Z: Axis    Shift X Y Z: Plane    Shift: Precise    Esc: Cancel"


class TUG_OT_drag(bpy.types.Operator):
    """Pull a handle of a bound mesh, which follows"""

    bl_idname = "tug.drag"
    bl_label = "Drag Handle"
    bl_options: ClassVar = {"REGISTER", "UNDO", "BLOCKING"}

    handle: StringProperty(name="Handle", description="Name of the empty", options={"HIDDEN"})
    offset: FloatVectorProperty(
        name="Offset", description="How far it is pulled", subtype="TRANSLATION", size=3
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Handles are dragged in Object Mode")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = _rig_of(self.handle, context.scene)
        if obj is None:
            self.report({"ERROR"}, f'No bound mesh has a handle "{self.handle}"')
            return {"CANCELLED"}
        try:
            drag = Drag(context, obj, bpy.data.objects[self.handle])
            try:
                drag.pull(Vector(self.offset))
            except BaseException:
                drag.restore()
                raise
        except (RigError, LibraryError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        drag.finish(context)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type != "LEFTMOUSE" or context.region_data is None:  # from a menu or the search
            bpy.ops.wm.tool_set_by_id(name="tug.drag", space_type="VIEW_3D")
            return {"CANCELLED"}
        picked = handle_at(context, _mouse(context, event))
        if picked is None:
            return {"PASS_THROUGH"}
        try:
            self._drag = Drag(context, picked.obj, picked.empty)
        except RigError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.handle = picked.empty.name
        self._press = _mouse(context, event)
        self._pulled = False
        self._pull = Pull(context.region, context.region_data, self._drag.start, self._press)
        self._overlay = DragOverlay(context.region, self._drag, self._pull)
        self._overlay.show()
        context.window_manager.modal_handler_add(self)
        self._tell(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # Blender would drop the operator and leave the mesh as the exception found it.
        try:
            return self._handle(context, event)
        except Exception as error:
            self.cancel(context)
            expected = isinstance(error, (RigError, LibraryError))
            name = "" if expected else f"{type(error).__name__}: "
            self.report({"ERROR"}, f"{name}{error}")
            return {"CANCELLED"}

    def cancel(self, context: bpy.types.Context) -> None:
        self._leave(context)
        self._drag.restore()

    def _handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "MOUSEMOVE":
            self._move(context, event)
        elif event.type in AXES and event.value == "PRESS":
            self._pull.constrain(event.type, across=event.shift)
            self._apply(context)
        elif event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        elif _is_confirmed(event):
            return self._finish(context)
        elif event.type.startswith("TIMER"):  # playback goes on
            return {"PASS_THROUGH"}
        # INBETWEEN_MOUSEMOVE tells of places the mouse has already left.
        return {"RUNNING_MODAL"}

    def _move(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        mouse = _mouse(context, event)
        threshold = context.preferences.inputs.drag_threshold_mouse
        if not self._pulled and (mouse - self._press).length < threshold:
            return  # a click that shakes
        self._pull.move(mouse, precise=event.shift)
        self._apply(context)

    def _apply(self, context: bpy.types.Context) -> None:
        self._pulled = True
        self._drag.pull(self._pull.offset)
        context.region.tag_redraw()
        self._tell(context)

    def _finish(self, context: bpy.types.Context) -> set[str]:
        if self._pulled:
            self.offset = self._pull.offset
            self._drag.finish(context)
        self._leave(context)
        return {"FINISHED"} if self._pulled or self._drag.selected_anew else {"CANCELLED"}

    def _leave(self, context: bpy.types.Context) -> None:
        self._overlay.hide()
        context.workspace.status_text_set(None)

    def _tell(self, context: bpy.types.Context) -> None:
        """How far the handle is, how long the pose took and whether it is final."""
        moved = self._drag.moved
        parts = [self.handle, _length(context, moved.length)]
        if self._pull.axis:
            parts[1] += f" {'across' if self._pull.across else 'along'} {self._pull.axis}"
        if self._pulled and (last := live.known(self._drag.obj).last):
            parts.append(f"{1e3 * last.seconds:.1f} ms")
            parts.append("converged" if last.info.converged else "not converged")
        context.workspace.status_text_set("    ".join([*parts, KEYS]))


def _rig_of(name: str, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The bound object with an empty of this name as a handle."""
    empty = scene.objects.get(name)
    for obj in bound_rigs(scene):
        if empty is not None and any(handle.empty == empty for handle in obj.tug.handles):
            return obj
    return None


def _is_confirmed(event: bpy.types.Event) -> bool:
    if event.type == "LEFTMOUSE":
        return event.value == "RELEASE"
    return event.type in {"RET", "NUMPAD_ENTER"} and event.value == "PRESS"


def _mouse(context: bpy.types.Context, event: bpy.types.Event) -> Vector:
    region = context.region
    return Vector((event.mouse_x - region.x, event.mouse_y - region.y))


def _length(context: bpy.types.Context, length: float) -> str:
    unit = context.scene.unit_settings
    return bpy.utils.units.to_string(unit.system, "LENGTH", length * unit.scale_length, precision=3)


CLASSES = (TUG_OT_drag,)
