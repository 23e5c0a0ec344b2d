# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sample scene is: a mesh, its example shapes, its handles and their motion. NumPy only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

BASIS = "Basis"
LAST_FRAME = 48


@dataclass(frozen=True)
class Waypoint:
    """At `frame` the handles stand where `shape` has them, some of them moved by `offsets`."""

    frame: int
    shape: str
    offsets: Mapping[str, Sequence[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Sample:
    """A scene as arrays.

    faces:   polygons of three or more vertices, each a sequence of vertex indices
    shapes:  name -> #V by 3, the first named "Basis": the rest pose
    handles: name -> vertex
    motion:  waypoints by rising frame
    colors:  #V by 3, linear RGB in 0..1, or None
    view:    azimuth and elevation in degrees of whoever looks at it; azimuth 0 looks along +Y
    y_up:    the arrays have Y upwards; the object is turned, not they
    single_blend: the rig blends the whole mesh as one
    """

    name: str
    faces: Sequence[Sequence[int]]
    shapes: Mapping[str, np.ndarray]
    handles: Mapping[str, int]
    motion: Sequence[Waypoint]
    colors: np.ndarray | None = None
    view: tuple[float, float] = (0.0, 0.0)
    y_up: bool = False
    single_blend: bool = False

    @property
    def rest(self) -> np.ndarray:
        """#V by 3, the rest pose."""
        return self.shapes[BASIS]

    def triangles(self) -> np.ndarray:
        """#F by 3 int32: every polygon as a fan around its first vertex."""
        fans = [(f[0], f[i], f[i + 1]) for f in self.faces for i in range(1, len(f) - 1)]
        return np.array(fans, dtype=np.int32)

    def handle_positions(self, waypoint: Waypoint) -> dict[str, np.ndarray]:
        """Where each handle stands at a waypoint, in the space of the shapes."""
        shape = self.shapes[waypoint.shape]
        zero = np.zeros(3)
        return {
            name: shape[vertex] + np.asarray(waypoint.offsets.get(name, zero))
            for name, vertex in self.handles.items()
        }


def nearest_vertex(points: np.ndarray, target: Sequence[float]) -> int:
    """The vertex of `points` (#V by 3) closest to `target`; the lowest index wins a tie."""
    # Rounding keeps a symmetric pair a tie whatever the last bits of the platform's arithmetic.
    squared = np.sum((points - np.asarray(target)) ** 2, axis=1)
    return int(np.argmin(np.round(squared, 9)))


def nearest_pair(name: str, points: np.ndarray, target: Sequence[float]) -> dict[str, int]:
    """Handles `name`.L at `target` and `name`.R opposite in X."""
    mirror = (-target[0], *target[1:])
    return {
        f"{name}.L": nearest_vertex(points, target),
        f"{name}.R": nearest_vertex(points, mirror),
    }


def grid_quads(columns: int, rows: int) -> list[tuple[int, int, int, int]]:
    """Quads of a grid of `columns` x `rows` vertices numbered row by row."""
    return [
        (j * columns + i, j * columns + i + 1, (j + 1) * columns + i + 1, (j + 1) * columns + i)
        for j in range(rows - 1)
        for i in range(columns - 1)
    ]
