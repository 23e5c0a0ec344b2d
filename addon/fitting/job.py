# SPDX-License-Identifier: GPL-3.0-or-later
"""The long part of a fit, between reading the scene and writing it: nothing here touches Blender,
so that it may run on any thread."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ..geometry import Mesh
from ..native import Progress, TugError, part
from ..registration.body import Body
from ..registration.features import Features
from ..registration.nonrigid import Settings, register
from ..registration.scan import Scan
from ..rigging.inputs import RigError
from ..rigging.live import Recipe


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


@dataclass(frozen=True)
class Sight:
    """What is known of a target at one frame, in the space of the object: its points, or None for
    empties alone; features, vertices and their places, #N by 3; start: #V by 3, where there are
    none; how points and vertices find each other."""

    scan: Scan | None
    vertices: list[int]
    places: np.ndarray
    start: np.ndarray | None
    settings: Settings


@dataclass
class FitJob:
    """One rig and one target, and then the pose, #V by 3 in the space of the object.

    identity: of the object; target: a name. Another sight may be put in place of the first: what
    does not depend on it is built once.
    """

    name: str
    identity: int
    target: str
    recipe: Recipe
    sight: Sight
    pose: np.ndarray | None = None
    summary: FitSummary | None = None
    body: Body | None = None

    def build(self, progress: Progress | None = None) -> None:
        """Everything that takes time. An exception that `progress` raises cancels."""
        with explaining(self.name, self.target):
            if self.body is None:
                self.body = _body(self.recipe, part(progress, 0.0, 0.3))
            self._fit(part(progress, 0.3, 1.0))

    def _fit(self, progress: Progress | None) -> None:
        sight, scan, count = self.sight, self.sight.scan, len(self.sight.vertices)
        features = Features.at_points(sight.vertices, sight.places) if count else None
        if scan is None:
            self.pose, self.summary = features.pose(self.body, np.inf), FitSummary(count)
            return
        found = register(
            *(self.body, scan, features),
            start=sight.start,
            settings=sight.settings,
            progress=progress,
        )
        self.pose = found.positions
        self.summary = FitSummary(
            features=count,
            points=len(scan.points),
            covered=found.covered,
            distance=found.distance,
            rounds=found.rounds,
            converged=found.converged,
        )


@contextmanager
def explaining(name: str, target: str) -> Iterator[None]:
    """Errors of a fit in the words of an artist."""
    try:
        yield
    except (ValueError, TugError) as error:
        reason = error.reason if isinstance(error, TugError) else error
        raise RigError(f'"{name}" cannot be fitted to "{target}": {reason}') from error


def _body(recipe: Recipe, progress: Progress | None) -> Body:
    """The rig with its own functions and energy."""
    given = recipe.given
    if len(given.axes) < 3:
        raise ValueError("its shapes are flat, and only shapes in space can be fitted")
    with Mesh(given.solved_shapes[0], given.triangles) as mesh:
        functions = recipe.stored.functions(mesh, recipe.group_count, part(progress, 0.0, 0.3))
    return Body(
        *(given.solved_shapes, given.triangles, functions),
        stiffness=given.stiffness,
        progress=part(progress, 0.3, 1.0),
        **recipe.options,
    )
