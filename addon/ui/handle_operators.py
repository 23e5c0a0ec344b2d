# SPDX-License-Identifier: GPL-3.0-or-later
"""Add, select, mirror, move and delete handles."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty
from bpy.types import Context, Object, Operator
from mathutils import Vector

from ..rigging import handles
from ..rigging.inputs import RigError
from . import state
from .rig_operator import RigOperator

MOST_AT_ONCE = 100  # vertices of a selection
ADDING = (state.local, state.keys, state.out_of_edit_mode)


class TUG_OT_add_handles(RigOperator, Operator):
    """Spread handles evenly over the mesh"""

    bl_idname = "tug.add_handles"
    bl_label = "Add Handles Automatically"
    needs = ADDING

    count: IntProperty(
        name="Count", description="How many handles to add", default=10, min=1, soft_max=50, max=500
    )

    def act(self, _context: Context, obj: Object) -> str:
        return told(handles.add_spread(obj, self.count))


class TUG_OT_add_handles_on_bones(RigOperator, Operator):
    """Add a handle for every deforming bone of the mesh's armature, on the surface around it"""

    bl_idname = "tug.add_handles_on_bones"
    bl_label = "Add Handles on Bones"

    @staticmethod
    def armature(obj: Object) -> str:
        return "" if handles.armature_of(obj) else "Add an Armature modifier first"

    needs = (*ADDING, armature)

    def act(self, _context: Context, obj: Object) -> str:
        return told(handles.add_on_bones(obj))


class TUG_OT_add_handles_on_vertices(RigOperator, Operator):
    """Add a handle on each selected vertex, or one in the middle of them"""

    bl_idname = "tug.add_handles_on_vertices"
    bl_label = "Add Handles on Selected Vertices"
    needs = (state.local, state.keys, state.edit_mode)

    where: EnumProperty(
        name="Where",
        items=(
            ("EACH", "On Each", "A handle on every selected vertex"),
            ("MIDDLE", "In the Middle", "One handle on the vertex in the middle of the selection"),
        ),
    )

    def act(self, _context: Context, obj: Object) -> str:
        with out_of_edit_mode():
            chosen = selected_vertices(obj)
            if self.where == "MIDDLE":
                chosen = [middle_of(obj, chosen)]
            if len(chosen) > MOST_AT_ONCE:
                raise RigError(
                    f"{len(chosen)} vertices are selected: select at most {MOST_AT_ONCE}, or add "
                    "one handle in the middle"
                )
            return told(handles.add_on(obj, chosen))


class TUG_OT_put_handle(RigOperator, Operator):
    """Let the active handle hold the selected vertex instead of its own"""

    bl_idname = "tug.put_handle"
    bl_label = "Hold Selected Vertex"
    needs = (state.local, state.keys, state.handles, state.edit_mode)

    def act(self, _context: Context, obj: Object) -> None:
        with out_of_edit_mode():
            chosen = selected_vertices(obj)
            handles.put_on(obj, active_handle(obj), middle_of(obj, chosen))


class TUG_OT_mirror_handles(RigOperator, Operator):
    """Give every handle at a side a partner at the other, and both names that end in .L and .R"""

    bl_idname = "tug.mirror_handles"
    bl_label = "Add Mirrored Handles"
    needs = (*ADDING, state.handles)

    def act(self, _context: Context, obj: Object) -> str:
        return told(handles.add_mirrored(obj))


class TUG_OT_select_handles(RigOperator, Operator):
    """Select handles in the viewport. Shift adds to what is selected"""

    bl_idname = "tug.select_handles"
    bl_label = "Select Handles"
    needs = (state.handles,)

    index: IntProperty(
        name="Handle", description="Its number in the list; -1 for all", default=-1, min=-1
    )
    extend: BoolProperty(name="Extend", description="Keep what is selected", default=False)

    def invoke(self, context: Context, event: bpy.types.Event) -> set[str]:
        self.extend = event.shift
        return self.execute(context)

    def act(self, context: Context, obj: Object) -> None:
        leave_mode(context)
        chosen = obj.tug.handles if self.index < 0 else [obj.tug.handles[self.index]]
        empties = [handle.empty for handle in chosen if handle.empty is not None]
        if not self.extend:
            for other in context.selected_objects:
                other.select_set(False)
        for empty in empties:
            if empty.name in context.view_layer.objects:
                empty.select_set(True)
                context.view_layer.objects.active = empty


class TUG_OT_delete_handle(RigOperator, Operator):
    """Delete the active handle. A bound mesh has to be bound again"""

    bl_idname = "tug.delete_handle"
    bl_label = "Delete Handle"
    needs = (state.local, state.handles)

    def act(self, context: Context, obj: Object) -> None:
        handle = active_handle(obj)
        if context.object == handle.empty:
            context.view_layer.objects.active = obj
        handles.delete(obj, list(obj.tug.handles).index(handle))
        obj.tug.active_handle = min(obj.tug.active_handle, max(len(obj.tug.handles) - 1, 0))


class TUG_OT_make_handles_own(RigOperator, Operator):
    """Give this mesh handles of its own instead of those it shares with the one it is a copy of"""

    bl_idname = "tug.make_handles_own"
    bl_label = "Make Own Handles"

    @staticmethod
    def sharing(obj: Object) -> str:
        return "" if handles.sharing(obj) else "The handles are not shared with another mesh"

    needs = (state.local, state.handles, sharing)

    def act(self, _context: Context, obj: Object) -> None:
        handles.make_own(obj)


class out_of_edit_mode:  # noqa: N801, as it is used as a statement
    """Object Mode for as long as it takes: there the mesh has what was edited."""

    def __enter__(self) -> None:
        bpy.ops.object.mode_set(mode="OBJECT")

    def __exit__(self, *_: object) -> None:
        bpy.ops.object.mode_set(mode="EDIT")


def leave_mode(context: Context) -> None:
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def selected_vertices(obj: Object) -> list[int]:
    chosen = [vertex.index for vertex in obj.data.vertices if vertex.select]
    if not chosen:
        raise RigError("select vertices first")
    return chosen


def middle_of(obj: Object, vertices: list[int]) -> int:
    points = {vertex: obj.data.vertices[vertex].co for vertex in vertices}
    middle = sum(points.values(), Vector()) / len(points)
    return min(points, key=lambda vertex: (points[vertex] - middle).length)


def active_handle(obj: Object) -> bpy.types.PropertyGroup:
    number = obj.tug.active_handle
    if not 0 <= number < len(obj.tug.handles):
        raise RigError("choose a handle in the list first")
    return obj.tug.handles[number]


def told(added: list[Object]) -> str:
    return f"{len(added)} handles added" if len(added) != 1 else f"{added[0].name} added"


CLASSES = (
    TUG_OT_add_handles,
    TUG_OT_add_handles_on_bones,
    TUG_OT_add_handles_on_vertices,
    TUG_OT_put_handle,
    TUG_OT_mirror_handles,
    TUG_OT_select_handles,
    TUG_OT_delete_handle,
    TUG_OT_make_handles_own,
)
