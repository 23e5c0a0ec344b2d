# SPDX-License-Identifier: GPL-3.0-or-later
"""solver.py on small meshes: arrays in and out, lifetimes, options, errors, progress."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from addon.dictionaries import Dictionary
from addon.native import ERROR_ARGUMENT, ERROR_BLOB, ERROR_HANDLES, ERROR_MESH, TugError
from addon.solver import Form, Mesh, Model, Rows, Solver, make_solver, minimise_blend
from addon.weights import cluster_triangles, compute_weights

LENGTH, WIDTH = 12, 4  # of the strip, in squares
HANDLES = [2, 32, 62]  # vertices at the start, middle and end of its centre line


def strip(dimension: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a flat strip along x."""
    x, y = np.meshgrid(np.arange(LENGTH + 1.0), np.arange(WIDTH + 1.0), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel() - WIDTH / 2, 0 * x.ravel()], axis=1)
    number = np.arange(vertices.shape[0]).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return np.ascontiguousarray(vertices[:, :dimension]), triangles.reshape(-1, 3).astype(np.int32)


def bent(vertices: np.ndarray, angle: float) -> np.ndarray:
    """The strip bent to an arc of `angle` over its length, lengths of the centre line kept."""
    turn = angle * vertices[:, 0] / LENGTH
    radius = LENGTH / angle
    result = vertices.copy()
    result[:, 0] = (radius - vertices[:, 1]) * np.sin(turn)
    result[:, 1] = radius - (radius - vertices[:, 1]) * np.cos(turn)
    return result


@pytest.fixture(params=[2, 3], ids=["2D", "3D"])
def shapes(request) -> np.ndarray:
    vertices, _ = strip(request.param)
    return np.stack([vertices, bent(vertices, 1.0), bent(vertices, -1.5)])


@pytest.fixture
def triangles() -> np.ndarray:
    return strip()[1]


@pytest.fixture
def mesh(shapes, triangles):
    with Mesh(shapes[0], triangles) as mesh:
        yield mesh


def make_model(mesh: Mesh, shapes: np.ndarray, rows: Rows | None = None, **options) -> Model:
    weights, _ = compute_weights(mesh, [[vertex] for vertex in HANDLES])
    groups = cluster_triangles(mesh, weights, 2 * len(HANDLES))
    return Model(mesh, shapes, weights, rows or Rows.pin(HANDLES), groups, **options)


