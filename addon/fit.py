# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the examples of a rig to a scan or to tracked points, once or for every frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from . import film, live, pc2, rig, shape_keys
from .geometry import Mesh
from .inputs import RigError
from .native import Progress, TugError
from .registration.body import Body
from .registration.features import Features
from .registration.nonrigid import Settings, register
from .targets import Place, Target, find_pairs, read_features, read_scan


@dataclass(frozen=True)
class FitSummary:
    """How a fit ended. covered: the part of the object's area that has a match in the target;
    distance: root mean square between matches, in the space of the object. All but the number of
    features are zero where the target has nothing but empties."""

    features: int
    points: int = 0
    covered: float = 0.0
    distance: float = 0.0
    rounds: int = 0
    converged: bool = True


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
    fit starts from the pose that the handles have now. On an error nothing has changed.
    """
    fitter = _Fitter(obj, target, pairs, settings)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    positions, summary = fitter.pose(depsgraph, progress)
    rig.show(obj, positions, depsgraph)
    return summary


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
    fitter = _Fitter(obj, target, pairs, settings)
    paths = {obj: path}
    return film.shoot(paths, first, last, lambda _, writer: _Film(fitter, writer), progress)[0]


class _Fitter:
    """One rig and one target, at any frame."""

    def __init__(
        self,
        obj: bpy.types.Object,
        target: Target,
        pairs: Mapping[str | int, Place] | None,
        settings: Settings | None,
    ) -> None:
        if target == obj:
            raise RigError(f'"{obj.name}" cannot be fitted to itself')
        live.touch(obj)
        live.current(obj, bpy.context.scene)  # raises where the rig is stale
        self.obj, self.target, self.settings = obj, target, settings
        self.pairs = find_pairs(obj, target) if pairs is None else pairs
        if not self.pairs and isinstance(target, bpy.types.Collection):
            names = ", ".join(handle.name for handle in obj.tug.handles)
            raise RigError(
                f'no empty of the collection "{target.name}" has the name of a handle of '
                f'"{obj.name}": {names}'
            )
        with self._explaining():
            self.body = _body(obj)

    def pose(
        self, depsgraph: bpy.types.Depsgraph, progress: Progress | None = None
    ) -> tuple[np.ndarray, FitSummary]:
        """#V by 3 in the space of the object. Writes nothing."""
        with self._explaining():
            scan = None
            if isinstance(self.target, bpy.types.Object):
                scan = read_scan(self.obj, self.target, depsgraph)
            vertices, places = read_features(self.obj, self.pairs, scan, depsgraph)
            features = Features.at_points(vertices, places) if self.pairs else None
            if scan is None:
                return features.pose(self.body, np.inf), FitSummary(len(vertices))
            settings = self.settings or Settings(
                angle=None if scan.normals is None else Settings.angle
            )
            start = None if features else rig.positions(self.obj, depsgraph)
            found = register(
                self.body, scan, features, start=start, settings=settings, progress=progress
            )
        return found.positions, FitSummary(
            features=len(vertices),
            points=len(scan.points),
            covered=found.covered,
            distance=found.distance,
            rounds=found.rounds,
            converged=found.converged,
        )

    @contextmanager
    def _explaining(self) -> Iterator[None]:
        try:
            yield
        except (ValueError, TugError) as error:
            reason = error.reason if isinstance(error, TugError) else error
            names = f'"{self.obj.name}" cannot be fitted to "{self.target.name}"'
            raise RigError(f"{names}: {reason}") from error


class _Film:
    def __init__(self, fitter: _Fitter, writer: pc2.Writer) -> None:
        self.fitter, self.writer = fitter, writer

    def visit(self, depsgraph: bpy.types.Depsgraph) -> None:
        obj = self.fitter.obj
        positions, _ = self.fitter.pose(depsgraph)
        self.writer.write(positions + shape_keys.added_on_top(obj, obj.tug.result))


def _body(obj: bpy.types.Object) -> Body:
    """The rig with its own functions and energy."""
    recipe = live.read(obj)
    given = recipe.given
    if len(given.axes) < 3:
        raise ValueError("its shapes are flat, and only shapes in space can be fitted")
    with Mesh(given.solved_shapes[0], given.triangles) as mesh:
        functions = recipe.stored.functions(mesh, recipe.group_count)
    return Body(
        *(given.solved_shapes, given.triangles, functions),
        stiffness=given.stiffness,
        **recipe.options,
    )
