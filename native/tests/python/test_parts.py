# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose parts: those that follow the rest of the mesh, and those that would float."""

from __future__ import annotations

import numpy as np
import pytest

from addon.dictionaries import Dictionary, make_functions
from addon.geometry import Mesh
from addon.parts import find_floating, make_followed_functions

SIDE = 12  # vertices of a sheet along an edge
COUNT = SIDE**2


def sheet(offset: tuple[float, float, float]) -> np.ndarray:
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    flat = np.stack([x.ravel(), y.ravel(), 0.2 * np.sin(x).ravel()], axis=1)
    return flat + offset


def triangles(sheets: int) -> np.ndarray:
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    one = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + SIDE], 1),
            np.stack([corner + 1, corner + SIDE + 1, corner + SIDE], 1),
        ]
    )
    return np.concatenate([one + COUNT * number for number in range(sheets)])


@pytest.fixture
def vertices() -> np.ndarray:
    """Three sheets: beside the last vertex of the first begins the second, and far the third."""
    last = sheet((0, 0, 0))[-1]
    return np.concatenate([sheet((0, 0, 0)), sheet(tuple(last + [0.5, 0, 0])), sheet((0, 0, 40))])


@pytest.mark.parametrize("kind", [Dictionary.EIGENFUNCTIONS, Dictionary.SKELETON])
def test_parts_without_a_handle_have_the_weights_of_the_nearest_vertex(vertices, kind):
    shapes = np.stack([vertices, vertices * [1, 2, 1]])
    handles = [0, 2 * COUNT + 5]
    with Mesh(vertices, triangles(3)) as mesh:
        made = make_followed_functions(kind, mesh, shapes, handles)
        assert find_floating(mesh, made.weights, handles) == -1
    kept = np.r_[:COUNT, 2 * COUNT : 3 * COUNT]
    with Mesh(vertices[kept], triangles(2)) as mesh:
        wanted = make_functions(kind, mesh, shapes[:, kept], [0, COUNT + 5])
    np.testing.assert_array_equal(made.weights[kept], wanted.weights)
    followed = made.weights[COUNT : 2 * COUNT]
    np.testing.assert_array_equal(followed, np.tile(made.weights[COUNT - 1], (COUNT, 1)))
    size = len(made.groups) // 3
    np.testing.assert_array_equal(np.r_[made.groups[:size], made.groups[-size:]], wanted.groups)
    assert len(set(made.groups[size : 2 * size])) == 1


def test_a_part_of_its_own_floats_without_a_handle(vertices):
    part = np.repeat(np.eye(3), COUNT, axis=0)
    with Mesh(vertices, triangles(3)) as mesh:
        assert find_floating(mesh, part, [0, COUNT, 2 * COUNT]) == -1
        assert COUNT <= find_floating(mesh, part, [0, 2 * COUNT]) < 2 * COUNT
        shared = part[:, :2].copy()
        shared[2 * COUNT :, 1] = 1  # the second and the third move as one
        assert find_floating(mesh, shared, [0, COUNT]) == -1
        assert find_floating(mesh, shared, [0]) >= COUNT


def test_what_bends_with_the_rest_is_held(vertices):
    """The second sheet shares a function with the first that is not constant on either."""
    ramp = np.r_[np.linspace(0, 1, 2 * COUNT), np.zeros(COUNT)]
    with Mesh(vertices[: 2 * COUNT], triangles(2)) as mesh:
        weights = np.stack([ramp, 1 - ramp], axis=1)[: 2 * COUNT]
        assert find_floating(mesh, weights, [0]) == -1
