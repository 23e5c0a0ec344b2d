# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 6: a fox that looks aside, found from three examples that do not and a part of its
surface, by eight features first and nonrigid ICP then."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fitting import Task
from project import Body, Features, Mesh, Registration, Scan, Settings, creature, register

EXAMPLES = ("Basis", "Stretched", "Stepping")
POSE, FEATURES = "Looking Left", 8
RADIUS = 0.15  # of a disc around each feature, which is whole, in parts of the root of the area
HOLES, HOLE = 6, 0.175  # how many pieces are missing, and how far each reaches from its middle
NEAR = 0.02  # a match is right up to this
VIEW = (48, 12)


@dataclass(frozen=True)
class Completion:
    """vertices: of the target, those of the scan in order. triangles: the scan's. start: the pose
    by the features."""

    task: Task
    vertices: np.ndarray
    triangles: np.ndarray
    start: np.ndarray
    found: Registration


def measure() -> Completion:
    fox = creature.sample()
    task = Task.of(fox, EXAMPLES, fox.shapes[POSE], FEATURES)
    vertices, triangles = partial_scan(task)
    body = Body(task.examples, task.triangles)
    scan = Scan.of_mesh(task.truth[vertices], triangles)
    points = np.searchsorted(vertices, task.features)
    features = Features.at_discs(body, task.features, scan, points, radius=RADIUS)
    start = features.pose(body, Settings().features)
    return Completion(task, vertices, triangles, start, register(body, scan, features))


def partial_scan(task: Task) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles that are left without the pieces around points far from the features,
    and from each other."""
    with Mesh(task.truth, task.triangles) as mesh:
        kept = mesh.distances(task.features) <= RADIUS * task.unit
        missing = np.zeros(len(kept), bool)
        middles: list[int] = list(task.features)
        for _ in range(HOLES):
            middles.append(int(np.argmax(mesh.distances(middles))))
            missing |= mesh.distances(middles[-1:]) <= HOLE * task.unit
    left = kept | ~missing
    triangles = task.triangles[left[task.triangles].all(axis=1)]
    vertices, numbers = np.unique(triangles, return_inverse=True)
    return vertices, numbers.reshape(-1, 3).astype(np.int32)


def numbers(done: Completion) -> dict[str, float]:
    """The part of the area that is left; mean and largest distance from the truth before and after
    ICP, in parts of the root of the area; the parts of the matches that are right up to NEAR."""
    task, found = done.task, done.found
    with Mesh(task.truth, task.triangles) as mesh:
        areas = mesh.areas()
    some = np.flatnonzero(found.points >= 0)
    apart = task.truth[done.vertices[found.points[some]]] - task.truth[some]
    right = np.linalg.norm(apart, axis=1) <= NEAR * task.unit
    return {
        "part": float(areas[done.vertices].sum() / areas.sum()),
        "start": task.error(done.start),
        "final": task.error(found.positions),
        "matches_right": float(right.mean()),
        "rounds": found.rounds,
    }


def draw(done: Completion, path: Path) -> None:
    from drawing import Camera
    from strips import STONE, Panel, Strip
    from strips import draw as draw_strips

    task = done.task
    solid = {"triangles": task.triangles, "colors": task.sample.colors}
    stone = np.tile(STONE, (len(task.truth), 1))
    errors = [100 * task.error(shape)["mean"] for shape in (done.start, done.found.positions)]
    left = task.truth[done.vertices]
    panels = [
        *(
            Panel(name, shape, **solid, boxed=True)
            for name, shape in zip(task.names, task.examples, strict=True)
        ),
        Panel("target", task.truth, task.triangles, stone),
        Panel("what is scanned", left, done.triangles, stone[: len(left)], task.targets),
        Panel(f"by 8 features\n{errors[0]:.1f} % off", done.start, **solid),
        Panel(f"after ICP\n{errors[1]:.1f} % off", done.found.positions, **solid),
    ]
    draw_strips([Strip(Camera(*VIEW), panels)], path)
