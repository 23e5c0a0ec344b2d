# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the examples of a rig to a scan or to tracked points, once or for every frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import bpy

from ..caches import film, pc2
from ..native import Progress
from ..registration.nonrigid import Settings
from ..registration.scan import Scan
from ..rigging import live, rig, shape_keys
from ..rigging.inputs import RigError
from .job import FitJob, FitSummary, Sight, explaining
from .targets import Place, Target, find_pairs, read_features, read_scan


def fit(
    obj: bpy.types.Object,
    target: Target,
    pairs: Mapping[str | int, Place] | None = None,
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> FitSummary:
    """Fit a bound rig to a target and write the pose to the result key, where it stays until the
    handles or settings change.

    target: a mesh, a point cloud, or a collection of empties. pairs: names of handles, or vertices,
    and where they are on the target: objects, or points of the target; where they are not given,
    empties below the target, or in the collection, that have the names of handles. Without any, the
    fit starts from the pose that the handles have now. settings: those of the rig where they are
    None. On an error nothing has changed.
    """
    job = plan_fit(obj, target, pairs, settings=settings)
    job.build(progress)
    return finish_fit(obj, job)


def plan_fit(
    obj: bpy.types.Object,
    target: Target,
    pairs: Mapping[str | int, Place] | None = None,
    *,
    settings: Settings | None = None,
) -> FitJob:
    """The first part of a fit: check and read everything, on the main thread. The second, which
    takes the time, is FitJob.build, on any thread; finish_fit is the last."""
    view = _View(obj, target, pairs, settings)
    return view.plan(bpy.context.evaluated_depsgraph_get())


def finish_fit(obj: bpy.types.Object, job: FitJob) -> FitSummary:
    """The last part of a fit: write the pose, on the main thread. Raises RigError, and changes
    nothing, where the object is no longer what was read."""
    if job.pose is None:
        raise ValueError("the job has not been built")
    live.check(obj, bpy.context.scene)
    now = live.read(obj)
    same = (now.digest(), now.options) == (job.recipe.digest(), job.recipe.options)
    if obj.session_uid != job.identity or not same:
        raise RigError(f'"{obj.name}" was edited while it was being fitted: fit it again')
    rig.show(obj, job.pose, bpy.context.evaluated_depsgraph_get())
    return job.summary


def fit_frames(
    obj: bpy.types.Object,
    target: Target,
    first: int,
    last: int,
    path: str | Path,
    pairs: Mapping[str | int, Place] | None = None,
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Path:
    """Fit a rig to the target as it is at each frame from first to last, both included, and write
    the poses to a PC2 file that a modifier then shows, as bake.bake does.

    Every frame is fitted on its own, so that pieces of a range agree with the whole.
    """
    view = _View(obj, target, pairs, settings)
    return film.shoot({obj: path}, first, last, view.film, progress)[0]


def roll_frames(
    obj: bpy.types.Object,
    target: Target,
    first: int,
    last: int,
    path: str | Path,
    pairs: Mapping[str | int, Place] | None = None,
) -> Iterator[tuple[str, float]]:
    """`fit_frames`, a frame each time it is asked for the next: see film.roll."""
    return film.roll({obj: path}, first, last, _View(obj, target, pairs, None).film)


class _View:
    """One rig and one target, to be read at any frame."""

    def __init__(
        self,
        obj: bpy.types.Object,
        target: Target,
        pairs: Mapping[str | int, Place] | None,
        settings: Settings | None,
    ) -> None:
        if target == obj:
            raise RigError(f'"{obj.name}" cannot be fitted to itself')
        live.check(obj, bpy.context.scene)
        self.obj, self.target, self.settings = obj, target, settings
        self.pairs = find_pairs(obj, target) if pairs is None else pairs
        if not self.pairs and isinstance(target, bpy.types.Collection):
            names = ", ".join(handle.name for handle in obj.tug.handles)
            raise RigError(
                f'no empty of the collection "{target.name}" has the name of a handle of '
                f'"{obj.name}": {names}'
            )

    def film(self, _obj: bpy.types.Object, writer: pc2.Writer) -> _Film:
        return _Film(self, writer)

    def plan(self, depsgraph: bpy.types.Depsgraph) -> FitJob:
        return FitJob(
            name=self.obj.name,
            identity=self.obj.session_uid,
            target=self.target.name,
            recipe=live.read(self.obj),
            sight=self.sight(depsgraph),
        )

    def sight(self, depsgraph: bpy.types.Depsgraph) -> Sight:
        with explaining(self.obj.name, self.target.name):
            scan = None
            if isinstance(self.target, bpy.types.Object):
                scan = read_scan(self.obj, self.target, depsgraph)
            vertices, places = read_features(self.obj, self.pairs, scan, depsgraph)
        start = None if vertices else rig.positions(self.obj, depsgraph)
        settings = self.settings or _own_settings(self.obj, scan)
        return Sight(scan, vertices, places, start, settings)


def _own_settings(obj: bpy.types.Object, scan: Scan | None) -> Settings:
    """Those of the rig; normals count where the scan has them."""
    angle = None if scan is None or scan.normals is None else Settings.angle
    # Properties are float32: these are the numbers that were typed.
    reach, firmness = round(obj.tug.fit_reach, 6), round(obj.tug.fit_firmness, 6)
    return Settings(reach=reach, firmness=firmness, angle=angle)


class _Film:
    """A fit of every frame."""

    def __init__(self, view: _View, writer: pc2.Writer) -> None:
        self.view, self.writer = view, writer
        self.job: FitJob | None = None

    def visit(self, depsgraph: bpy.types.Depsgraph) -> None:
        if self.job is None:
            self.job = self.view.plan(depsgraph)
        else:
            self.job.sight = self.view.sight(depsgraph)
        self.job.build()
        obj = self.view.obj
        self.writer.write(self.job.pose + shape_keys.added_on_top(obj, obj.tug.result))
