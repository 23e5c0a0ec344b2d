# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on FBT's tables: table_1, times of its forms; table_2, how near its dictionaries come to a
pose with more and more examples, and what these cost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from data import ExampleSet
from library import (
    Form,
    Mesh,
    Model,
    Rows,
    Solver,
    cluster_by_eigenfunctions,
    cluster_triangles,
    compute_eigenfunctions,
    find_skeleton,
    fit_dictionary,
)
from quality import surface_area
from rows_time import along_paths
from suite import HANDLES, Row, Suite, compare, not_run
from timing import position_seconds, solve_seconds

PAPER = "FBT as published"
FORMS = (Form.CLOSEST, Form.AVERAGE, Form.MINIMAL)
ROUNDS, FEWER_ROUNDS = 10, 2  # of a full run, and what is left out where one round is timed
FRAMES, REPEATS = 8, 5

FUNCTIONS, GROUPS = 15, 20  # of Table 2's dictionaries; its other sizes follow
MOST_EXAMPLES = 8
SETS = ("cat", "lion", "horse", "tosca-dog", "cactus")
DICTIONARIES = ("eigenfunctions", "skeleton", "one example")
# Milliseconds of Table 2, by number of examples.
PAPER_ITERATION = (0.72, 0.82, 0.90, 0.99, 1.05, 1.15, 1.33, 1.47)
PAPER_FULL = (9.6, 11.7, 13.3, 14.8, 17.1, 18.2, 21.6, 23.8)


@dataclass(frozen=True)
class Class:
    """A line of Table 1; times in milliseconds."""

    groups: int
    atoms: int
    examples: int
    iteration: float
    full: float

    @property
    def functions(self) -> int:
        """So many that the dictionary of all their products has the nearest size."""
        return round(self.atoms / (1 + 3 * self.examples))


TABLE_1 = {
    "tosca-cat": Class(22, 148, 6, 1.2, 15.3),
    "tosca-dog": Class(25, 136, 4, 1.0, 13.9),
    "tosca-wolf": Class(14, 82, 2, 0.7, 10.3),
    "tosca-centaur": Class(31, 166, 5, 1.2, 16.3),
    "horse": Class(26, 139, 4, 1.1, 14.7),
    "hand": Class(18, 163, 7, 1.2, 15.5),
}


def round_milliseconds(model: Model, form: Form, frames: np.ndarray) -> tuple[float, float, float]:
    """Medians over the frames: of one round, of a solve of ROUNDS, and of its positions."""
    times = []
    for rounds in (FEWER_ROUNDS, ROUNDS):
        with Solver(model, form=form, max_rounds=rounds, tolerance=1e-300) as solver:
            times.append(1e3 * solve_seconds(solver, frames, REPEATS))
            positions = 1e3 * float(np.median(position_seconds(solver, 20)))
    each = (times[1] - times[0]) / (ROUNDS - FEWER_ROUNDS)
    return float(np.median(each)), float(np.median(times[1])), positions


def table_1_rows(suite: Suite) -> Iterator[Row]:
    """A round, and a run of ten with cold start and positions, of each form."""
    name = "table_1"
    ratios: dict[str, list[float]] = {}
    for chosen in suite.chosen(TABLE_1):
        line = TABLE_1[chosen]
        poses = suite.load(chosen).first(line.examples)
        handles = poses.spread_handles(HANDLES)
        with Mesh(poses.shapes[0], poses.triangles) as mesh:
            values, functions, _ = compute_eigenfunctions(mesh, line.functions)
            groups = cluster_by_eigenfunctions(mesh, values, functions, line.groups)
            model = Model(mesh, poses.shapes, functions, Rows.pin(handles), groups)
        frames = along_paths(poses, handles, FRAMES)
        for form in FORMS:
            each, solve, positions = round_milliseconds(model, form, frames)
            sizes = vars(model.sizes) | {"set": chosen, "form": form.name.lower()}
            sizes |= {"published_atoms": line.atoms, "positions_ms": positions}
            times = {"a round": (each, line.iteration), "a run": (solve + positions, line.full)}
            for what, (ours, published) in times.items():
                metric = f"{what}, {form.name.lower()}, {chosen}"
                yield compare(name, metric, "ms", ours, PAPER, published, None, sizes)
                ratios.setdefault(what, []).append(published / ours)
        model.close()
    if not ratios:
        yield not_run(name, f"none of {', '.join(TABLE_1)} is among the sets")
    for what, found in ratios.items():
        yield Row(name, f"{what}, times faster than published, the least", "", min(found))


