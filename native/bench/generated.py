# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of any size, made here: a closed tube with lobes, and examples of it."""

from __future__ import annotations

import numpy as np
from data import ExampleSet

LENGTH = 6.0


def tube(vertices: int, poses: int) -> ExampleSet:
    """About so many vertices; pose 0 is straight, the others are bent, twisted and bulged."""
    around = max(8, round(np.sqrt(vertices * 2 * np.pi / LENGTH)))
    rings = max(3, round((vertices - 2) / around))
    shapes = np.stack([bend(around, rings, number) for number in range(poses)])
    return ExampleSet(f"tube-{shapes.shape[1]}", shapes, wrap(around, rings))


def bend(around: int, rings: int, seed: int) -> np.ndarray:
    """The tube along a curve of its own: #V by 3. Seed 0 is straight."""
    random = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, rings + 2)
    waves = np.sin(np.pi * np.outer([1, 2, 3], x) / 2)
    amplitude = random.uniform(-1.5, 1.5, (3, 3)) * (seed > 0)
    frames = rotations((amplitude @ waves).T)
    forward = frames[:, :, 0]
    middles = 0.5 * (forward[1:] + forward[:-1]) * LENGTH / (rings + 1)
    curve = np.concatenate([np.zeros((1, 3)), np.cumsum(middles, axis=0)])
    angle = 2 * np.pi * np.arange(around) / around
    round_cap = np.sqrt(np.minimum(1.0, 8 * np.minimum(x, 1 - x)))
    bulge = 1.0 + random.uniform(-0.4, 0.4) * (seed > 0) * np.sin(np.pi * x) ** 2
    circle = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1)
    lobed = (1.0 + 0.15 * np.sin(3 * angle)[:, None]) * circle
    radius = round_cap * bulge
    body = [curve[i] + radius[i] * lobed @ frames[i].T for i in range(1, rings + 1)]
    return np.concatenate([curve[:1], *body, curve[-1:]])


def rotations(turns: np.ndarray) -> np.ndarray:
    """By Rodrigues' formula from rotation vectors, #T by 3, to #T by 3 by 3."""
    angle = np.linalg.norm(turns, axis=1)[:, None, None]
    axis = turns / np.maximum(angle[:, :, 0], 1e-300)
    zero = np.zeros(len(turns))
    x, y, z = axis.T
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def wrap(around: int, rings: int) -> np.ndarray:
    """Triangles of the tube: #F by 3."""
    here = np.arange(around)
    after = np.roll(here, -1)
    ring = 1 + around * np.arange(rings - 1)[:, None]
    a, b, c, d = (
        (ring + corner).ravel() for corner in (here, after, after + around, here + around)
    )
    last = 1 + around * (rings - 1)
    tip = np.full(around, last + around)
    parts = [
        np.stack([0 * here, 1 + after, 1 + here], axis=1),
        np.stack([a, b, c], axis=1),
        np.stack([a, c, d], axis=1),
        np.stack([last + here, last + after, tip], axis=1),
    ]
    return np.concatenate(parts).astype(np.int32)
