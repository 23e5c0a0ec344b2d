# SPDX-License-Identifier: GPL-3.0-or-later
"""A body fitted to scans of a pose that is not among its shapes. Errors are in parts of the root of
the body's area; which vertex is which point of the scan is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from addon.dictionaries import functions_of_weights
from addon.geometry import Mesh
from addon.registration.body import Body
from addon.registration.features import Features
from addon.registration.nonrigid import Registration, Settings, register
from addon.registration.scan import Scan
from addon.solver import Form
from addon.weights import compute_weights


@dataclass(frozen=True)
class Case:
    """vertex: of the body, for each point of the scan."""

    body: Body
    truth: np.ndarray
    handles: list[int]
    scan: Scan
    vertex: np.ndarray

    @property
    def unit(self) -> float:
        return np.sqrt(self.body.mesh.areas().sum())

    def features(self) -> Features:
        return Features.at_points(self.handles, self.truth[self.handles])

    def errors(self, positions: np.ndarray) -> np.ndarray:
        return np.linalg.norm(positions - self.truth, axis=1) / self.unit

    def matched(self, found: Registration) -> tuple[float, float]:
        """The parts of the matches of vertices, and of points, that are right up to 2 %."""
        some = np.flatnonzero(found.points >= 0)
        there = self.scan.points[found.points[some]]
        vertices = np.linalg.norm(there - self.truth[some], axis=1) <= 0.02 * self.unit
        some = np.flatnonzero(found.vertices >= 0)
        there = self.truth[found.vertices[some]]
        points = np.linalg.norm(there - self.scan.points[some], axis=1) <= 0.02 * self.unit
        return vertices.mean(), points.mean()


def case(creature, left_out: str, seen_from: np.ndarray | None = None) -> Case:
    """The whole surface in another order, or the part of it that faces a direction."""
    shapes, truth = creature.without(left_out)
    random = np.random.default_rng(0)
    with Mesh(truth, creature.triangles) as mesh:
        normals = mesh.normals(truth)
    seen = np.ones(len(truth), bool) if seen_from is None else normals @ seen_from > -0.2
    vertex = random.permutation(np.flatnonzero(seen))
    number = np.full(len(truth), -1)
    number[vertex] = np.arange(len(vertex))
    triangles = number[creature.triangles]
    triangles = triangles[(triangles >= 0).all(axis=1)]
    scan = Scan.of_mesh(truth[vertex], triangles)
    handles = list(creature.handles.values())
    return Case(Body(shapes, creature.triangles), truth, handles, scan, vertex)


@pytest.fixture(scope="module")
def whole(creature) -> Case:
    return case(creature, "Stretched")


@pytest.fixture(scope="module")
def half(creature) -> Case:
    return case(creature, "Stretched", np.array([0.8, -0.6, 0.0]))


def test_a_whole_scan_is_fitted_and_matched(whole):
    found = register(whole.body, whole.scan, whole.features())
    start = whole.features().pose(whole.body, 10.0)
    assert whole.errors(start).mean() > 0.01
    assert whole.errors(found.positions).mean() < 0.0025
    assert whole.errors(found.positions).max() < 0.02
    assert min(whole.matched(found)) > 0.98
    assert found.converged
    assert found.covered > 0.98
    assert found.distance < 0.01 * whole.unit


def test_half_a_surface_is_completed(half):
    assert len(half.scan.points) < 0.7 * len(half.truth)
    found = register(half.body, half.scan, half.features())
    assert half.errors(found.positions).mean() < 0.006
    of_vertices, of_points = half.matched(found)
    assert of_vertices > 0.9
    assert of_points > 0.97
    # What was not seen has no match, rather than the edge of what was.
    unseen = np.setdiff1d(np.arange(len(half.truth)), half.vertex)
    assert (found.points[unseen] < 0).mean() > 0.95
    inner = half.vertex[~half.scan.edge]
    assert (found.points[inner] >= 0).mean() > 0.95


@pytest.mark.parametrize("left_out", ["Looking Left", "Stepping", "Pouncing"])
def test_rounds_improve_on_what_the_features_tell(creature, left_out):
    given = case(creature, left_out, np.array([-0.6, -0.8, 0.0]))
    start = given.features().pose(given.body, 10.0)
    found = register(given.body, given.scan, given.features())
    assert given.errors(found.positions).mean() < 0.6 * given.errors(start).mean()
    assert given.errors(found.positions).mean() < 0.01


def test_an_example_is_recognised_in_a_part_of_it(creature):
    given = case(creature, "Stretched", np.array([0.0, -1.0, 0.0]))
    body = Body(creature.shapes, creature.triangles)
    found = register(body, given.scan, given.features())
    assert given.errors(found.positions).mean() < 2e-4


def test_noise_is_not_followed(half):
    noise = np.random.default_rng(1).normal(size=half.scan.points.shape) * 0.01 * half.unit
    scan = Scan(half.scan.points + noise, half.scan.normals)
    found = register(half.body, scan, half.features())
    assert half.errors(found.positions).mean() < 0.01


def test_what_does_not_belong_to_the_body_is_left_out(half):
    random = np.random.default_rng(2)
    floor = np.column_stack([random.uniform(-1, 1, (2000, 2)), np.full(2000, -0.02)])
    points = np.concatenate([half.scan.points, floor])
    normals = np.concatenate([half.scan.normals, np.tile([0.0, 0.0, 1.0], (2000, 1))])
    found = register(half.body, Scan(points, normals), half.features())
    assert half.errors(found.positions).mean() < 0.008


def test_a_cloud_with_normals_is_about_as_good_as_a_mesh(half):
    cloud = Scan(half.scan.points, half.scan.normals)
    of_mesh = register(half.body, half.scan, half.features())
    of_cloud = register(half.body, cloud, half.features())
    errors = [half.errors(found.positions).mean() for found in (of_mesh, of_cloud)]
    assert max(errors) < 0.006


def test_a_cloud_without_normals_serves_where_they_are_not_asked_for(whole):
    cloud = Scan(whole.scan.points)
    found = register(whole.body, cloud, whole.features(), settings=Settings(angle=None))
    assert whole.errors(found.positions).mean() < 0.006


def test_discs_around_the_features_tell_more_than_points(creature):
    given = case(creature, "Looking Left")
    number = np.argsort(given.vertex)
    discs = Features.at_discs(given.body, given.handles, given.scan, number[given.handles])
    errors = [
        given.errors(features.pose(given.body, 10.0)).mean()
        for features in (discs, given.features())
    ]
    assert errors[0] < 0.7 * errors[1]


@pytest.mark.parametrize("form", [Form.AVERAGE, Form.MINIMAL, Form.CLOSEST, Form.PAPER])
def test_every_energy_fits(creature, half, form):
    body = Body(half.body.shapes, creature.triangles, form=form)
    found = register(body, half.scan, half.features())
    assert half.errors(found.positions).mean() < 0.01


def test_other_dictionaries_fit(creature, half):
    with Mesh(half.body.rest, creature.triangles) as mesh:
        weights, _ = compute_weights(mesh, [[vertex] for vertex in half.handles])
        functions = functions_of_weights(mesh, weights)
    body = Body(half.body.shapes, creature.triangles, functions, smoothness=1e-3)
    found = register(body, half.scan, half.features())
    assert half.errors(found.positions).mean() < 0.01


@pytest.mark.parametrize("size", [0.7, 1.5])
def test_a_scan_of_another_size_is_fitted_with_a_free_scale(creature, half, size):
    body = Body(half.body.shapes, creature.triangles, form=Form.CLOSEST, scale=1)
    features = Features.at_points(half.handles, size * half.truth[half.handles])
    scan = Scan.of_mesh(size * half.scan.points, half.scan.mesh.triangles)
    found = register(body, scan, features)
    assert half.errors(found.positions / size).mean() < 0.01


def test_a_near_pose_replaces_features(whole):
    near = whole.features().pose(whole.body, 10.0)
    found = register(whole.body, whole.scan, start=near)
    assert whole.errors(found.positions).mean() < 0.4 * whole.errors(near).mean()


def test_turning_the_scan_turns_what_is_found(half):
    angle = 2.0
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    scan = Scan.of_mesh(half.scan.points @ turn.T + 5, half.scan.mesh.triangles)
    features = Features.at_points(half.handles, half.truth[half.handles] @ turn.T + 5)
    settings = Settings(max_rounds=3)
    there = register(half.body, scan, features, settings=settings)
    here = register(half.body, half.scan, half.features(), settings=settings)
    turned_back = (there.positions - 5) @ turn
    np.testing.assert_allclose(turned_back, here.positions, atol=1e-4 * half.unit)


def test_a_fit_does_not_depend_on_what_was_fitted_before(half):
    first = register(half.body, half.scan, half.features(), settings=Settings(max_rounds=3))
    elsewhere = Features.at_points(half.handles, half.body.rest[half.handles])
    register(half.body, half.scan, elsewhere, settings=Settings(max_rounds=1))
    again = register(half.body, half.scan, half.features(), settings=Settings(max_rounds=3))
    np.testing.assert_array_equal(first.positions, again.positions)


def test_an_exception_of_progress_cancels(half):
    seen = []

    def stop(stage, fraction):
        seen.append((stage, fraction))
        if len(seen) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        register(half.body, half.scan, half.features(), progress=stop)
    assert [stage for stage, _ in seen] == ["fit, round 1", "fit, round 2", "fit, round 3"]
    assert sorted(fraction for _, fraction in seen) == [fraction for _, fraction in seen]


# What cannot be ---------------------------------------------------------------------------------


def test_too_few_features_are_told(half):
    with pytest.raises(ValueError, match="at least three features are needed .* there are 2"):
        register(half.body, half.scan, Features.at_points([0, 1], np.zeros((2, 3))))


def test_features_on_a_line_are_told(half):
    line = np.linspace(0, 1, 4)[:, None] * np.ones(3)
    with pytest.raises(ValueError, match="on one line on the scan, so that the turn about it"):
        register(half.body, half.scan, Features.at_points(half.handles[:4], line))


def test_features_that_cannot_be_are_told(half):
    places = half.truth[half.handles[:3]]
    for vertices, there, text in (
        ([0, 1, 10**6], places, "there is no vertex 1000000 for a feature, only 0 to"),
        ([5, 5, 9], places, "two features are at one vertex"),
        ([0, 1, 2], np.full((3, 3), np.nan), "places that are not finite"),
        ([0, 1, 2], places[:2], "their places must be as many by 3"),
    ):
        with pytest.raises(ValueError, match=text):
            register(half.body, half.scan, Features.at_points(vertices, there))
    for vertices, points, options, text in (
        ([0, 1, -2], [0, 1, 2], {}, "there is no vertex -2 for a feature, only"),
        ([0, 1, 2], [0, 1, 10**6], {}, "no vertex 1000000 for a feature's place on the scan"),
        ([0, 1, 2], [0, 1], {}, "3 vertices cannot be 2 points"),
        ([0, 1, 2], [0, 1, 2], {"radius": 0}, "discs of radius 0: both must be above 0"),
        ([0, 1, 2], [0, 1, 2], {"count": 0}, "0 discs of radius 0.15: both must"),
    ):
        with pytest.raises(ValueError, match=text):
            Features.at_discs(half.body, vertices, half.scan, points, **options)
    with pytest.raises(ValueError, match="only a scan with triangles has discs"):
        cloud = Scan(half.scan.points, half.scan.normals)
        Features.at_discs(half.body, half.handles, cloud, half.handles)


def test_a_start_is_needed(half):
    with pytest.raises(ValueError, match="nothing tells where the body is: give features"):
        register(half.body, half.scan)
    with pytest.raises(ValueError, match="the start must be 6754 by 3 finite positions"):
        register(half.body, half.scan, start=np.zeros((3, 3)))


def test_a_part_without_a_feature_is_told(creature):
    count = creature.shapes.shape[1]
    two = np.concatenate([creature.shapes[:2], creature.shapes[:2] + 3], axis=1)
    body = Body(two, np.concatenate([creature.triangles, creature.triangles + count]))
    handles = list(creature.handles.values())
    scan = Scan.of_mesh(two[1], body.triangles)
    features = Features.at_points(handles, two[1][handles])
    with pytest.raises(ValueError, match=f"2 parts .* the one with vertex {count} has no feature"):
        register(body, scan, features)


def test_a_scan_out_of_reach_is_told(half):
    far = Scan(half.scan.points + 100, half.scan.normals)
    with pytest.raises(ValueError, match="no point of the scan is near the body and faces"):
        register(half.body, far, start=half.truth)


@pytest.mark.parametrize(
    ("points", "normals", "text"),
    [
        (np.zeros((0, 3)), None, "the scan is empty"),
        (np.zeros((4, 2)), None, "must be #P by 3"),
        (np.array([[0, 0, np.nan]]), None, "1 points of the scan are not finite"),
        (np.zeros((2, 3)), np.ones((3, 3)), "2 points but 3 normals"),
        (np.zeros((2, 3)), np.ones((2, 3)), "2 normals of the scan are not of length one"),
        (np.zeros((2, 3)), np.zeros((2, 3)), "no point of the scan has a normal"),
    ],
)
def test_scans_that_cannot_be_are_told(points, normals, text):
    with pytest.raises(ValueError, match=text):
        Scan(points, normals)


def test_a_mesh_without_triangles_is_no_scan():
    with pytest.raises(ValueError, match="the scan has no triangles"):
        Scan.of_mesh(np.zeros((4, 3)), np.zeros((0, 3), np.int32))
    with pytest.raises(ValueError, match="the scan is empty"):
        Scan.of_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def test_normals_are_asked_for_where_they_are_needed(half):
    with pytest.raises(ValueError, match="the scan has no normals.*or set `angle` to None"):
        register(half.body, Scan(half.scan.points), half.features())


@pytest.mark.parametrize(
    "options", [{"reach": 0}, {"firmness": -1}, {"angle": 90}, {"patches": 0}, {"features": 1e4}]
)
def test_settings_that_cannot_be_are_told(options):
    with pytest.raises(ValueError):
        Settings(**options)


def test_bodies_that_cannot_be_are_told(creature):
    with pytest.raises(ValueError, match="coordinates that are not finite"):
        Body(np.full((1, 4, 3), np.nan), [[0, 1, 2]])
    with pytest.raises(ValueError, match="shapes must be #S by #V by k"):
        Body(np.zeros((4, 3)), [[0, 1, 2]])
    with pytest.raises(ValueError, match="no area"):
        Body(np.zeros((1, 3, 3)), [[0, 1, 2]])
    flat = Body(creature.shapes[:2, :, :2], creature.triangles)
    scan = Scan.of_mesh(creature.shapes[0], creature.triangles)
    with pytest.raises(ValueError, match="only bodies in space"):
        register(flat, scan, start=flat.rest)


def test_rows_change_less_often_than_matches(half, monkeypatch):
    changes = []
    solver = half.body.solver

    def counted(*given):
        changes.append(given)
        return solver(*given)

    monkeypatch.setattr(half.body, "solver", counted)
    found = register(half.body, half.scan, half.features())
    assert 2 <= len(changes) < 0.7 * found.rounds
