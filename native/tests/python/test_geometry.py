# SPDX-License-Identifier: GPL-3.0-or-later
"""geometry.py: rows on flat and round surfaces, and nearest points beside SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

from addon.geometry import Mesh, Points, Rows
from addon.native import TugError

SIZE = 13  # of the flat patch, in vertices
MIDDLE = SIZE * SIZE // 2


def patch(jitter: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a square in the plane z = 0, its inner vertices moved at random."""
    y, x = np.mgrid[0:SIZE, 0:SIZE].astype(float)
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    inner = ((vertices[:, :2] > 0) & (vertices[:, :2] < SIZE - 1)).all(axis=1)
    moves = np.random.default_rng(1).uniform(-jitter, jitter, (SIZE * SIZE, 2))
    vertices[inner, :2] += moves[inner]
    corner = (np.arange(SIZE - 1)[:, None] * SIZE + np.arange(SIZE - 1)).ravel()[:, None]
    triangles = np.concatenate([corner + [0, 1, SIZE + 1], corner + [0, SIZE + 1, SIZE]])
    return vertices, triangles.astype(np.int32)


def sphere(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Evenly spread points of the unit sphere and their triangles, outward."""
    height = 1 - (2 * np.arange(count) + 1) / count
    angle = np.arange(count) * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - height**2)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    triangles = ConvexHull(points).simplices.astype(np.int32)
    a, b, c = points[triangles].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles


def test_a_disc_on_a_plane_has_its_middle_for_a_mean():
    vertices, triangles = patch(0.0)
    with Mesh(vertices, triangles) as mesh:
        rows = Rows.discs(mesh, [MIDDLE, MIDDLE, MIDDLE + 1], [0.0, 3.5, 2.0])
        far = mesh.distances([MIDDLE])
    expected = vertices[[MIDDLE, MIDDLE, MIDDLE + 1]]
    np.testing.assert_allclose(rows.of(vertices), expected, atol=1e-13)
    assert list(rows.vertices[:1]) == [MIDDLE]
    assert set(rows.vertices[rows.starts[1] : rows.starts[2]]) == set(np.flatnonzero(far <= 3.5))


def test_a_disc_weighs_by_area_and_sums_to_one():
    vertices, triangles = patch(0.3)
    with Mesh(vertices, triangles) as mesh:
        rows, areas = Rows.discs(mesh, [5, MIDDLE], 2.5), mesh.areas()
    ones = np.ones(len(vertices))
    np.testing.assert_allclose(rows.of(ones[:, None]), 1)
    for start, end in zip(rows.starts[:-1], rows.starts[1:], strict=True):
        shares = rows.values[start:end] / areas[rows.vertices[start:end]]
        np.testing.assert_allclose(shares, shares[0])


def test_a_disc_of_a_negative_radius_is_refused():
    with Mesh(*patch(0.0)) as mesh:
        with pytest.raises(ValueError, match="vertex 3"):
            Rows.discs(mesh, [3], -1.0)
        with pytest.raises(TugError, match="no vertex 999"):
            Rows.discs(mesh, [999], 1.0)


def test_laplacian_coordinates_of_linear_functions_are_zero_inside_a_plane():
    vertices, triangles = patch(0.3)
    edge = ((vertices[:, :2] == 0) | (vertices[:, :2] == SIZE - 1)).any(axis=1)
    inner = np.flatnonzero(~edge)
    with Mesh(vertices, triangles) as mesh:
        rows = Rows.laplacian(mesh, inner)
    assert len(rows) == len(inner)
    linear = vertices @ np.random.default_rng(2).normal(size=(3, 4)) + 7.0
    np.testing.assert_allclose(rows.of(linear), 0, atol=1e-11)


def test_laplacian_coordinates_of_a_sphere_are_twice_its_normals():
    points, triangles = sphere(2000)
    with Mesh(points, triangles) as mesh:
        rows, normals = Rows.laplacian(mesh, range(len(points))), mesh.normals(points)
    np.testing.assert_allclose(normals, points, atol=0.01)
    np.testing.assert_allclose(rows.of(points), 2 * points, atol=0.1)


def test_laplacian_rows_are_those_of_the_matrix():
    points, triangles = sphere(60)
    with Mesh(points, triangles) as mesh:
        rows = Rows.laplacian(mesh, [7, 3, 7])
        areas, weights = mesh.areas(), mesh.half_cotangents()
    L = np.zeros((60, 60))
    for triangle, weight in zip(triangles, weights, strict=True):
        for c in range(3):
            edge = np.zeros(60)
            edge[triangle[c - 2]], edge[triangle[c - 1]] = 1, -1
            L += weight[c] * np.outer(edge, edge)
    assert len(rows) == 3
    np.testing.assert_allclose(rows.of(np.eye(60)), (L / areas[:, None])[[7, 3, 7]], atol=1e-12)


def test_laplacian_of_a_vertex_that_is_not_there_is_refused():
    with Mesh(*patch(0.0)) as mesh, pytest.raises(ValueError, match="no vertex -1"):
        Rows.laplacian(mesh, [-1])


def test_normals_want_positions_in_space():
    vertices, triangles = patch(0.0)
    with Mesh(vertices, triangles) as mesh, pytest.raises(ValueError, match="by 3"):
        mesh.normals(vertices[:, :2])


@pytest.mark.parametrize("dimension", range(1, 7))
def test_nearest_points_are_those_of_scipy(dimension):
    random = np.random.default_rng(dimension)
    points, queries = random.normal(size=(500, dimension)), random.normal(size=(200, dimension))
    with Points(points) as tree:
        numbers, distances = tree.nearest(queries)
        near, _ = tree.nearest(queries, limit=0.3)
    expected, expected_numbers = cKDTree(points).query(queries)
    np.testing.assert_array_equal(numbers, expected_numbers)
    np.testing.assert_allclose(distances, expected, rtol=1e-14)
    np.testing.assert_array_equal(near, np.where(distances <= 0.3, numbers, -1))


def test_queries_of_another_dimension_are_refused():
    with Points(np.zeros((4, 3))) as tree, pytest.raises(ValueError, match="3 columns"):
        tree.nearest(np.zeros((2, 2)))


def test_points_that_are_not_finite_are_named():
    with pytest.raises(TugError, match="point 1 "):
        Points(np.array([[0.0, 0.0], [0.0, np.nan]]))


def test_the_nearest_source_is_the_one_whose_distance_it_is():
    vertices, triangles = patch(0.3)
    apart = np.concatenate([vertices, vertices[[0, 1, SIZE]] + [0, 0, 9]])
    with Mesh(apart, np.concatenate([triangles, [[169, 170, 171]]])) as mesh:
        sources = [5, MIDDLE, 160, MIDDLE]  # one of them twice
        nearest = mesh.nearest_sources(sources)
        each = np.array([mesh.distances([source]) for source in sources])
        least = mesh.distances(sources)
    here = np.arange(len(vertices))
    np.testing.assert_array_equal(nearest[here], np.argmin(each[:, here], axis=0))
    np.testing.assert_allclose(each[nearest[here], here], least[here])
    assert (nearest[len(vertices) :] == -1).all()
