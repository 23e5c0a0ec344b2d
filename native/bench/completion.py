# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape completion and partial registration as in F, section 5 and Figure 7: a pose of which half
is known is found again from other poses of the same body, and is told which point is which.

Lengths are in parts of the root of the target's area.
"""

from __future__ import annotations

import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from baselines import ReducedDeformable
from library import (
    Body,
    Features,
    Functions,
    Mesh,
    Registration,
    Rows,
    RowStart,
    Scan,
    Settings,
    compute_eigenfunctions,
    register,
)

EXAMPLES = 8
FEATURES = 8
RADIUS = 0.15  # of the discs around the features, which are whole
PATCHES = 32  # that the surface is cut into
PART = 0.5  # of the area that is left, and a patch more
COUNTS = (1, 2, 4, EXAMPLES)
OURS = ("1 example", "2 examples", "4 examples", "8 examples")
ON_BONES = "8 examples, skeleton"
PEER = "Der et al. 2006"
SPARSITY = 1e-4  # of the elastic net
DISTANCES = np.linspace(0.0, 0.1, 41)  # where the curves are read


@dataclass(frozen=True)
class Experiment:
    """Examples (8 by #V by 3) in a random order, a target (#V by 3) that is not among them, and
    what is left of it.

    vertices: of the target, which are the points of the scan in its order. triangles: those of the
    scan. features: vertices of the body whose places on the scan are known.
    """

    examples: np.ndarray
    faces: np.ndarray
    target: np.ndarray
    vertices: np.ndarray
    triangles: np.ndarray
    features: np.ndarray

    @classmethod
    def draw(cls, poses: np.ndarray, faces: np.ndarray, random: np.random.Generator) -> Self:
        """From poses of a mesh (nine or more by #V by 3) with these faces (#F by 3)."""
        target, *examples = random.permutation(len(poses))[: 1 + EXAMPLES]
        return cls.of(poses[examples], faces, poses[target], random)

    @classmethod
    def of(
        cls,
        examples: np.ndarray,
        faces: np.ndarray,
        target: np.ndarray,
        random: np.random.Generator,
    ) -> Self:
        """What is left of a target, and the features, at random."""
        with Mesh(target, faces) as mesh:
            # What is farthest from some vertex: paws, the tip of the tail, the nose.
            features = mesh.spread(1 + FEATURES, int(random.integers(mesh.vertex_count)))[1:]
            left = left_over(mesh, features, random)
        vertices = random.permutation(np.flatnonzero(left))
        number = np.full(len(target), -1)
        number[vertices] = np.arange(len(vertices))
        triangles = number[faces]
        triangles = triangles[(triangles >= 0).all(axis=1)].astype(np.int32)
        return cls(examples, faces, target, vertices, triangles, features)

    @cached_property
    def areas(self) -> np.ndarray:
        """#V, of the whole target."""
        with Mesh(self.target, self.faces) as mesh:
            return mesh.areas()

    @property
    def unit(self) -> float:
        return float(np.sqrt(self.areas.sum()))

    @property
    def part(self) -> float:
        """Of the area that is left."""
        return float(self.areas[self.vertices].sum() / self.areas.sum())

    @cached_property
    def scan(self) -> Scan:
        return Scan.of_mesh(self.target[self.vertices], self.triangles)

    @property
    def places(self) -> np.ndarray:
        """#N by 3, of the features."""
        return self.target[self.features]

    def discs(self, body: Body) -> Features:
        """The features with their discs, on a body whose rest shape is the first example."""
        point = np.full(len(self.target), -1)
        point[self.vertices] = np.arange(len(self.vertices))
        return Features.at_discs(
            body, self.features, self.scan, point[self.features], radius=RADIUS
        )

    def errors(self, positions: np.ndarray) -> np.ndarray:
        """#V, how far each vertex is from the truth."""
        return np.linalg.norm(positions - self.target, axis=1) / self.unit

    def mean_error(self, positions: np.ndarray) -> float:
        return float(self.areas @ self.errors(positions) / self.areas.sum())

    def completed(self, positions: np.ndarray) -> np.ndarray:
        """The parts of the surface that are within the DISTANCES of the truth."""
        errors = self.errors(positions)
        return np.array([self.areas[errors <= reach].sum() for reach in DISTANCES]) / self.unit**2

    def registered(self, found: Registration) -> np.ndarray:
        """The parts of the scan's points whose vertex is, on the target, within the DISTANCES of
        the true one. A point without a vertex is within none."""
        apart = self.target[found.vertices] - self.target[self.vertices]
        errors = np.linalg.norm(apart, axis=1) / self.unit
        errors[found.vertices < 0] = np.inf
        return np.array([np.mean(errors <= reach) for reach in DISTANCES])


def left_over(mesh: Mesh, features: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """#V, whether a vertex is left: what is around the features with all its triangles, and patches
    in a random order until more than half of the area is there. None is without a triangle."""
    areas, triangles = mesh.areas(), mesh.triangles
    left = mesh.distances(features) <= RADIUS * np.sqrt(areas.sum())
    left[triangles[left[triangles].any(axis=1)]] = True
    centres = mesh.spread(PATCHES, int(random.integers(mesh.vertex_count)))
    patch = mesh.nearest_sources(centres)
    for number in random.permutation(PATCHES):
        if areas[left].sum() > PART * areas.sum():
            break
        left |= patch == number
    whole = triangles[left[triangles].all(axis=1)]
    return np.bincount(whole.ravel(), minlength=mesh.vertex_count) > 0


class ReducedDeformableBody(Body):
    """Der et al. 2006 in place of Tug: the first example skinned, gradients blended of all."""

    def __init__(self, examples: np.ndarray, faces: np.ndarray, functions: Functions) -> None:
        super().__init__(examples[:1], faces, functions)
        self._method = ReducedDeformable(examples, faces, [0], functions.weights, functions.groups)

    def solver(
        self, rows: Rows, firmness: np.ndarray | None = None
    ) -> AbstractContextManager[ReducedDeformable]:
        self._method.change_rows(rows, firmness)
        return nullcontext(self._method)


def turned(shapes: np.ndarray, vertices: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The shapes (#S by #V by 3), each moved rigidly so that the vertices are nearest to the places
    (#N by 3): a blend of gradients knows no other turn than those of the shapes."""
    moved, wanted = np.empty_like(shapes), places - places.mean(axis=0)
    for number, shape in enumerate(shapes):
        middle = shape[vertices].mean(axis=0)
        u, _, vt = np.linalg.svd((shape[vertices] - middle).T @ wanted)
        u[:, -1] *= np.sign(np.linalg.det(u @ vt))
        moved[number] = (shape - middle) @ (u @ vt) + places.mean(axis=0)
    return moved


def sparse_start(body: Body, features: Features, firmness: float) -> np.ndarray:
    """#V by 3: the pose of the features' rows found from the elastic net (F 23) on four
    eigenfunctions."""
    values, functions, _ = compute_eigenfunctions(body.mesh, 4)
    start = RowStart(
        *(body.mesh, body.shapes, functions, values**2, features.rows, body.functions.groups),
        sparsity=SPARSITY,
    )
    with body.solver(features.rows, np.full(len(features.rows), firmness)) as solver:
        solver.solve(features.targets, start.rotations(features.targets))
        return solver.positions()


@dataclass(frozen=True)
class Outcome:
    """Of one method in one experiment.

    error: mean distance of the surface from the truth; start: that before the registration.
    completed, registered: the curves. seconds: of the processor, for the first pose and the
    registration, once the body is there.
    """

    error: float
    start: float
    completed: np.ndarray
    registered: np.ndarray
    rounds: int
    seconds: float


def fit(
    experiment: Experiment, body: Body, features: Features, *, sparse: bool = False
) -> tuple[Outcome, np.ndarray]:
    """The body posed by the features and registered; and its positions, #V by 3."""
    firmness, before = Settings().features, time.process_time()
    start = sparse_start(body, features, firmness) if sparse else features.pose(body, firmness)
    found = register(body, experiment.scan, features, start=start)
    outcome = Outcome(
        error=experiment.mean_error(found.positions),
        start=experiment.mean_error(start),
        completed=experiment.completed(found.positions),
        registered=experiment.registered(found),
        rounds=found.rounds,
        seconds=time.process_time() - before,
    )
    return outcome, found.positions


def bodies(experiment: Experiment, eigenfunctions: Functions, bones: Functions) -> dict[str, Body]:
    """What Figure 7 compares: Tug with some of the examples; with all on bones; and Der's method
    with all on the same bones."""
    examples, faces = experiment.examples, experiment.faces
    ours = {
        name: Body(examples[:count], faces, eigenfunctions)
        for name, count in zip(OURS, COUNTS, strict=True)
    }
    there = turned(examples, experiment.features, experiment.places)
    return {
        **ours,
        ON_BONES: Body(examples, faces, bones),
        PEER: ReducedDeformableBody(there, faces, bones),
    }