@dataclass(frozen=True)
class Dictionaries:
    """Weights on a rest shape: #V by some."""

    functions: np.ndarray  # eigenfunctions, as many as the dictionary of one example needs
    bones: np.ndarray

    def of(self, name: str, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Shapes and weights of a dictionary of some examples: of equal sizes, but where the
        examples have fewer bones or the mesh too few vertices."""
        if name == "skeleton":
            return shapes, self.bones
        if name == "eigenfunctions":
            return shapes, self.functions[:, :FUNCTIONS]
        return shapes[:1], self.functions[:, : round(atom_count(shapes, FUNCTIONS) / 4)]


def atom_count(shapes: np.ndarray, functions: int) -> int:
    return functions * (1 + 3 * len(shapes))


def find_dictionaries(poses: ExampleSet, examples: np.ndarray) -> Dictionaries:
    """Bones are those of all examples, whatever is then made of the first few."""
    most = round(atom_count(examples, FUNCTIONS) / 4)
    with Mesh(examples[0], poses.triangles) as mesh:
        _, functions, _ = compute_eigenfunctions(mesh, most)
        bones, _ = find_skeleton(mesh, examples, FUNCTIONS)
    return Dictionaries(functions, bones)


def distortions(poses: ExampleSet, pose: int) -> np.ndarray:
    """Of the pose in the dictionaries of the first examples among the others, nearest to it in the
    sense of least squares: DICTIONARIES by numbers of examples. In percent of the root of its area,
    at the vertex farthest off."""
    truth, others = poses.shapes[pose], np.delete(poses.shapes, pose, axis=0)
    found = find_dictionaries(poses, others)
    root = np.sqrt(surface_area(truth, poses.triangles))
    result = np.empty((len(DICTIONARIES), len(others)))
    for row, name in enumerate(DICTIONARIES):
        for column in range(len(others)):
            shapes, weights = found.of(name, others[: column + 1])
            _, fitted = fit_dictionary(np.ascontiguousarray(shapes), weights, truth)
            farthest = np.linalg.norm(fitted - truth, axis=1).max()
            result[row, column] = 100 * farthest / root
    return result


def example_times(poses: ExampleSet) -> tuple[np.ndarray, int]:
    """With the skeleton of all examples and the first of them, 1 to all: milliseconds of a round
    with the closest shape, of one with every shape, and of a run with its positions; and how many
    bones there are."""
    examples = poses.shapes[:MOST_EXAMPLES]
    handles = poses.spread_handles(HANDLES)
    times = []
    with Mesh(examples[0], poses.triangles) as mesh:
        bones, _ = find_skeleton(mesh, examples, FUNCTIONS)
        groups = cluster_triangles(mesh, bones, GROUPS)
        frames = along_paths(poses, handles, FRAMES)
        for count in range(1, len(examples) + 1):
            with Model(mesh, examples[:count], bones, Rows.pin(handles), groups) as model:
                closest, solve, positions = round_milliseconds(model, Form.CLOSEST, frames)
                every, _, _ = round_milliseconds(model, Form.MINIMAL, frames)
            times.append((closest, every, solve + positions))
    return np.array(times).T, bones.shape[1]


def table_2_rows(suite: Suite) -> Iterator[Row]:
    """Distortions and times by number of examples."""
    name = "table_2"
    rises, growths = 0, []
    for chosen in suite.chosen(SETS):
        poses = suite.load(chosen).first(MOST_EXAMPLES + 1)
        targets = range(2 if suite.quick else len(poses.shapes))
        found = list(suite.map(distortions, [(poses, pose) for pose in targets]))
        mean = np.mean(found, axis=0)
        for dictionary, values in zip(DICTIONARIES, mean, strict=True):
            sizes = {"set": chosen, "dictionary": dictionary, "poses": len(targets)}
            metric = f"distortion with {len(values)} examples, {dictionary}, {chosen}"
            sizes |= {"by_examples": values.tolist()}
            yield Row(name, metric, "%", float(values[-1]), sizes=sizes)
            rises += int(values[-1] >= values[0])
        (closest, every, run), bones = example_times(poses)
        sizes = {"set": chosen, "bones": bones, "groups": GROUPS}
        for metric, values, published in (
            ("a round with the closest shape", closest, PAPER_ITERATION),
            ("a round with every shape", every, PAPER_ITERATION),
            ("a run", run, PAPER_FULL),
        ):
            metric = f"{metric}, {len(values)} examples, {chosen}"
            yield compare(
                *(name, metric, "ms", float(values[-1]), PAPER, published[len(values) - 1], None),
                sizes | {"by_examples": values.tolist()},
            )
        growths.append(closest[-1] / closest[0])
    if not growths:
        yield not_run(name, f"none of {', '.join(SETS)} is among the sets")
        return
    metric = "dictionaries that come no nearer with all examples than with one"
    yield Row(name, metric, "", rises)
    metric = "a round with the closest shape, from one example to all, grows by at most"
    yield Row(name, metric, "", float(max(growths)))