def test_weights_are_one_at_their_handle_and_sum_to_one(mesh):
    weights, info = compute_weights(mesh, [[vertex] for vertex in HANDLES])
    assert info.converged
    np.testing.assert_allclose(weights[HANDLES], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(weights.sum(axis=1), 1)
    assert weights.min() >= 0


def test_a_handle_may_have_many_vertices(mesh):
    ends = [list(range(WIDTH + 1)), list(range(len(strip()[0]) - WIDTH - 1, len(strip()[0])))]
    weights, _ = compute_weights(mesh, ends)
    np.testing.assert_allclose(weights[ends[0], 0], 1)
    np.testing.assert_allclose(weights[ends[1], 1], 1)


def test_groups_are_numbered_without_gaps(mesh):
    weights, _ = compute_weights(mesh, [[vertex] for vertex in HANDLES])
    groups = cluster_triangles(mesh, weights, 6)
    assert groups.shape == (mesh.triangle_count,)
    assert sorted(set(groups)) == list(range(groups.max() + 1))


def test_components_are_numbered_by_their_first_vertex(triangles):
    vertices, _ = strip()
    twice = np.concatenate([vertices, vertices + 100])
    with Mesh(twice, np.concatenate([triangles + len(vertices), triangles])) as mesh:
        np.testing.assert_array_equal(mesh.components(), np.repeat([0, 1], len(vertices)))


def test_a_sound_mesh_has_nothing_to_report(mesh):
    report = mesh.check()
    assert (report.errors, report.warnings, report.text) == (0, 0, "")


def test_a_mesh_report_names_what_is_wrong(triangles):
    vertices, _ = strip()
    vertices[triangles[0]] = vertices[triangles[0, 0]]
    with Mesh(np.concatenate([vertices, [[50, 50]]]), triangles) as mesh:
        report = mesh.check()
        assert report.errors == 2
        with pytest.raises(TugError) as caught:
            compute_weights(mesh, [[vertex] for vertex in HANDLES])
    assert caught.value.code == ERROR_MESH


def test_the_handles_of_an_example_give_that_example(shapes, triangles):
    with make_solver(shapes, triangles, HANDLES) as solver:
        for number, shape in enumerate(shapes):
            info = solver.solve(shape[HANDLES])
            assert info.converged
            assert solver.blend()[:, number].mean() > 0.98
            np.testing.assert_allclose(solver.positions(), shape, atol=1e-4 * LENGTH)


def test_what_a_solve_found_has_the_shapes_that_are_documented(shapes, triangles):
    with make_solver(shapes, triangles, HANDLES) as solver:
        solver.solve(shapes[1, HANDLES])
        k, groups = shapes.shape[2], solver.sizes.groups
        assert solver.positions().shape == shapes.shape[1:]
        assert solver.costs().shape == solver.blend().shape == (groups, len(shapes))
        rotations = solver.rotations()
        assert rotations.shape == (groups, len(shapes), k, k)
        identity = np.broadcast_to(np.eye(k), rotations.shape)
        np.testing.assert_allclose(rotations @ rotations.swapaxes(2, 3), identity, atol=1e-9)


def test_a_pose_does_not_depend_on_the_one_before(shapes, triangles):
    with make_solver(shapes, triangles, HANDLES) as solver:
        targets = shapes[1, HANDLES] + 0.3
        solver.solve(targets)
        first = solver.positions()
        solver.solve(shapes[2, HANDLES])
        solver.solve(targets)
        np.testing.assert_array_equal(solver.positions(), first)


def test_a_free_handle_has_no_row(shapes, triangles):
    handles = Dictionary.HANDLES
    with make_solver(shapes, triangles, HANDLES, dictionary=handles, free=[1]) as solver:
        assert (solver.sizes.rows, solver.sizes.weights) == (2, 3)
        targets = shapes[1, [HANDLES[0], HANDLES[2]]]
        solver.solve(targets)
        np.testing.assert_allclose(solver.positions()[HANDLES[::2]], targets, atol=1e-9)


def test_how_firmly_a_handle_is_held_can_change_without_a_new_model(shapes, triangles):
    targets = shapes[1, HANDLES]
    targets[1] += 0.5
    with make_solver(shapes, triangles, HANDLES) as solver:
        misses = []
        for firmness in (np.inf, 10.0, 1.0, 0.0):
            solver.set_firmness([np.inf, firmness, np.inf])
            assert solver.solve(targets).converged
            misses.append(np.linalg.norm(solver.positions()[HANDLES] - targets, axis=1))
        misses = np.array(misses)
        np.testing.assert_allclose(misses[:, [0, 2]], 0, atol=1e-9)
        assert misses[0, 1] < 1e-9
        assert (np.diff(misses[:, 1]) > 1e-3).all()


def test_firmness_that_does_not_fit_is_refused(shapes, triangles):
    with make_solver(shapes, triangles, HANDLES) as solver:
        with pytest.raises(ValueError, match="firmness must be 3"):
            solver.set_firmness([1.0])
        with pytest.raises(TugError, match="row 2 is -1") as caught:
            solver.set_firmness([1, 1, -1])
        assert caught.value.code == ERROR_ARGUMENT


def turned(k: int, angle: float) -> np.ndarray:
    rotation = np.eye(k)
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return rotation


def test_a_handle_may_say_how_the_surface_is_turned(shapes, triangles):
    k = shapes.shape[2]
    wanted = np.stack([np.eye(k), turned(k, 0.4), np.eye(k)])
    with make_solver(shapes, triangles, HANDLES) as solver:
        assert solver.solve(shapes[0, HANDLES]).converged
        plain = solver.positions()
        solver.set_orientations(wanted, [0, np.inf, 0])
        assert solver.solve(shapes[0, HANDLES]).converged
        misses = np.abs(solver.rotations()[:, 0] - wanted[1]).max(axis=(1, 2))
        assert misses.min() < 1e-5
        assert np.abs(solver.positions() - plain).max() > 0.05
        np.testing.assert_allclose(solver.positions()[HANDLES], shapes[0, HANDLES], atol=1e-9)
        solver.set_orientations(wanted, np.zeros(3))
        solver.solve(shapes[0, HANDLES])
        np.testing.assert_array_equal(solver.positions(), plain)
        with pytest.raises(TugError, match="row 2 is not a rotation"):
            solver.set_orientations(2 * wanted, [0, 0, 1])
        with pytest.raises(ValueError, match="orientations must be 3 by"):
            solver.set_orientations(wanted[:1], np.ones(3))


@pytest.mark.parametrize("form", [Form.NO_ROTATIONS, Form.TRUST_REGION])
def test_a_form_that_cannot_turn_parts_has_no_orientations(shapes, triangles, form):
    k = shapes.shape[2]
    solver = make_solver(shapes, triangles, HANDLES, form=form)
    with pytest.raises(TugError, match="steady"):
        solver.set_orientations(np.stack(3 * [np.eye(k)]), np.ones(3))


def test_stiff_triangles_deform_less(triangles):
    vertices, _ = strip()
    middle = vertices[triangles].mean(axis=1)[:, 0]
    targets = vertices[HANDLES]
    targets[1] += [0.0, 3.0]
    stretches = []
    for stiffness in (None, np.where(middle < LENGTH / 2, 50.0, 1.0)):
        with make_solver(vertices[None], triangles, HANDLES, stiffness=stiffness) as solver:
            solver.solve(targets)
            edges = solver.positions()[triangles] - solver.positions()[np.roll(triangles, 1, 1)]
        rest = vertices[triangles] - vertices[np.roll(triangles, 1, 1)]
        change = np.linalg.norm(edges, axis=2) / np.linalg.norm(rest, axis=2) - 1
        stretches.append((change**2).mean(axis=1)[middle < LENGTH / 2].mean())
    assert stretches[1] < 0.7 * stretches[0]


def test_stiffness_that_cannot_be_is_refused(mesh, shapes):
    stiffness = np.ones(mesh.triangle_count)
    stiffness[3] = 0
    with pytest.raises(TugError, match="triangle 3 is 0"):
        make_model(mesh, shapes, stiffness=stiffness)
    with pytest.raises(ValueError, match=f"stiffness must be {mesh.triangle_count}"):
        make_model(mesh, shapes, stiffness=stiffness[1:])


def test_a_row_may_be_any_sparse_combination(mesh, shapes):
    rows = Rows.combine([([2], [1.0]), ([30, 34], [0.5, 0.5]), ([62], [1.0])])
    targets = shapes[0, HANDLES] + 0.1 * np.arange(3)[:, None]
    with make_model(mesh, shapes, rows) as model, Solver(model) as solver:
        solver.solve(targets)
        posed = solver.positions()
    np.testing.assert_allclose((posed[30] + posed[34]) / 2, targets[1], atol=1e-9)


def test_a_saved_model_gives_the_same_pose(mesh, shapes):
    targets = shapes[1, HANDLES] + 0.2
    poses = []
    with make_model(mesh, shapes) as model, Model.load(model.save()) as loaded:
        assert loaded.sizes == model.sizes
        for one in (model, loaded):
            with Solver(one) as solver:
                solver.solve(targets)
                poses.append(solver.positions())
    np.testing.assert_array_equal(*poses)


def test_a_damaged_model_is_refused(mesh, shapes):
    with make_model(mesh, shapes) as model:
        blob = bytearray(model.save())
    blob[len(blob) // 2] ^= 1
    for damaged in (blob, blob[:100], b""):
        with pytest.raises(TugError) as caught:
            Model.load(bytes(damaged))
        assert caught.value.code == ERROR_BLOB


def test_options_change_the_solve(shapes, triangles):
    targets = 0.6 * shapes[0, HANDLES] + 0.4 * shapes[1, HANDLES]
    poses = {}
    for name, options in {
        "default": {},
        "lambda": {"lambda_": 5.0},
        "form": {"form": Form.NO_ROTATIONS},
        "single": {"single_blend": True},
        "squared": {"squared": True},
        "prior": {"prior": 1.0},
    }.items():
        with make_solver(shapes, triangles, HANDLES, **options) as solver:
            solver.solve(targets)
            poses[name] = solver.positions()
    default = poses.pop("default")
    assert [name for name, pose in poses.items() if np.array_equal(pose, default)] == []


def test_an_option_that_does_not_exist_is_named(shapes, triangles):
    with pytest.raises(TypeError, match="'wobble'.*lambda"):
        make_solver(shapes, triangles, HANDLES, wobble=1)


@pytest.mark.parametrize("name", ["check", "components"])
def test_a_closed_mesh_says_so(mesh, name):
    mesh.close()
    mesh.close()
    with pytest.raises(ValueError, match="this Mesh is closed"):
        getattr(mesh, name)()


def test_a_closed_solver_says_so(shapes, triangles):
    solver = make_solver(shapes, triangles, HANDLES)
    solver.close()
    with pytest.raises(ValueError, match="this Solver is closed"):
        solver.solve(shapes[0, HANDLES])


def test_a_closed_model_makes_no_solver_but_serves_those_it_has(mesh, shapes):
    model = make_model(mesh, shapes)
    solver = Solver(model)
    mesh.close()
    model.close()
    with pytest.raises(ValueError, match="this Model is closed"):
        Solver(model)
    del model
    gc.collect()
    solver.solve(shapes[1, HANDLES])
    np.testing.assert_allclose(solver.positions()[HANDLES], shapes[1, HANDLES], atol=1e-9)


def test_arrays_that_do_not_fit_are_refused_before_the_library(mesh, shapes, triangles):
    weights = np.full((mesh.vertex_count, 3), 1 / 3)
    groups = np.zeros(mesh.triangle_count, np.int32)
    rows = Rows.pin(HANDLES)
    for arguments in (
        (mesh, shapes[:, 1:], weights, rows, groups),
        (mesh, shapes, weights[1:], rows, groups),
        (mesh, shapes, weights, rows, groups[1:]),
    ):
        with pytest.raises(ValueError, match="must be|expected"):
            Model(*arguments)
    with pytest.raises(ValueError, match="#F by 3"):
        Mesh(shapes[0], triangles[:, :2])
    solver = make_solver(shapes, triangles, HANDLES)
    with pytest.raises(ValueError, match="targets must be 3 by"):
        solver.solve(shapes[0, HANDLES[:2]])
    with pytest.raises(ValueError, match="2 vertices but 1 values"):
        Rows.combine([([1, 2], [1.0])])


def test_two_handles_on_a_vertex_are_an_error(mesh):
    with pytest.raises(TugError) as caught:
        compute_weights(mesh, [[2], [62], [2]])
    assert caught.value.code == ERROR_HANDLES


def test_a_component_without_a_handle_is_an_error_or_follows(triangles):
    vertices, _ = strip()
    twice = np.concatenate([vertices, vertices + [0, 100]])
    with Mesh(twice, np.concatenate([triangles, triangles + len(vertices)])) as mesh:
        handles = [[vertex] for vertex in HANDLES]
        with pytest.raises(TugError) as caught:
            compute_weights(mesh, handles)
        assert caught.value.code == ERROR_HANDLES
        weights, _ = compute_weights(mesh, handles, follow_nearest=1)
    assert set(weights[len(vertices) :].max(axis=1)) == {1.0}


def rises(seen: list[tuple[str, float]]) -> bool:
    stages, fractions = zip(*seen, strict=True)
    return all(stages) and [0, *fractions, 1] == sorted([0, *fractions, 1])


def test_progress_rises_to_its_end(shapes, triangles):
    seen = []
    with Mesh(shapes[0], triangles) as mesh:
        compute_weights(mesh, [[v] for v in HANDLES], progress=lambda *step: seen.append(step))
    assert rises(seen)


@pytest.mark.parametrize("dictionary", Dictionary)
def test_progress_rises_through_all_that_makes_a_solver(shapes, triangles, dictionary):
    seen = []
    make_solver(
        *(shapes, triangles, HANDLES),
        dictionary=dictionary,
        progress=lambda *step: seen.append(step),
    ).close()
    assert rises(seen)


@pytest.mark.parametrize("kind", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize("after", [0, 2])
def test_what_progress_raises_cancels_and_comes_out(mesh, shapes, kind, after):
    calls = []

    def stop(stage: str, fraction: float) -> None:
        calls.append(stage)
        if len(calls) > after:
            raise kind("enough")

    with pytest.raises(kind, match="enough"):
        make_model(mesh, shapes, progress=stop)
        make_model(mesh, shapes, progress=stop)
        make_model(mesh, shapes, progress=stop)
    assert len(calls) == after + 1


def test_a_blend_is_found_from_its_quadratic():
    # min |B - p|^2 over two simplices, squared: the projections of p.
    wished = np.array([[0.7, 0.3], [1.5, -0.5]])
    blend, info = minimise_blend(
        np.eye(4),
        -wished.ravel(),
        (wished**2).sum(),
        np.zeros(4),
        np.full((2, 2), 0.5),
        lambda_=0.0,
        squared=True,
    )
    np.testing.assert_allclose(blend, [[0.7, 0.3], [1.0, 0.0]], atol=1e-9)
    assert info.gap < 1e-9
