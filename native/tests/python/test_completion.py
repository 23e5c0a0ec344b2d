# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmark of completion and registration gives its methods and how it measures them, on
the poses of the sample fox."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from addon import native
from addon.dictionaries import make_functions
from addon.geometry import Mesh
from addon.registration.nonrigid import Registration

sys.path.append(str(Path(__file__).resolve().parents[2] / "bench"))
import baselines  # noqa: E402
import completion  # noqa: E402
from completion import OURS, PEER, Experiment  # noqa: E402
from rows_completion import method_rows, summary_rows  # noqa: E402


@pytest.fixture(scope="module")
def experiment(creature) -> Experiment:
    examples, target = creature.without("Pouncing")
    return Experiment.of(examples, creature.triangles, target, np.random.default_rng(3))


def test_a_bit_more_than_half_is_left_and_all_of_it_around_the_features(creature):
    for seed in range(8):
        target = creature.shapes[seed % len(creature.shapes)]
        random = np.random.default_rng(seed)
        drawn = Experiment.of(creature.shapes, creature.triangles, target, random)
        assert 0.5 < drawn.part < 0.7
        left = np.zeros(len(target), bool)
        left[drawn.vertices] = True
        with Mesh(target, creature.triangles) as mesh:
            near = mesh.distances(drawn.features) <= 0.15 * drawn.unit
        assert left[near].all()
        # Numbers of the scan's points mean nothing.
        assert (np.diff(drawn.vertices) < 0).any()
        # The scan has the triangles of the target, and no point without one.
        assert set(drawn.triangles.ravel()) == set(range(len(drawn.vertices)))
        corners = {tuple(sorted(triangle)) for triangle in drawn.vertices[drawn.triangles].tolist()}
        assert corners <= {tuple(sorted(triangle)) for triangle in creature.triangles.tolist()}


def test_the_target_is_none_of_the_examples_and_a_seed_draws_the_same_again(creature):
    poses = np.concatenate([creature.shapes, creature.shapes[:4] + 1.0])
    one, same, other = (
        Experiment.draw(poses, creature.triangles, np.random.default_rng(seed))
        for seed in (0, 0, 1)
    )
    assert len(one.examples) == 8
    assert np.abs(one.examples - one.target).max(axis=(1, 2)).min() > 0
    np.testing.assert_array_equal(one.vertices, same.vertices)
    np.testing.assert_array_equal(one.examples, same.examples)
    assert len(other.vertices) != len(one.vertices) or (other.vertices != one.vertices).any()


def found_with(experiment: Experiment, vertices: np.ndarray) -> Registration:
    none = np.full(len(experiment.target), -1)
    return Registration(experiment.target, none, vertices, 0.0, 1.0, 1, True)


def test_curves_count_area_and_matches_within_the_distances(experiment):
    np.testing.assert_allclose(experiment.completed(experiment.target), 1)
    part = np.arange(len(experiment.target)) % 3 == 0
    moved = experiment.target + np.outer(part, [0.0301 * experiment.unit, 0, 0])
    far = experiment.areas[part].sum() / experiment.areas.sum()
    inside = completion.DISTANCES >= 0.0301
    expected = np.where(inside, 1, 1 - far)
    np.testing.assert_allclose(experiment.completed(moved), expected)

    right = experiment.registered(found_with(experiment, experiment.vertices))
    np.testing.assert_allclose(right, 1)
    wrong = experiment.vertices.copy()
    wrong[::2] = -1
    unmatched = experiment.registered(found_with(experiment, wrong))
    np.testing.assert_allclose(unmatched, np.mean(wrong >= 0))


def test_shapes_are_turned_to_the_places_that_are_known(experiment):
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    moved = experiment.target @ turn.T + [3, -2, 1]
    back = completion.turned(
        np.stack([moved, experiment.target]), experiment.features, experiment.places
    )
    for shape in back:
        np.testing.assert_allclose(shape, experiment.target, atol=1e-12)


def test_more_examples_are_better_and_better_than_der(experiment):
    try:
        baselines.library()
    except native.LibraryError as error:
        pytest.skip(f"not run: {error}")
    with Mesh(experiment.examples[0], experiment.faces) as mesh:
        functions, bones = (
            make_functions(kind, mesh, experiment.examples, ())
            for kind in ("EIGENFUNCTIONS", "SKELETON")
        )
    made = completion.bodies(experiment, functions, bones)
    features = experiment.discs(made[OURS[0]])
    found = {
        method: completion.fit(experiment, made[method], features)[0]
        for method in (OURS[0], OURS[-1], PEER)
    }
    one, all_, der = found.values()
    for outcome in found.values():
        assert outcome.error < outcome.start
        assert (np.diff(outcome.completed) >= 0).all()
    assert all_.error < min(one.error, der.error)
    assert all_.completed.mean() > max(one.completed.mean(), der.completed.mean())
    assert all_.registered.mean() > max(one.registered.mean(), der.registered.mean())

    outcomes = {name: [found.get(name, all_)] for name in (*OURS, PEER)}
    rows = [*method_rows("fox", outcomes), *summary_rows({"fox": outcomes})]
    values = {row.metric: row.value for row in rows}
    assert values[f"mean distance from the truth, fox, {PEER}"] == der.error
    lead = all_.completed.mean() - der.completed.mean()
    assert values[f"completed: least lead of 8 examples over {PEER}"] == pytest.approx(lead)
