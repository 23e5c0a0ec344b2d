# SPDX-License-Identifier: GPL-3.0-or-later
"""What FBT's figures fit, and its way from a few points to a pose: a start by the elastic net
(F 23) on four eigenfunctions, that small dictionary, then bones that the examples show (F 24)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from project import (
    Body,
    Dictionary,
    Form,
    Functions,
    Mesh,
    Rows,
    RowStart,
    Sample,
    compute_eigenfunctions,
    make_functions,
)

SMALL = 4  # eigenfunctions of the first dictionary
SMOOTHNESS = 1e-3
SPARSITY = 1e-4
MAX_ROUNDS = 1000


@dataclass(frozen=True)
class Task:
    """Find `truth` (#V by 3), a pose that is not among the examples (#S by #V by 3), from a few of
    its vertices, which are `size` times as far apart as there."""

    sample: Sample
    names: tuple[str, ...]
    examples: np.ndarray
    truth: np.ndarray
    features: np.ndarray
    size: float = 1.0

    @classmethod
    def of(
        cls, sample: Sample, examples: Sequence[str], truth: np.ndarray, count: int, size: float = 1
    ) -> Self:
        """The features are the farthest points of the first example."""
        shapes = np.stack([sample.shapes[name] for name in examples])
        with Mesh(shapes[0], sample.triangles()) as mesh:
            features = mesh.spread(count)
        return cls(sample, tuple(examples), shapes, truth, features, size)

    @property
    def targets(self) -> np.ndarray:
        """#N by 3."""
        return self.size * self.truth[self.features]

    @cached_property
    def triangles(self) -> np.ndarray:
        return self.sample.triangles()

    @cached_property
    def unit(self) -> float:
        """The root of the area of the truth, in the examples' size."""
        with Mesh(self.truth, self.triangles) as mesh:
            return float(np.sqrt(mesh.areas().sum()))

    def error(self, positions: np.ndarray) -> dict[str, float]:
        """Distances from the truth in parts of the root of its area: FBT's is the largest."""
        apart = np.linalg.norm(positions / self.size - self.truth, axis=1) / self.unit
        return {"mean": float(apart.mean()), "largest": float(apart.max())}


@dataclass(frozen=True)
class Found:
    """A pose, and how large the shapes are in it."""

    positions: np.ndarray
    scale: float


class Stages:
    """FBT's steps for examples of a task and its features.

    The last step runs to the end with every shape. With a number of rounds it goes by the paper's
    schedule instead, as the first does, and ends where that many rounds have brought it.
    """

    def __init__(
        self,
        task: Task,
        *,
        examples: np.ndarray | None = None,
        sparsity: float = SPARSITY,
        scale: bool = True,
        rounds: int = 0,
    ) -> None:
        shapes = task.examples if examples is None else examples
        rows = Rows.pin(task.features)
        with Mesh(shapes[0], task.triangles) as mesh:
            # One shape shows no bones: those of all the task's examples serve then too.
            rich = make_functions(Dictionary.SKELETON, mesh, task.examples, ())
            values, functions, _ = compute_eigenfunctions(mesh, SMALL)
        small = Functions(functions, rich.groups)
        schedule = {"form": Form.CLOSEST, "scale": int(scale), "max_rounds": rounds or MAX_ROUNDS}
        to_the_end = schedule if rounds else schedule | {"form": Form.MINIMAL}
        first = Body(shapes, task.triangles, small, smoothness=SMOOTHNESS, **schedule)
        self.body = Body(shapes, task.triangles, rich, **to_the_end)
        self.start = RowStart(
            *(first.mesh, shapes, functions, values**2, rows, rich.groups), sparsity=sparsity
        )
        self.solvers = [first.solver(rows), self.body.solver(rows)]

    def solve(self, targets: np.ndarray) -> Found:
        first, last = self.solvers
        first.solve(targets, self.start.rotations(targets))
        last.solve(targets, first.rotations())
        return Found(last.positions(), last.scale())
