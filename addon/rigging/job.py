# SPDX-License-Identifier: GPL-3.0-or-later
"""The long part of a bind, between reading the scene and writing it: nothing here touches Blender,
so that it may run on any thread."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from ..geometry import Mesh
from ..native import Progress, TugError, part
from ..parts import find_floating
from ..solver import SolveInfo
from . import functions
from .inputs import Inputs, RigError
from .live import Live, Pull, Recipe


@dataclass(frozen=True)
class Built:
    """recipe: with the functions as they will be stored; seconds: for those, model and solve."""

    recipe: Recipe
    live: Live
    pose: np.ndarray
    info: SolveInfo
    warnings: str
    seconds: list[float]


@dataclass
class Job:
    """Everything that the bind of one object reads, and then what it built.

    identity: of the object. examples: names of keys, Basis first. recipe: its `stored` is None
    where the functions are to be computed.
    """

    name: str
    identity: int
    examples: list[str]
    recipe: Recipe
    follow_nearest: bool
    pull: Pull
    built: Built | None = None

    @property
    def given(self) -> Inputs:
        return self.recipe.given

    @property
    def computes(self) -> bool:
        return self.recipe.stored is None

    def build(self, progress: Progress | None = None) -> None:
        """Everything that takes time or may fail. An exception that `progress` raises cancels."""
        try:
            self.built = self._built(progress)
        except TugError as error:
            raise RigError(f'"{self.name}" cannot be bound: {error.reason}') from error

    def agrees_with(self, other: Job) -> bool:
        """Whether both build the same, wherever the handles are pulled to."""
        return self._content() == other._content()

    def _content(self) -> tuple:
        recipe, options = self.recipe, sorted(self.recipe.options.items())
        settings = recipe.dictionary, options, self.follow_nearest
        return self.identity, self.examples, recipe.digest(), settings

    def _built(self, progress: Progress | None) -> Built:
        given, times = self.given, [time.perf_counter()]
        with Mesh(given.solved_shapes[0], given.triangles) as mesh:
            report = mesh.check()
            if report.errors:
                raise RigError(f'"{self.name}" cannot be bound:\n{report.text}')
            recipe = self.recipe
            if self.computes:
                stored = functions.compute(
                    *(recipe.dictionary, mesh, given, recipe.group_count),
                    follow_nearest=self.follow_nearest,
                    progress=part(progress, 0.0, 0.6),
                )
                recipe = replace(recipe, stored=stored)
            times.append(time.perf_counter())
            self._check_held(mesh, recipe.stored.weights)
            live = recipe.make(mesh, part(progress, 0.6, 1.0))
        times.append(time.perf_counter())
        pose, info = live.pose(self.pull)
        times.append(time.perf_counter())
        return Built(recipe, live, pose, info, report.text, np.diff(times).tolist())

    def _check_held(self, mesh: Mesh, weights: np.ndarray) -> None:
        vertex = find_floating(mesh, weights, self.given.handles)
        if vertex >= 0:
            raise RigError(
                f'"{self.name}" cannot be bound: the part with vertex {vertex} has no handle: put '
                "one on it, or switch on Loose Parts Follow"
            )
