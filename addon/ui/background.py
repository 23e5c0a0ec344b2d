# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators whose work takes long: it runs beside a window that goes on answering, until Esc."""

from __future__ import annotations

import bpy
from bpy.types import Context, Event, Object

from ..rigging.inputs import RigError
from . import state
from .rig_operator import EXPECTED, RigOperator
from .work import Job, Work

PERIOD = 0.05  # seconds between two looks at the work


class BackgroundOperator(RigOperator):
    """In a window the work runs beside it; in the background, or called as a function, the call
    returns when it is done."""

    doing, done = "Working on", "done"  # words for "Binding" something that then is "bound"

    def plan(self, obj: Object) -> Job:
        """What comes before the work, on the main thread; undone by `revert` if there is none."""
        raise NotImplementedError

    def finish(self, obj: Object, job: Job) -> str:
        """What comes after it, on the main thread, and what to tell then."""
        raise NotImplementedError

    def revert(self, obj: Object) -> None:
        pass

    def execute(self, context: Context) -> set[str]:
        obj, window_manager = state.rig_of(context), context.window_manager
        window_manager.progress_begin(0, 100)
        try:
            job = self.plan(obj)
            job.build(lambda _, fraction: window_manager.progress_update(100 * fraction))
            told = self.finish(obj, job)
        except EXPECTED as error:
            return self._fail(obj, error)
        finally:
            window_manager.progress_end()
        return self._succeed(told)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        obj = state.rig_of(context)
        try:
            self._work = Work(self.plan(obj))
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
            self.cancel(context)
            job = self._work.job
            return self._fail(
                state.find(job.identity), f'"{job.name}" was not {self.done}: cancelled', "INFO"
            )
        if event.type == "Z" and event.ctrl:  # undone meanwhile, there is nothing to finish
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._work.is_alive():
            self._show_progress(context)
            return {"PASS_THROUGH"}
        self._work.end()
        self._end(context)
        return self._finish()

    def cancel(self, context: Context) -> None:
        self._work.abandon()
        self._end(context)

    def _show_progress(self, context: Context) -> None:
        name, stage, fraction = self._work.job.name, self._work.stage, self._work.fraction
        context.window_manager.progress_update(100 * fraction)
        context.workspace.status_text_set(
            f"{self.doing} {name}: {fraction:.0%}, {stage}    Esc: Cancel"
        )
        _redraw(context)

    def _end(self, context: Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        _redraw(context)

    def _finish(self) -> set[str]:
        job, problem = self._work.job, self._work.problem
        obj = state.find(job.identity)
        try:
            if problem is not None:
                raise problem
            if obj is None:
                raise RigError(f'"{job.name}" was deleted while it was being {self.done}')
            told = self.finish(obj, job)
        except EXPECTED as error:
            return self._fail(obj, error)
        return self._succeed(told)

    def _fail(self, obj: Object | None, reason: object, kind: str = "ERROR") -> set[str]:
        if obj is not None:
            self.revert(obj)
        self.report({kind}, str(reason))
        return {"CANCELLED"}

    def _succeed(self, told: str) -> set[str]:
        self.report({"INFO"}, told)
        return {"FINISHED"}


def _redraw(context: Context) -> None:
    """The sidebars, which show how far it is."""
    for area in context.window.screen.areas:
        if area.type == "VIEW_3D":
            for region in area.regions:
                if region.type == "UI":
                    region.tag_redraw()
