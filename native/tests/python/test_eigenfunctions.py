# SPDX-License-Identifier: GPL-3.0-or-later
"""Eigenfunctions of the Laplace-Beltrami operator against SciPy's, on meshes made here."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from addon.solver import Mesh, Model, Rows, Solver
from addon.weights import cluster_by_eigenfunctions, compute_eigenfunctions

COUNT = 15


def grid(rows: int, columns: int) -> np.ndarray:
    """Triangles of a grid whose last row and column are the first ones again."""
    number = np.arange(rows * columns).reshape(rows, columns)
    below, right = np.roll(number, -1, 0), np.roll(number, -1, 1)
    diagonal = np.roll(below, -1, 1)
    faces = np.stack([number, below, diagonal, number, diagonal, right], -1)
    return faces.reshape(rows, columns, 2, 3)


def torus() -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (40, 20)), indexing="ij")
    radius = 2 + np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), np.sin(v)], -1)
    return vertices.reshape(-1, 3), grid(40, 20).reshape(-1, 3)


def plane() -> tuple[np.ndarray, np.ndarray]:
    """A square: most of its eigenvalues are there twice."""
    x, y = np.meshgrid(np.arange(25.0), np.arange(25.0), indexing="ij")
    return np.stack([x.ravel(), y.ravel()], -1), grid(25, 25)[:-1, :-1].reshape(-1, 3)


def sphere() -> tuple[np.ndarray, np.ndarray]:
    """An octahedron with each face cut in four, four times: eigenvalues in groups of 3, 5, 7."""
    vertices = [np.array(v, float) for v in np.concatenate([np.eye(3), -np.eye(3)])]
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    for _ in range(4):
        middles: dict[frozenset, int] = {}

        def middle(a: int, b: int, middles=middles) -> int:
            if frozenset((a, b)) not in middles:
                middles[frozenset((a, b))] = len(vertices)
                point = vertices[a] + vertices[b]
                vertices.append(point / np.linalg.norm(point))
            return middles[frozenset((a, b))]

        cut = []
        for a, b, c in faces:
            d, e, f = middle(a, b), middle(b, c), middle(c, a)
            cut += [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        faces = cut
    return np.array(vertices), np.array(faces)


def twice(shape: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The same mesh again, beside itself."""
    vertices, triangles = shape
    return np.concatenate([vertices, vertices + 10]), np.concatenate(
        [triangles, triangles + len(vertices)]
    )


def operator(vertices, triangles) -> tuple[scipy.sparse.csc_matrix, np.ndarray]:
    """Cotangent stiffness, and as mass the Voronoi areas in parts of the whole."""
    stiffness = scipy.sparse.csc_matrix((len(vertices), len(vertices)))
    for corner in range(3):
        o, a, b = (triangles[:, (corner + i) % 3] for i in range(3))
        u, v = vertices[a] - vertices[o], vertices[b] - vertices[o]
        dot = (u * v).sum(1)
        double_area = np.sqrt((u * u).sum(1) * (v * v).sum(1) - dot**2)
        half = 0.5 * dot / double_area
        entries = np.concatenate([half, half, -half, -half])
        places = (np.concatenate([a, b, a, b]), np.concatenate([a, b, b, a]))
        stiffness += scipy.sparse.csc_matrix((entries, places), shape=stiffness.shape)
    mass = voronoi_areas(vertices, triangles)
    return stiffness, mass / mass.sum()


def voronoi_areas(vertices, triangles) -> np.ndarray:
    """A corner's part of a triangle lies between the middles of its two sides and the centre of the
    circumscribed circle; where that is outside, half is the obtuse corner's, a quarter each
    other's."""
    areas = np.zeros(len(vertices))
    for triangle in triangles:
        a, b, c = vertices[triangle]
        u, v = b - a, c - a
        gram = np.array([[u @ u, u @ v], [u @ v, v @ v]])
        area = 0.5 * np.sqrt(np.linalg.det(gram))
        p, q = np.linalg.solve(gram, 0.5 * np.diag(gram))  # the centre is a + p u + q v
        if (inside := np.array([1 - p - q, p, q])).min() < 0:
            areas[triangle] += np.where(inside < 0, 0.5, 0.25) * area
            continue
        # Of the triangle between the centre and a side, each end of the side has half.
        areas[triangle] += 0.5 * area * (1 - inside)
    return areas


