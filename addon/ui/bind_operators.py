# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind, set up and unbind."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Event, Object, Operator

from .. import handles, rig
from ..inputs import RigError
from . import state, work
from .rig_operator import EXPECTED, RigOperator
from .work import CancelledError, Work

BINDING = (state.local, state.keys, state.out_of_edit_mode, state.not_binding)
PERIOD = 0.05  # seconds between two looks at the work


class Binding(RigOperator):
    """In a window the work runs beside it; in the background, or called as a function, the call
    returns when it is done."""

    def prepare(self, obj: Object) -> None:
        """What comes before a bind; undone by `revert` if there is none."""

    def revert(self, obj: Object) -> None:
        pass

    def execute(self, context: Context) -> set[str]:
        obj, window_manager = state.rig_of(context), context.window_manager
        window_manager.progress_begin(0, 100)
        try:
            self.prepare(obj)
            summary = rig.bind(obj, lambda _, done: window_manager.progress_update(100 * done))
        except EXPECTED as error:
            return self._fail(obj, error)
        finally:
            window_manager.progress_end()
        return self._succeed(summary)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        obj = state.rig_of(context)
        try:
            self.prepare(obj)
            self._work = Work(rig.plan_bind(obj))
        except EXPECTED as error:
            return self._fail(obj, error)
        self._work.start()
        window_manager = context.window_manager
        self._timer = window_manager.event_timer_add(PERIOD, window=context.window)
        window_manager.progress_begin(0, 100)
        window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC":
            self._work.cancel()
            return {"RUNNING_MODAL"}
        if event.type == "Z" and event.ctrl:  # undone meanwhile, there is nothing to finish
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._work.is_alive():
            self._show_progress(context)
            return {"PASS_THROUGH"}
        self._end(context)
        return self._finish()

    def cancel(self, context: Context) -> None:
        self._work.cancel()
        self._end(context)

    def _show_progress(self, context: Context) -> None:
        name, stage, fraction = self._work.job.name, self._work.stage, self._work.fraction
        context.window_manager.progress_update(100 * fraction)
        context.workspace.status_text_set(f"Binding {name}: {fraction:.0%}, {stage}    Esc: Cancel")
        redraw(context)

    def _end(self, context: Context) -> None:
        self._work.end()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        redraw(context)

    def _finish(self) -> set[str]:
        job, problem = self._work.job, self._work.problem
        obj = state.find(job.identity)
        try:
            if problem is not None:
                raise problem
            if obj is None:
                raise RigError(f'"{job.name}" was deleted while it was being bound')
            summary = rig.finish_bind(obj, job)
        except CancelledError:
            return self._fail(obj, f'"{job.name}" was not bound: cancelled', kind="INFO")
        except EXPECTED as error:
            return self._fail(obj, error)
        return self._succeed(summary)

    def _fail(self, obj: Object | None, reason: object, kind: str = "ERROR") -> set[str]:
        if obj is not None:
            self.revert(obj)
        self.report({kind}, str(reason))
        return {"CANCELLED"}

    def _succeed(self, summary: rig.BindSummary) -> set[str]:
        if summary.warnings:
            self.report({"WARNING"}, summary.warnings)
        counts = f"{summary.handles} handles, {summary.shapes - 1} examples"
        self.report({"INFO"}, f"Bound: {counts}. Pull a handle")
        return {"FINISHED"}


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

    def prepare(self, obj: Object) -> None:
        self._added = [empty.name for empty in handles.add_spread(obj, self.count)]

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


def redraw(context: Context) -> None:
    """The sidebars, which show how far it is."""
    for area in context.window.screen.areas:
        if area.type == "VIEW_3D":
            for region in area.regions:
                if region.type == "UI":
                    region.tag_redraw()


CLASSES = (TUG_OT_bind, TUG_OT_set_up, TUG_OT_unbind)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    work.cancel_all()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
