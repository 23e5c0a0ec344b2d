# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth unions of round cones and their surface as a quad mesh (surface nets). NumPy only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Field = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Cone:
    """A ball swept from `start` to `end` while its radius changes; `flatten` shrinks it per axis.

    blend:  width of the fillet with what it is added to
    carved: taken away instead of added
    """

    start: Sequence[float]
    end: Sequence[float]
    radii: tuple[float, float]
    flatten: Sequence[float] = (1.0, 1.0, 1.0)
    blend: float = 0.08
    carved: bool = False

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance of `points` (#P by 3), negative inside; exact only for equal radii."""
        stretch = np.asarray(self.flatten)
        offset = (points - np.asarray(self.start)) * stretch
        axis = (np.asarray(self.end) - np.asarray(self.start)) * stretch
        along = np.clip(offset @ axis / max(axis @ axis, 1e-12), 0.0, 1.0)
        radius = self.radii[0] + (self.radii[1] - self.radii[0]) * along
        return np.linalg.norm(offset - along[:, None] * axis, axis=1) - radius


def smooth_min(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """The lower of two distances, rounded where they differ by less than `width`."""
    overlap = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - 0.25 * width * overlap**2


def union(cones: Sequence[Cone]) -> Field:
    """The cones merged one after the other, carved ones taken away; nothing below the ground."""

    def field(points: np.ndarray) -> np.ndarray:
        distance = cones[0].distance(points)
        for cone in cones[1:]:
            if cone.carved:
                distance = -smooth_min(-distance, cone.distance(points), cone.blend)
            else:
                distance = smooth_min(distance, cone.distance(points), cone.blend)
        return -smooth_min(-distance, points[:, 2], 0.04)

    return field


def surface_nets(
    field: Field, low: Sequence[float], high: Sequence[float], spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """The zero level of `field` in a box: vertices #V by 3 and quads #F by 4, seen from outside.

    One vertex per grid cell that the surface passes through, at the mean of its edge crossings.
    """
    axes = [np.arange(a, b + spacing, spacing) for a, b in zip(low, high, strict=True)]
    shape = tuple(len(axis) for axis in axes)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = field(grid.reshape(-1, 3)).reshape(shape)
    cells = tuple(n - 1 for n in shape)
    total, count = np.zeros((*cells, 3)), np.zeros(cells)
    quads = []
    for axis in range(3):
        here, there = _pair(values, axis)
        crossing = (here < 0) != (there < 0)
        share = np.where(crossing, here / np.where(crossing, here - there, 1.0), 0.0)
        point = np.take(grid, range(shape[axis] - 1), axis)
        point = point + share[..., None] * spacing * np.eye(3)[axis]
        _scatter(total, count, crossing, point, axis)
        quads.append(_quads(crossing, here < 0, cells, axis))
    used = count > 0
    index = np.cumsum(used.ravel()) - 1
    vertices = total[used] / count[used][:, None]
    return vertices, index[np.concatenate(quads)]


def _pair(values: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """The values at the two ends of every grid edge along `axis`."""
    n = values.shape[axis]
    return np.take(values, range(n - 1), axis), np.take(values, range(1, n), axis)


def _scatter(
    total: np.ndarray, count: np.ndarray, crossing: np.ndarray, point: np.ndarray, axis: int
) -> None:
    """Adds each crossing on an edge along `axis` to the (up to four) cells around the edge."""
    across = [a for a in range(3) if a != axis]
    for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
        window = [slice(None)] * 3
        for a, c in zip(across, corner, strict=True):
            window[a] = slice(c, c + count.shape[a])
        seen = crossing[tuple(window)]
        total += np.where(seen[..., None], point[tuple(window)], 0.0)
        count += seen


def _quads(
    crossing: np.ndarray, inside_first: np.ndarray, cells: tuple[int, ...], axis: int
) -> np.ndarray:
    """One quad of flat cell numbers per crossed edge along `axis`, wound outwards."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    edge = np.argwhere(crossing)
    corners = []
    for du, dv in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
        cell = edge.copy()
        cell[:, u] += du
        cell[:, v] += dv
        corners.append(np.ravel_multi_index(tuple(cell.T), cells))
    quads = np.stack(corners, axis=1)
    outward = inside_first[crossing]
    return np.where(outward[:, None], quads, quads[:, ::-1])


def gradient(field: Field, points: np.ndarray, step: float = 1e-4) -> np.ndarray:
    """#P by 3, the gradient of `field` by central differences."""
    shifts = step * np.eye(3)
    columns = [(field(points + s) - field(points - s)) / (2 * step) for s in shifts]
    return np.stack(columns, axis=1)
