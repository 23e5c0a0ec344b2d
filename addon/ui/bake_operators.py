# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the animation of a rig, and go back to the live rig."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from .. import bake, mesh_cache
from . import state
from .rig_operator import RigOperator


class TUG_OT_bake(RigOperator, Operator):
    """Write every frame to a file that plays back fast and renders safely"""

    bl_idname = "tug.bake"
    bl_label = "Bake Animation"
    bl_options = {"REGISTER", "UNDO"}
    needs = (state.bound, state.out_of_edit_mode, state.up_to_date)

    filepath: StringProperty(name="File", description="A .pc2 file", subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.pc2", options={"HIDDEN"})
    first: IntProperty(name="Start Frame", default=1)
    last: IntProperty(name="End Frame", default=250)
    smoothing: FloatProperty(
        name="Smoothing",
        description="Over how many frames the choice of shape keys is averaged. Handles are met "
        "all the same",
        default=0.0,
        min=0.0,
        soft_max=10.0,
    )

    def invoke(self, context: Context, _event: Event) -> set[str]:
        obj, scene = state.rig_of(context), context.scene
        self.first, self.last = scene.frame_start, scene.frame_end
        folder = "//" if bpy.data.filepath else bpy.app.tempdir
        self.filepath = f"{folder}{bpy.path.clean_name(obj.name)}.pc2"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def act(self, context: Context, obj: Object) -> str:
        window_manager = context.window_manager
        window_manager.progress_begin(0, 100)
        try:
            path = bake.bake(
                *(obj, self.first, self.last, self.filepath),
                lambda _, done: window_manager.progress_update(100 * done),
                smoothing=self.smoothing,
            )
        finally:
            window_manager.progress_end()
        return f"{self.last - self.first + 1} frames baked to {path}"


class TUG_OT_remove_bake(RigOperator, Operator):
    """Take the bake off the mesh: it follows its handles again. The file stays"""

    bl_idname = "tug.remove_bake"
    bl_label = "Remove Bake"
    needs = (state.baked,)

    def act(self, _context: Context, obj: Object) -> None:
        obj.modifiers.remove(obj.modifiers[mesh_cache.NAME])


CLASSES = (TUG_OT_bake, TUG_OT_remove_bake)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
