# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing and easing tools of the sculpted shapes. NumPy only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .implicit import Cone, Field, gradient


def edges_of(faces: Sequence[Sequence[int]]) -> np.ndarray:
    """#E by 2, every edge once."""
    pairs = np.concatenate(
        [np.stack([f, np.roll(f, -1)], axis=1) for f in (np.asarray(face) for face in faces)]
    )
    return np.unique(np.sort(pairs, axis=1), axis=0)


def components(edges: np.ndarray, count: int) -> np.ndarray:
    """#V: for each of `count` vertices the lowest vertex that edges connect it with."""
    label = np.arange(count)
    while True:
        lower = label.copy()
        np.minimum.at(lower, edges, label[edges[:, ::-1]])
        lower = lower[lower]
        if np.array_equal(lower, label):
            return label
        label = lower


def smoothed(values: np.ndarray, edges: np.ndarray, rounds: int, step: float = 0.5) -> np.ndarray:
    """`values` (#V by d), each moved `rounds` times towards the mean of its neighbours."""
    ends = np.concatenate([edges, edges[:, ::-1]])
    degree = np.bincount(ends[:, 0], minlength=len(values))[:, None]
    for _ in range(rounds):
        columns = [
            np.bincount(ends[:, 0], weights=column[ends[:, 1]], minlength=len(values))
            for column in values.T
        ]
        values = values + step * (np.stack(columns, axis=1) / degree - values)
    return values


def settle(vertices: np.ndarray, edges: np.ndarray, field: Field, rounds: int) -> np.ndarray:
    """Evens the mesh out by smoothing while it stays on the zero level of `field`."""
    for _ in range(rounds):
        vertices = smoothed(vertices, edges, 1)
        slope = gradient(field, vertices)
        steepness = np.maximum(np.sum(slope**2, axis=1, keepdims=True), 1e-3)
        vertices = vertices - field(vertices)[:, None] * slope / steepness
    return vertices


def skin_weights(
    parts: Sequence[Sequence[Cone]], vertices: np.ndarray, edges: np.ndarray
) -> np.ndarray:
    """#V by #parts: the share each part has in the surface there, spread over the joints."""
    near = np.stack(
        [
            np.min([cone.distance(vertices) for cone in cones if not cone.carved], axis=0)
            for cones in parts
        ],
        axis=1,
    )
    share = np.exp(-(near - near.min(axis=1, keepdims=True)) / 0.02)
    share = smoothed(share / share.sum(axis=1, keepdims=True), edges, 14)
    return share / share.sum(axis=1, keepdims=True)


def bump(distance: np.ndarray, radius: float) -> np.ndarray:
    """1 at distance 0, 0 from `radius` on, smooth in between."""
    inside = np.clip(1.0 - (distance / radius) ** 2, 0.0, 1.0)
    return inside**2


def smoothstep(low: float, high: float, x: np.ndarray) -> np.ndarray:
    """0 up to `low`, 1 from `high` on (or the reverse when low > high), smooth in between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
