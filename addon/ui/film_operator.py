# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that write every frame to a file: one frame at a time in a window, so that it shows how
far they are and Esc cancels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Context, Event, Object

from . import state
from .rig_operator import EXPECTED, RigOperator

PERIOD = 0.001  # seconds: the next frame follows at once


class FilmOperator(RigOperator):
    doing = "Writing"

    filepath: StringProperty(name="File", description="A .pc2 file", subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.pc2", options={"HIDDEN"})
    first: IntProperty(name="Start Frame", default=1)
    last: IntProperty(name="End Frame", default=250)

    def roll(self, obj: Object) -> Iterator[tuple[str, float]]:
        """A frame each time it is asked for the next, with what it was and how much is done."""
        raise NotImplementedError

    def invoke(self, context: Context, _event: Event) -> set[str]:
        obj, scene = state.rig_of(context), context.scene
        self.first, self.last = scene.frame_start, scene.frame_end
        folder = "//" if bpy.data.filepath else bpy.app.tempdir
        self.filepath = f"{folder}{bpy.path.clean_name(obj.name)}.pc2"
        if bpy.app.background:
            return self.execute(context)
        self._beside = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> set[str]:
        obj = state.rig_of(context)
        try:
            self._name, self._frames = obj.name, self.roll(obj)
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if getattr(self, "_beside", False):
            window_manager = context.window_manager
            self._timer = window_manager.event_timer_add(PERIOD, window=context.window)
            window_manager.progress_begin(0, 100)
            window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        try:
            with closing(self._frames) as frames:
                for _ in frames:
                    pass
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._succeed()

    def modal(self, context: Context, event: Event) -> set[str]:
        """Nothing else happens meanwhile: the scene is at one frame after the other."""
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, f'"{self._name}": cancelled, nothing was written')
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            stage, fraction = next(self._frames)
        except StopIteration:
            self._end(context)
            return self._succeed()
        except EXPECTED as error:
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.window_manager.progress_update(100 * fraction)
        context.workspace.status_text_set(
            f"{self.doing} {self._name}: {fraction:.0%}, {stage}     Esc: Cancel"
        )
        return {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        self._frames.close()
        self._end(context)

    def _end(self, context: Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _succeed(self) -> set[str]:
        count = self.last - self.first + 1
        self.report({"INFO"}, f"{count} frames written to {bpy.path.abspath(self.filepath)}")
        return {"FINISHED"}
