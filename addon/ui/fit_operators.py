# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit a rig to a scan, a cloud of points or tracked empties: as they are now, or at every frame."""

from __future__ import annotations

from collections.abc import Iterator

from bpy.types import Object, Operator

from ..fitting import fit, targets
from ..fitting.job import FitJob
from . import state
from .background import BackgroundOperator
from .film_operator import FilmOperator


def has_target(obj: Object) -> str:
    if targets.chosen(obj) is None:
        return "Choose a target first: a scan, or a collection of empties"
    return ""


FITTING = (
    state.local,
    state.bound,
    state.out_of_edit_mode,
    state.up_to_date,
    state.idle,
    has_target,
)


class TUG_OT_fit(BackgroundOperator, Operator):
    """Bring the examples together so that the mesh lies on the target. Handles stay where they \
are: pull one to pose the mesh by hand again"""

    bl_idname = "tug.fit"
    bl_label = "Fit Examples to Target"
    needs = FITTING
    doing, done = "Fitting", "fitted"

    def plan(self, obj: Object) -> FitJob:
        return fit.plan_fit(obj, targets.chosen(obj), targets.chosen_pairs(obj))

    def finish(self, obj: Object, job: FitJob) -> str:
        summary = fit.finish_fit(obj, job)
        if not summary.points:
            return f"Fitted to {summary.features} empties"
        if not summary.converged:
            self.report({"WARNING"}, "The fit has not settled: pull the handles nearer and again")
        covered, distance = summary.covered, summary.distance
        return f"Fitted: {covered:.0%} of the mesh lies on the target, {distance:.3g} away"


class TUG_OT_fit_frames(FilmOperator, Operator):
    """Fit every frame to the target as it is then, and write the poses to a file that plays back"""

    bl_idname = "tug.fit_frames"
    bl_label = "Fit to Animated Target"
    needs = FITTING
    doing = "Fitting"

    def roll(self, obj: Object) -> Iterator[tuple[str, float]]:
        return fit.roll_frames(
            *(obj, targets.chosen(obj), self.first, self.last, self.filepath),
            targets.chosen_pairs(obj),
        )


CLASSES = (TUG_OT_fit, TUG_OT_fit_frames)
