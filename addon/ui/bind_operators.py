# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind, set up and unbind."""

from __future__ import annotations

from bpy.props import IntProperty
from bpy.types import Context, Object, Operator

from ..rigging import handles, rig
from ..rigging.job import Job
from . import state
from .background import BackgroundOperator
from .rig_operator import RigOperator

BINDING = (state.local, state.keys, state.out_of_edit_mode, state.idle)


class Binding(BackgroundOperator):
    doing, done = "Binding", "bound"

    def plan(self, obj: Object) -> Job:
        return rig.plan_bind(obj)

    def finish(self, obj: Object, job: Job) -> str:
        summary = rig.finish_bind(obj, job)
        if summary.warnings:
            self.report({"WARNING"}, summary.warnings)
        counts = f"{summary.handles} handles, {summary.shapes - 1} examples"
        return f"Bound: {counts}. Pull a handle"


class TUG_OT_bind(Binding, Operator):
    """Tie the mesh to its handles: it follows them from then on. Takes a moment; Esc cancels"""

    bl_idname = "tug.bind"
    bl_label = "Bind"
    needs = (*BINDING, state.two_handles)


class TUG_OT_set_up(Binding, Operator):
    """Spread handles over the mesh and bind it: the quickest way to a mesh that can be posed"""

    bl_idname = "tug.set_up"
    bl_label = "Set Up"
    needs = BINDING

    count: IntProperty(
        name="Handles", description="How many handles to add", default=10, min=2, soft_max=50
    )

    def plan(self, obj: Object) -> Job:
        self._added = [empty.name for empty in handles.add_spread(obj, self.count)]
        return super().plan(obj)

    def revert(self, obj: Object) -> None:
        for name in getattr(self, "_added", ()):
            handles.delete(obj, [handle.title for handle in obj.tug.handles].index(name))


class TUG_OT_unbind(RigOperator, Operator):
    """Let go of the handles: the shape keys show again as before. Handles and weights stay"""

    bl_idname = "tug.unbind"
    bl_label = "Unbind"
    needs = (state.local, state.bound, state.out_of_edit_mode)

    def act(self, _context: Context, obj: Object) -> None:
        rig.unbind(obj)


CLASSES = (TUG_OT_bind, TUG_OT_set_up, TUG_OT_unbind)
