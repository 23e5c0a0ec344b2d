# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on completion and registration: F's Figure 7, on the animals and people that there are."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from completion import DISTANCES, ON_BONES, OURS, PEER, Experiment, Outcome, bodies, fit
from data import load
from library import Body, Dictionary, Features, Form, Mesh, make_functions
from methods import NO_PEERS, peers
from suite import Row, Suite, not_run

# Sets with nine poses or more, in turn. The people's poses were made by skinning.
COLLECTIONS = {
    "tosca": ("tosca-cat", "tosca-dog"),
    "animals": ("lion", "cat", "horse"),
    "people": ("makehuman-poses",),
}
EXPERIMENTS = 50
PAIRED = 10  # of them, in which every energy on every dictionary is tried as well
KINDS = (Dictionary.EIGENFUNCTIONS, Dictionary.SKELETON)
ENERGIES = {
    "average": Form.AVERAGE,
    "minimal": Form.MINIMAL,
    "closest": Form.CLOSEST,
}


def completion_rows(suite: Suite) -> Iterator[Row]:
    """Every method on every collection, then what all collections say together."""
    if not peers():
        yield not_run("completion", NO_PEERS)
        return
    curves: dict[str, dict[str, list[Outcome]]] = {}
    for collection, names in COLLECTIONS.items():
        chosen = suite.chosen(names)
        if not chosen:
            continue
        count, paired = (3, 1) if suite.quick else (EXPERIMENTS, PAIRED)
        jobs = [
            (suite.folder, chosen[seed % len(chosen)], seed, seed < paired) for seed in range(count)
        ]
        found = curves[collection] = {}
        for outcomes in suite.map(examine, jobs):
            for method, outcome in outcomes.items():
                found.setdefault(method, []).append(outcome)
        yield from method_rows(collection, found)
    if curves:
        yield from summary_rows(curves)
    else:
        yield not_run("completion", "the folder has no set with nine poses that is used here")


def examine(folder: Path, name: str, seed: int, paired: bool) -> dict[str, Outcome]:
    """One experiment, by all methods."""
    poses = load(folder, name)
    experiment = Experiment.draw(poses.shapes, poses.triangles, np.random.default_rng(seed))
    with Mesh(experiment.examples[0], poses.triangles) as mesh:
        functions = {kind: make_functions(kind, mesh, experiment.examples, ()) for kind in KINDS}
    made = bodies(experiment, *functions.values())
    features = experiment.discs(made[OURS[0]])
    found = {method: fit(experiment, body, features)[0] for method, body in made.items()}
    if paired:
        for kind in KINDS:
            own = OURS[-1] if kind == Dictionary.EIGENFUNCTIONS else ON_BONES
            found[f"steady, {kind.lower()}"] = found[own]
            found.update(pairs(experiment, made[own], features, kind.lower()))
    return found


def pairs(
    experiment: Experiment, body: Body, features: Features, dictionary: str
) -> Iterator[tuple[str, Outcome]]:
    """The other energies on the body's dictionary; the paper's own also from its own start."""
    for energy, form in ENERGIES.items():
        body.options = {"form": form}
        yield f"{energy}, {dictionary}", fit(experiment, body, features)[0]
    yield (
        f"{energy}, {dictionary}, sparse start",
        fit(experiment, body, features, sparse=True)[0],
    )


def method_rows(collection: str, found: dict[str, list[Outcome]]) -> Iterator[Row]:
    """A row for each method, with its curves."""
    for method, outcomes in found.items():
        sizes = {
            "collection": collection,
            "method": method,
            "experiments": len(outcomes),
            "start": float(np.mean([outcome.start for outcome in outcomes])),
            "seconds": float(np.median([outcome.seconds for outcome in outcomes])),
            "distances": DISTANCES.tolist(),
            "completed": mean_curve([outcome.completed for outcome in outcomes]),
            "registered": mean_curve([outcome.registered for outcome in outcomes]),
        }
        metric = f"mean distance from the truth, {collection}, {method}"
        error = float(np.mean([outcome.error for outcome in outcomes]))
        yield Row("completion", metric, "roots of the area", error, sizes=sizes)


def mean_curve(curves: list[np.ndarray]) -> list[float]:
    return np.mean(curves, axis=0).round(5).tolist()


def summary_rows(curves: dict[str, dict[str, list[Outcome]]]) -> Iterator[Row]:
    """Whether more examples are better, and Tug better than its peer: by the means of the curves,
    the least gain in any collection."""
    for what in ("completed", "registered"):
        height = {
            (collection, method): float(np.mean([getattr(one, what) for one in outcomes]))
            for collection, found in curves.items()
            for method, outcomes in found.items()
        }
        rises = [height[c, b] - height[c, a] for c in curves for a, b in pairwise(OURS)]
        leads = {
            f"lead of {method} over {PEER}": [height[c, method] - height[c, PEER] for c in curves]
            for method in (OURS[0], OURS[-1])
        }
        for gain, values in {"rise from fewer to more examples": rises, **leads}.items():
            yield Row("completion", f"{what}: least {gain}", "of the curve's mean", min(values))
