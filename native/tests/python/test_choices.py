# SPDX-License-Identifier: GPL-3.0-or-later
"""One choice of dictionary and one of energy: each goes with each, with rows that are pinned or
soft."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from test_blend_optimum import tube

from addon.dictionaries import (
    BONES,
    Dictionary,
    Functions,
    eigenfunction_count,
    functions_of_weights,
    make_functions,
)
from addon.geometry import Mesh, Rows
from addon.solver import Form, Model, Solver, make_solver
from sample_scenes import creature as scene

EXAMPLES = 4
# The average of the distances from all shapes is no example, ten rounds of the closest do not come
# to rest, and without rotations a blend of shapes may be as near to the handles.
ROUGH = {Form.AVERAGE: 0.1, Form.CLOSEST: 0.05, Form.NO_ROTATIONS: 0.1}
DEFAULT_GROUPS = {Dictionary.HANDLES: 2 * 8, Dictionary.EIGENFUNCTIONS: 15, Dictionary.SKELETON: 20}


@functools.cache
def animal() -> tuple[np.ndarray, np.ndarray, list[int]]:
    sample = scene.sample()
    shapes = np.stack(list(sample.shapes.values()))[:EXAMPLES]
    with Mesh(shapes[0], sample.triangles()) as mesh:
        return shapes, sample.triangles(), mesh.spread(8).tolist()


@functools.cache
def functions_of(kind: Dictionary) -> Functions:
    shapes, triangles, handles = animal()
    with Mesh(shapes[0], triangles) as mesh:
        return make_functions(kind, mesh, shapes, handles)


@pytest.mark.parametrize("kind", Dictionary)
def test_functions_span_the_constant_and_groups_suit_them(kind):
    functions = functions_of(kind)
    ones = np.ones(len(functions.weights))
    _, rest, rank, _ = np.linalg.lstsq(functions.weights, ones, rcond=None)
    assert rank == functions.weights.shape[1] and rest[0] < 1e-12
    groups = DEFAULT_GROUPS[kind]
    assert 0.8 * groups <= len(np.unique(functions.groups)) <= groups


@pytest.mark.parametrize("firmness", [np.inf, 100.0])
@pytest.mark.parametrize("form", Form)
@pytest.mark.parametrize("kind", Dictionary)
def test_every_energy_runs_on_every_dictionary(kind, form, firmness):
    shapes, triangles, handles = animal()
    functions = functions_of(kind)
    with (
        Mesh(shapes[0], triangles) as mesh,
        Model(mesh, shapes, functions.weights, Rows.pin(handles), functions.groups) as model,
        Solver(model, form=form) as solver,
    ):
        solver.set_firmness(np.full(len(handles), firmness))
        solver.solve(shapes[1][handles])
        error = np.abs(solver.positions() - shapes[1]).max() / np.ptp(shapes[0])
    assert error < ROUGH.get(form, 1e-6)


@pytest.mark.parametrize("kind", Dictionary)
def test_groups_can_be_chosen(kind):
    shapes, triangles, handles = animal()
    with Mesh(shapes[0], triangles) as mesh:
        groups = make_functions(kind, mesh, shapes, handles, group_count=7).groups
    assert len(np.unique(groups)) <= 7


@pytest.mark.parametrize(
    ("shape_count", "handle_count", "count"),
    [(1, 10, 15), (1, 80, 40), (4, 10, 15), (4, 80, 40)],
)
def test_many_handles_take_more_eigenfunctions(shape_count, handle_count, count):
    """Of one shape it is the functions that let each handle move on its own."""
    shapes, triangles, _ = animal()
    with Mesh(shapes[0], triangles) as mesh:
        handles = mesh.spread(handle_count)
    noise = np.random.default_rng(0).normal(0, 0.01, (handle_count, 3))
    with make_solver(shapes[:shape_count], triangles, handles) as solver:
        assert solver.sizes.weights == count
        solver.solve(shapes[0][handles] + noise)
        found = solver.positions()[handles]
    np.testing.assert_allclose(found, shapes[0][handles] + noise, atol=1e-6)


def test_few_vertices_take_fewer_eigenfunctions():
    """More columns than vertices span nothing new."""
    vertices, triangles = tube()
    two = np.concatenate([triangles, triangles + len(vertices)])
    parts = np.concatenate([vertices, vertices + [0, 0, 4]])
    for shapes, faces, handle_count, count in (
        (vertices[None], triangles, 3, 15),
        (np.repeat(vertices[None], 4, axis=0), triangles, 3, 104 // 13),
        (np.repeat(vertices[None], 4, axis=0), triangles, 12, 12),
        (parts[None], two, 3, 16),
    ):
        with Mesh(shapes[0], faces) as mesh:
            assert eigenfunction_count(mesh, shapes, handle_count) == count


def test_an_armatures_weights_are_a_dictionary():
    shapes, triangles, _ = animal()
    weights = 3.0 * functions_of(Dictionary.SKELETON).weights
    with Mesh(shapes[0], triangles) as mesh:
        functions = functions_of_weights(mesh, weights)
    np.testing.assert_allclose(functions.weights.sum(axis=1), 1)
    assert len(np.unique(functions.groups)) <= BONES
    assert (weights[:2] == 3.0 * functions_of(Dictionary.SKELETON).weights[:2]).all()


@pytest.mark.parametrize(
    ("weight", "message"),
    [
        (0.0, "1 vertices have no weight, the first is vertex 3"),
        (-1.0, "vertex 3 has a weight that is negative or not finite"),
        (np.nan, "vertex 3 has a weight that is negative or not finite"),
    ],
)
def test_bad_weights_name_a_vertex(weight, message):
    shapes, triangles, _ = animal()
    weights = np.ones((len(shapes[0]), 2))
    weights[3] = weight
    with Mesh(shapes[0], triangles) as mesh, pytest.raises(ValueError, match=message):
        functions_of_weights(mesh, weights)


def test_an_unknown_dictionary_is_refused():
    shapes, triangles, handles = animal()
    with pytest.raises(ValueError, match="SKELETONS"):
        make_solver(shapes, triangles, handles, dictionary="SKELETONS")
