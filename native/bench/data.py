# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets of example poses from a folder of .npz files; and how handles are put on them.

A file holds `verts` (poses by #V by k) and `faces` (#F by 3) or `quads` (#Q by 4).
"""

from __future__ import annotations

import os
import zipfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
from library import CHECKOUT, Mesh


class MissingDataError(Exception):
    """There is no folder of meshes, not the set that was asked for, or its file cannot be used."""


@dataclass(frozen=True)
class ExampleSet:
    """Poses of one mesh: shapes is #P by #V by k, every vertex is in a triangle."""

    name: str
    shapes: np.ndarray
    triangles: np.ndarray

    @cached_property
    def diagonal(self) -> float:
        """Of the first pose's bounding box."""
        return float(np.linalg.norm(np.ptp(self.shapes[0], axis=0)))

    def first(self, poses: int | None) -> Self:
        """With at most so many poses."""
        return self if poses is None else replace(self, shapes=self.shapes[:poses])

    def spread_handles(self, count: int) -> np.ndarray:
        """Farthest points along the edges of the first pose, from vertex 0."""
        with Mesh(self.shapes[0], self.triangles) as mesh:
            return mesh.spread(count)


def default_folder() -> Path:
    """$TUG_DATA, else shared/data beside the checkout; it may be absent."""
    return Path(os.environ.get("TUG_DATA") or CHECKOUT.parent / "shared" / "data")


def set_names(folder: Path) -> list[str]:
    """All sets of a folder. Raises MissingDataError where there is none."""
    if not folder.is_dir():
        raise MissingDataError(f"there is no folder {folder}: name that of the meshes by TUG_DATA")
    names = sorted(path.stem for path in folder.glob("*.npz"))
    if not names:
        raise MissingDataError(f"no .npz files in {folder}: name the folder with them by TUG_DATA")
    return names


def load(folder: Path, name: str) -> ExampleSet:
    """One set, without vertices that are in no face. Raises MissingDataError where the folder does
    not have it, or something else under its name."""
    path = folder / f"{name}.npz"
    if not path.is_file():
        raise MissingDataError(
            f"no set {name} in {folder}; there are: {', '.join(set_names(folder))}"
        )
    try:
        with np.load(path) as file:
            shapes = file["verts"].astype(np.float64)
            triangles = file["faces"] if "faces" in file else triangulate(file["quads"])
    except (OSError, EOFError, zipfile.BadZipFile, KeyError, ValueError) as error:
        raise MissingDataError(f"{path} is no set of poses: {error}") from error
    if shapes.ndim != 3 or shapes.shape[2] not in (2, 3) or triangles.shape[1:] != (3,):
        raise MissingDataError(
            f"{path} is no set of poses: verts must be poses by vertices by 2 or 3, faces by 3"
        )
    used, numbers = np.unique(triangles, return_inverse=True)
    if used[0] < 0 or used[-1] >= shapes.shape[1]:
        raise MissingDataError(f"{path} is no set of poses: its faces name vertices it lacks")
    triangles = numbers.reshape(triangles.shape).astype(np.int32)
    return ExampleSet(name, np.ascontiguousarray(shapes[:, used]), triangles)


def triangulate(quads: np.ndarray) -> np.ndarray:
    """Two triangles for each quad."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
