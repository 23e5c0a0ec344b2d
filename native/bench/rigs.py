# SPDX-License-Identifier: GPL-3.0-or-later
"""What all methods on the same shapes and handles share, each made when it is first asked for."""

from __future__ import annotations

from typing import Self

import numpy as np
from library import Dictionary, Functions, Mesh, Model, Rows, make_functions


class Rig:
    """Shapes (#S by #V by k, the rest shape first), triangles and handle vertices, with the
    functions of every dictionary on them and a model of each, whose rows pin the handles."""

    def __init__(self, shapes: np.ndarray, triangles: np.ndarray, handles: np.ndarray) -> None:
        self.shapes, self.triangles, self.handles = shapes, triangles, handles
        self.diagonal = float(np.linalg.norm(np.ptp(shapes[0], axis=0)))
        self._functions: dict[Dictionary, Functions] = {}
        self._models: dict[Dictionary, Model] = {}

    def with_shapes(self, shapes: np.ndarray) -> Self:
        """Other shapes, the rest shape excepted: only a skeleton sees these."""
        other = Rig(shapes, self.triangles, self.handles)
        other._functions = {
            kind: functions
            for kind, functions in self._functions.items()
            if kind is not Dictionary.SKELETON
        }
        return other

    def functions(self, kind: Dictionary) -> Functions:
        """Weights and groups as a user of the library gets them by default."""
        if kind not in self._functions:
            with Mesh(self.shapes[0], self.triangles) as mesh:
                self._functions[kind] = make_functions(kind, mesh, self.shapes, self.handles)
        return self._functions[kind]

    def model(self, kind: Dictionary) -> Model:
        """Lives as long as the rig, or a solver on it."""
        if kind not in self._models:
            functions = self.functions(kind)
            given = (self.shapes, functions.weights, Rows.pin(self.handles), functions.groups)
            with Mesh(self.shapes[0], self.triangles) as mesh:
                self._models[kind] = Model(mesh, *given)
        return self._models[kind]
