# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex groups as a matrix: one column of weights for each handle."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

# Weights below it are not stored: a group would otherwise list every vertex of the mesh.
NEGLIGIBLE = 1e-6


def read(obj: bpy.types.Object, names: Sequence[str]) -> np.ndarray:
    """#V by len(names) float32, 0 where a vertex is not in the group. About 1 us a weight."""
    if not names:
        return np.zeros((len(obj.data.vertices), 0), np.float32)
    column = {obj.vertex_groups[name].index: number for number, name in enumerate(names)}
    weights = np.zeros((len(obj.data.vertices), len(names)), np.float32)
    for row, vertex in enumerate(obj.data.vertices):
        for element in vertex.groups:
            number = column.get(element.group)
            if number is not None:
                weights[row, number] = element.weight
    return weights


def rounded(weights: np.ndarray) -> np.ndarray:
    """What `read` gives after `write`."""
    stored = np.asarray(weights, np.float32)
    return np.where(stored < NEGLIGIBLE, np.float32(0), stored)


def write(obj: bpy.types.Object, names: Sequence[str], weights: np.ndarray) -> None:
    """Make or overwrite a group for each column of `weights`, which is as `rounded` gives it."""
    everything = range(len(obj.data.vertices))
    for name, column in zip(names, weights.T, strict=True):
        if group := obj.vertex_groups.get(name):
            group.remove(everything)
        else:
            group = obj.vertex_groups.new(name=name)
        for row in np.flatnonzero(column).tolist():
            group.add((row,), float(column[row]), "REPLACE")
