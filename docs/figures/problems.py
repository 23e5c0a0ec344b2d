# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures pose: a sample scene as arrays, with weights and groups, and the methods made
from it. Nothing here draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np
from project import (
    METHODS,
    Dictionary,
    Functions,
    Mesh,
    Model,
    Rows,
    Sample,
    Solver,
    make_functions,
)


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
    functions: Functions

    @classmethod
    def of(cls, sample: Sample, handles: Sequence[str] = ()) -> Self:
        """A scene with the handles of these names, or all. A flat scene becomes two-dimensional."""
        shapes = np.stack(list(sample.shapes.values()))
        if not shapes[:, :, 2].any():
            shapes = shapes[:, :, :2]
        vertices = np.array([sample.handles[name] for name in handles or sample.handles])
        triangles = sample.triangles()
        with Mesh(shapes[0], triangles) as mesh:
            functions = make_functions(Dictionary.HANDLES, mesh, shapes, vertices)
        return cls(sample, shapes, triangles, vertices, functions)

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
                self.functions.weights,
                Rows.pin(self.handles),
                self.functions.groups,
            ) as model,
        ):
            return Solver(model, **options)

    def peer(self, name: str, **options: float) -> Method:
        """One of baselines.METHODS."""
        weights, groups = self.functions.weights, self.functions.groups
        return METHODS[name](self.shapes, self.triangles, self.handles, weights, groups, **options)


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