MESHES = {"torus": torus(), "plane": plane(), "sphere": sphere(), "two spheres": twice(sphere())}


@pytest.mark.parametrize("name", MESHES)
def test_scipy_finds_the_same_eigenpairs(name):
    vertices, triangles = MESHES[name]
    stiffness, mass = operator(vertices, triangles)
    with Mesh(vertices, triangles) as mesh:
        values, functions, info = compute_eigenfunctions(mesh, COUNT)
    theirs, their_functions = scipy.sparse.linalg.eigsh(
        stiffness, COUNT, M=scipy.sparse.diags(mass).tocsc(), sigma=-1.0, v0=np.cos(mass * 1e6)
    )
    np.testing.assert_allclose(values, theirs, rtol=1e-9, atol=1e-9 * values[-1])
    assert info.residual < 1e-9
    np.testing.assert_allclose(functions.T @ (mass[:, None] * functions), np.eye(COUNT), atol=1e-10)
    inside = values < values[-1] * (1 - 1e-6)  # the others are some of those of the last value
    product = their_functions.T @ (mass[:, None] * functions[:, inside])
    np.testing.assert_allclose(np.linalg.norm(product, axis=0), 1, atol=1e-8)


def test_a_sphere_has_spherical_harmonics():
    with Mesh(*sphere()) as mesh:
        values, _, _ = compute_eigenfunctions(mesh, 16)
    degrees = np.repeat([0, 1, 2, 3], [1, 3, 5, 7])
    np.testing.assert_allclose(values / (4 * np.pi), degrees * (degrees + 1), rtol=0.02)


def test_the_first_functions_are_constant_on_components():
    with Mesh(*twice(torus())) as mesh:
        values, functions, info = compute_eigenfunctions(mesh, 4)
        first = mesh.components() == 0
    assert info.constants == 2
    np.testing.assert_array_equal(values[:2], 0)
    np.testing.assert_allclose(functions[:, 0], 1)
    np.testing.assert_allclose(functions[:, 1], np.where(first, 1, -1) * functions[0, 1])


def test_groups_by_eigenfunctions_keep_components_apart():
    vertices, triangles = twice(sphere())
    with Mesh(vertices, triangles) as mesh:
        values, functions, _ = compute_eigenfunctions(mesh, 12)
        groups = cluster_by_eigenfunctions(mesh, values, functions, 6)
        two = cluster_by_eigenfunctions(mesh, values[:2], functions[:, :2], 6)
    half = len(triangles) // 2
    assert groups.max() == 5
    assert not set(groups[:half]) & set(groups[half:])
    assert (set(two[:half]), set(two[half:])) in (({0}, {1}), ({1}, {0}))


def test_a_pose_follows_from_eigenfunctions():
    vertices, triangles = torus()
    bent = vertices * [1.3, 0.8, 1.0] + [0, 0, 0.1] * vertices[:, :1] ** 2
    handles = [0, 210, 400, 610]
    with Mesh(vertices, triangles) as mesh:
        values, functions, _ = compute_eigenfunctions(mesh, 10)
        groups = cluster_by_eigenfunctions(mesh, values, functions, 8)
        shapes = np.stack([vertices, bent])
        with (
            Model(mesh, shapes, functions, Rows.pin(handles), groups) as model,
            Solver(model) as solver,
        ):
            assert solver.solve(bent[handles]).converged
            np.testing.assert_allclose(solver.positions(), bent, atol=1e-4)
