# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on what few points of a pose tell: how large it is (F's Figures 3 and 4), and which foot is
which (Figure 5). Examples are poses far from each other; all other poses are looked for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from data import ExampleSet
from library import Body, Dictionary, Form, Mesh, Rows, find_correspondence, make_functions
from suite import Row, Suite, not_run

SCALES = {"tosca-dog": (4, 1.5), "hand": (7, 0.7)}  # examples, and the size of what is looked for
SCALE_FEATURES = (6, 40)
MAX_ROUNDS = 1000
FEET_SET, FEET_FEATURES, FEET = "horse", 8, (1, 3, 4, 5)  # of the farthest points on the horse
FORMS = {"steady": Form.STEADY, "minimal": Form.MINIMAL}


def scale_rows(suite: Suite) -> Iterator[Row]:
    """Of the minimal form on bones: it tries every example, so that no start counts. Beside alpha
    of the energy, by how much the pose's area is larger than the example's that it is nearest to:
    alpha is too small wherever edges are turned otherwise than their group."""
    names = suite.chosen(SCALES)
    if not names:
        yield not_run("scale", f"the folder has none of {', '.join(SCALES)} that this run uses")
    for name in names:
        count, size = SCALES[name]
        poses = suite.load(name)
        examples, others = choose(poses, count)
        for features in SCALE_FEATURES:
            by_alpha, by_area = scale_errors(poses, examples, others, features, size)
            sizes = {"set": name, "examples": count, "features": features, "size": size}
            title = f"{features} points of {name} {size} times as large as {count} examples"
            for what, value in (
                ("an example's alpha", by_alpha[:count].max()),
                (f"alpha of {len(others)} other poses, median", np.median(by_alpha[count:])),
                (f"alpha of {len(others)} other poses, largest", by_alpha[count:].max()),
                (f"area of {len(others)} other poses, median", np.median(by_area[count:])),
                (f"area of {len(others)} other poses, largest", by_area[count:].max()),
            ):
                metric = f"error of {what}, {title}"
                yield Row("scale", metric, "", float(value), sizes=sizes)


def scale_errors(
    poses: ExampleSet, examples: list[int], others: list[int], features: int, size: float
) -> np.ndarray:
    """2 by #P: how far scales by alpha and by area are from the true one, in parts of it, for the
    examples and then the others."""
    shapes = poses.shapes[examples]
    with Mesh(shapes[0], poses.triangles) as mesh:
        vertices = mesh.spread(features)
        bones = make_functions(Dictionary.SKELETON, mesh, shapes, vertices)
    body = Body(shapes, poses.triangles, bones, form=Form.MINIMAL, scale=1, max_rounds=MAX_ROUNDS)
    areas, scales = [area(poses, shape) for shape in shapes], []
    with body.solver(Rows.pin(vertices)) as solver:
        for number in (*examples, *others):
            solver.solve(size * poses.shapes[number][vertices])
            nearest = int(solver.blend()[0].argmax())
            by_area = np.sqrt(area(poses, solver.positions()) / areas[nearest])
            scales.append((solver.scale(), by_area))
    return np.abs(np.array(scales).T / size - 1)


def area(poses: ExampleSet, positions: np.ndarray) -> float:
    with Mesh(positions, poses.triangles) as mesh:
        return float(mesh.areas().sum())


def correspondence_rows(suite: Suite) -> Iterator[Row]:
    """Poses of which the right one of the 24 matchings of the feet has the least objective, from
    four examples and from all other poses."""
    if not suite.chosen([FEET_SET]):
        yield not_run("correspondence", f"the folder has no set {FEET_SET} that this run uses")
        return
    poses = suite.load(FEET_SET)
    count = len(poses.shapes)
    four, others = choose(poses, 4)
    tasks = {
        "4 examples": [(four, others)],
        "all other poses": [
            ([other for other in range(count) if other != number], [number])
            for number in range(count)
        ],
    }
    for name, form in FORMS.items():
        for label, pairs in tasks.items():
            told = [solved for pair in pairs for solved in told_apart(poses, *pair, form)]
            yield Row(
                "correspondence",
                f"poses of the {FEET_SET} whose feet are told apart, {name} form, {label}",
                f"of {len(told)}",
                float(sum(told)),
                sizes={"set": FEET_SET, "features": FEET_FEATURES, "poses": len(told)},
            )


def told_apart(
    poses: ExampleSet, examples: list[int], others: list[int], form: Form
) -> Iterator[bool]:
    """For each of the others."""
    features = poses.spread_handles(FEET_FEATURES)
    shuffle = np.arange(FEET_FEATURES)
    shuffle[list(FEET)] = np.roll(FEET, 1)
    body = Body(poses.shapes[examples], poses.triangles, form=form)
    with body.solver(Rows.pin(features)) as solver:
        for number in others:
            points = poses.shapes[number][features]
            found = find_correspondence(solver, points[shuffle], [FEET])
            yield np.array_equal(shuffle[found.order], np.arange(FEET_FEATURES))


def choose(poses: ExampleSet, count: int) -> tuple[list[int], list[int]]:
    """Numbers of so many poses, from the first on each the farthest from those before it, and of
    all others."""
    chosen = [0]
    distances = distances_to(poses.shapes, 0)
    while len(chosen) < count:
        chosen.append(int(np.argmax(distances)))
        distances = np.minimum(distances, distances_to(poses.shapes, chosen[-1]))
    return chosen, [number for number in range(len(poses.shapes)) if number not in chosen]


def distances_to(shapes: np.ndarray, number: int) -> np.ndarray:
    """Of all poses from one, each turned and moved as near to it as that brings it."""
    centred = shapes - shapes.mean(axis=1, keepdims=True)
    u, spread, vt = np.linalg.svd(np.swapaxes(centred, 1, 2) @ centred[number])
    spread[:, -1] *= np.linalg.det(u @ vt)
    squares = np.sum(centred**2, axis=(1, 2))
    return np.sqrt(np.maximum(squares + squares[number] - 2 * spread.sum(axis=1), 0))
