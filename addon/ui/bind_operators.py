# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind and unbind."""

from __future__ import annotations

import threading

import bpy
from bpy.types import Context, Event, Operator

from .. import rig
from ..inputs import RigError
from ..job import Job
from ..native import LibraryError
from . import state

PERIOD = 0.05  # seconds between two looks at the work


class CancelledError(Exception):
    """The artist pressed Esc."""


class Work(threading.Thread):
    """Builds a job off the main thread; `stage` and `fraction` say how far it is."""

    def __init__(self, job: Job) -> None:
        super().__init__(name="Tug bind", daemon=True)
        self.job, self.stage, self.fraction = job, "", 0.0
        self.problem: Exception | None = None
        self._cancelled = threading.Event()

    def run(self) -> None:
        try:
            self.job.build(self._progress)
        except (RigError, LibraryError, CancelledError, ValueError, MemoryError) as error:
            self.problem = error

    def cancel(self) -> None:
        self._cancelled.set()

    def _progress(self, stage: str, fraction: float) -> None:
        self.stage, self.fraction = stage, fraction
        if self._cancelled.is_set():
            raise CancelledError


# What runs now, so that Tug is not taken away from under it.
_running: list[Work] = []


class TUG_OT_bind(Operator):
    """Tie the mesh to its handles: from then on it follows them. Takes a second or more; Esc \
cancels"""

    bl_idname = "tug.bind"
    bl_label = "Bind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return state.can_bind(cls, context)

    def execute(self, context: Context) -> set[str]:
        window_manager = context.window_manager
        window_manager.progress_begin(0, 100)
        try:
            summary = rig.bind(
                context.object, lambda _, done: window_manager.progress_update(100 * done)
            )
        except (RigError, LibraryError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            window_manager.progress_end()
        self._tell(summary)
        return {"FINISHED"}

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        try:
            job = rig.plan_bind(context.object)
        except RigError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._work = Work(job)
        _running.append(self._work)
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
        work = self._work
        context.window_manager.progress_update(100 * work.fraction)
        context.workspace.status_text_set(
            f"Tug binds {work.job.name}: {work.fraction:.0%}, {work.stage}     Esc: Cancel"
        )

    def _end(self, context: Context) -> None:
        self._work.join()
        _running.remove(self._work)
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self) -> set[str]:
        job, problem = self._work.job, self._work.problem
        if isinstance(problem, CancelledError):
            self.report({"INFO"}, f'"{job.name}" was not bound: cancelled')
            return {"CANCELLED"}
        try:
            if problem is not None:
                raise problem
            obj = state.find(job.identity)
            if obj is None:
                raise RigError(f'"{job.name}" was deleted while it was being bound')
            summary = rig.finish_bind(obj, job)
        except (RigError, LibraryError, ValueError, MemoryError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._tell(summary)
        return {"FINISHED"}

    def _tell(self, summary: rig.BindSummary) -> None:
        if summary.warnings:
            self.report({"WARNING"}, summary.warnings)
        self.report(
            {"INFO"}, f"Bound: {summary.handles} handles, {summary.shapes - 1} example shapes"
        )


class TUG_OT_unbind(Operator):
    """Let go of the handles: the shape keys show again as before. Handles and weights stay"""

    bl_idname = "tug.unbind"
    bl_label = "Unbind"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return state.is_bound(cls, context)

    def execute(self, context: Context) -> set[str]:
        rig.unbind(context.object)
        return {"FINISHED"}


CLASSES = (TUG_OT_bind, TUG_OT_unbind)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for work in _running:
        work.cancel()
    for work in _running:
        work.join()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
