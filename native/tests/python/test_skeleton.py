# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of a skinned creature, found in its poses alone."""

from __future__ import annotations

import numpy as np
import pytest

from addon.native import TugError
from addon.solver import Mesh, Model, Rows, Solver
from addon.weights import cluster_triangles, find_skeleton

AROUND, RINGS = 12, 16
LIMBS = 4


def rotation(random: np.random.Generator, most: float) -> np.ndarray:
    """About a random axis, by up to `most` radians."""
    axis = random.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = random.uniform(-most, most)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def creature() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, triangles and true weights of a body with four limbs: tubes that come from it in
    directions of their own, weighted to their limb towards their ends. One component each."""
    u, v = np.meshgrid(np.linspace(0, 1, RINGS), np.arange(AROUND), indexing="ij")
    angle = 2 * np.pi * v / AROUND
    tube = np.stack([0.5 + 3 * u, 0.3 * np.cos(angle), 0.3 * np.sin(angle)], -1).reshape(-1, 3)
    ramp = np.clip((u.ravel() - 0.3) / 0.3, 0, 1)
    number = np.arange(RINGS * AROUND).reshape(RINGS, AROUND)
    a, b = number[:-1], np.roll(number, -1, 1)[:-1]
    c, d = b + AROUND, a + AROUND
    faces = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    vertices, triangles, weights = [], [], []
    for limb in range(LIMBS):
        turn = limb * np.pi / 2
        spin = np.array(
            [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        )
        weight = np.zeros((len(tube), LIMBS + 1))
        weight[:, 0], weight[:, 1 + limb] = 1 - ramp, ramp
        vertices.append(tube @ spin.T)
        triangles.append(faces + limb * len(tube))
        weights.append(weight)
    return np.concatenate(vertices), np.concatenate(triangles), np.concatenate(weights)


@pytest.fixture(scope="module")
def poses():
    """Shapes, the creature at rest first; triangles; weights that made them."""
    random = np.random.default_rng(4)
    vertices, triangles, weights = creature()
    joints = np.array([[0, 0, 0]] + [vertices[weights[:, 1 + i] > 0].mean(0) for i in range(LIMBS)])
    shapes = [vertices]
    for _ in range(5):
        body = rotation(random, 1)
        bones = [body] + [body @ rotation(random, 1.5) for _ in range(LIMBS)]
        moved = [
            (vertices - joint) @ bone.T + joint @ body.T
            for bone, joint in zip(bones, joints, strict=True)
        ]
        shapes.append(np.einsum("vj,jva->va", weights, moved))
    return np.array(shapes), triangles, weights


def test_the_weights_of_a_creature_are_found_again(poses):
    shapes, triangles, truth = poses
    with Mesh(shapes[0], triangles) as mesh:
        weights, info = find_skeleton(mesh, shapes, LIMBS + 1, smoothness=1e-8)
    assert weights.shape == truth.shape
    assert info.error < 0.01
    order = (weights.T @ truth).argmax(axis=0)
    assert sorted(order) == list(range(LIMBS + 1))
    assert np.abs(weights[:, order] - truth).mean() < 0.01


def test_smoother_weights_fit_less(poses):
    shapes, triangles, _ = poses
    with Mesh(shapes[0], triangles) as mesh:
        found = [find_skeleton(mesh, shapes, 8, smoothness=s) for s in (1e-7, 1e-4)]
    assert found[0][1].error < found[1][1].error
    edges = [np.abs(w[triangles] - w[np.roll(triangles, 1, 1)]).max() for w, _ in found]
    assert edges[0] > edges[1]


def test_what_cannot_be_is_refused(poses):
    shapes, triangles, _ = poses
    with Mesh(shapes[0], triangles) as mesh:
        with pytest.raises(ValueError, match="shapes must be"):
            find_skeleton(mesh, shapes[:, :-1], 5)
        with pytest.raises(TugError, match="0 bones"):
            find_skeleton(mesh, shapes, 0)
        with pytest.raises(TypeError, match="unknown option"):
            find_skeleton(mesh, shapes, 5, sharpness=1)


def test_a_pose_between_the_examples_follows_its_handles(poses):
    shapes, triangles, _ = poses
    examples, truth = shapes[:-1], shapes[-1]
    with Mesh(shapes[0], triangles) as mesh:
        handles = mesh.spread(16)
        weights, _ = find_skeleton(mesh, examples, LIMBS + 1)
        groups = cluster_triangles(mesh, weights, 10)
        with (
            Model(mesh, examples, weights, Rows.pin(handles), groups) as model,
            Solver(model) as solver,
        ):
            assert solver.solve(truth[handles]).converged
            assert np.linalg.norm(solver.positions() - truth, axis=1).mean() < 0.15
