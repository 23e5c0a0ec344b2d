# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures pose: a sample scene as arrays, with weights and groups, and the methods made
from it. Nothing here draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np
from project import METHODS, Binding, Mesh, Model, Rows, Sample, Solver, bind


class Method(Protocol):
    """Tug's Solver, or one of the comparison systems."""

    def solve(self, targets: np.ndarray) -> object: ...

    def positions(self) -> np.ndarray: ...

    def blend(self) -> np.ndarray: ...


@dataclass(frozen=True)
class Problem:
    """Shapes (#S by #V by k, the rest shape first), triangles (#F by 3), handle vertices (#H)."""

    sample: Sample
    shapes: np.ndarray
    triangles: np.ndarray
    handles: np.ndarray
    binding: Binding

    @classmethod
    def of(cls, sample: Sample, handles: Sequence[str] = ()) -> Self:
        """A scene with the handles of these names, or all. A flat scene becomes two-dimensional."""
        shapes = np.stack(list(sample.shapes.values()))
        if not shapes[:, :, 2].any():
            shapes = shapes[:, :, :2]
        vertices = np.array([sample.handles[name] for name in handles or sample.handles])
        triangles = sample.triangles()
        return cls(sample, shapes, triangles, vertices, bind(shapes[0], triangles, vertices))

    @cached_property
    def diagonal(self) -> float:
        """Of the rest shape's bounding box."""
        return float(np.linalg.norm(np.ptp(self.shapes[0], axis=0)))

    def number(self, shape: str) -> int:
        """Which of the shapes has this name."""
        return list(self.sample.shapes).index(shape)

    def shape(self, name: str) -> np.ndarray:
        """#V by k."""
        return self.shapes[self.number(name)]

    def targets(self, shape: str) -> np.ndarray:
        """#H by k, the handles where a shape has them."""
        return self.shape(shape)[self.handles]

    def tug(self, **options: float) -> Solver:
        """Tug with options of addon.solver.Solver."""
        with (
            Mesh(self.shapes[0], self.triangles) as mesh,
            Model(
                mesh,
                self.shapes,
                self.binding.weights,
                Rows.pin(self.handles),
                self.binding.groups,
            ) as model,
        ):
            return Solver(model, **options)

    def peer(self, name: str, **options: float) -> Method:
        """One of baselines.METHODS."""
        binding = self.binding
        return METHODS[name](
            self.shapes, self.triangles, self.handles, binding.weights, binding.groups, **options
        )


def mean_blend(method: Method) -> np.ndarray:
    """#S weights of the shapes in the last pose, the mean over groups where they have their own."""
    return np.atleast_2d(method.blend()).mean(axis=0)


def aligned(points: np.ndarray, model: np.ndarray) -> np.ndarray:
    """`points` (#V by k) after the rigid motion that brings them closest to `model`."""
    middle, wanted = points.mean(axis=0), model.mean(axis=0)
    u, _, vt = np.linalg.svd((points - middle).T @ (model - wanted))
    flip = np.ones(len(u))
    flip[-1] = np.sign(np.linalg.det(u @ vt))
    return (points - middle) @ (u * flip @ vt) + wanted


def mean_distance(points: np.ndarray, model: np.ndarray) -> float:
    """Mean distance of the points from those of the same number in `model`, rigidly aligned."""
    return float(np.linalg.norm(aligned(points, model) - model, axis=1).mean())
