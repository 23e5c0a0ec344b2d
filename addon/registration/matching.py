# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points that face the same way."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..geometry import Points


class OrientedPoints:
    """Points of a surface and its normals there, both #P by 3.

    reach: what is farther is not near. angle: nor what faces another way by more, in degrees below
    90; None: normals, which may then be None too, do not matter.
    """

    def __init__(
        self, points: np.ndarray, normals: np.ndarray | None, reach: float, angle: float | None
    ) -> None:
        self.points, self.normals, self.reach, self.angle = points, normals, reach, angle

    def nearest(self, others: OrientedPoints) -> tuple[np.ndarray, np.ndarray]:
        """For each of the others the number of the nearest point and the distance to it, -1 and inf
        where there is none."""
        numbers, _ = self._tree.nearest(others._places, self._limit)
        distances = np.linalg.norm(self.points[numbers] - others.points, axis=1)
        good = (numbers >= 0) & (distances <= self.reach)
        if self.angle is not None:
            cosines = np.sum(self.normals[numbers] * others.normals, axis=1)
            good &= cosines >= np.cos(np.radians(self.angle))
        return np.where(good, numbers, -1), np.where(good, distances, np.inf)

    def mutual(self, others: OrientedPoints, spacing: float) -> tuple[np.ndarray, np.ndarray]:
        """The same, without those whose point is much nearer to another of the others.

        A point at the edge of a scan is the nearest to all that is missing beyond it, but that is
        not what lies nearest to the point. spacing: about how far points are from their neighbours.
        """
        numbers, distances = self.nearest(others)
        some = np.flatnonzero(numbers >= 0)
        if not len(some):
            return numbers, distances
        met, place = np.unique(numbers[some], return_inverse=True)
        back, _ = others.nearest(self._part(met))
        slip = np.linalg.norm(others.points[back[place]] - others.points[some], axis=1)
        stray = some[slip > 0.5 * distances[some] + spacing]
        numbers[stray], distances[stray] = -1, np.inf
        return numbers, distances

    def _part(self, numbers: np.ndarray) -> OrientedPoints:
        normals = None if self.angle is None else self.normals[numbers]
        return OrientedPoints(self.points[numbers], normals, self.reach, self.angle)

    @cached_property
    def _tree(self) -> Points:
        return Points(self._places)

    @property
    def _places(self) -> np.ndarray:
        """In six dimensions, where points that face other ways are not near."""
        if self.angle is None:
            return self.points
        return np.hstack([self.points, self.reach * self.normals])

    @property
    def _limit(self) -> float:
        if self.angle is None:
            return self.reach
        return self.reach * np.hypot(1, 2 * np.sin(np.radians(self.angle) / 2))
