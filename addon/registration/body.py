# SPDX-License-Identifier: GPL-3.0-or-later
"""What is posed, whatever holds it: all of a model but its rows.

Fitting to data needs several sets of rows on the same shapes. A Body keeps what they share; every
function that takes one works with its dictionary and with the energy that its options name.
"""

from __future__ import annotations

import numpy as np

from ..dictionaries import Dictionary, Functions, make_functions
from ..geometry import Mesh, Rows
from ..native import Progress, part
from ..solver import Model, Solver

# Twice as many as a pose needs: what is far from all examples, a curled-up body with its legs in
# question, is told by how single parts turn.
GROUPS = 30


class Body:
    """Shapes of a mesh, and weight functions with their groups.

    shapes: #S by #V by k, the rest shape first. triangles: #F by 3. functions: eigenfunctions where
    they are None. stiffness and smoothness are those of Model, options those of Solver, `form` for
    one. O(#V (#W #S k)^2), a second at 20,000 vertices.
    """

    def __init__(
        self,
        shapes: np.ndarray,
        triangles: np.ndarray,
        functions: Functions | None = None,
        *,
        stiffness: np.ndarray | None = None,
        smoothness: float = 0.0,
        progress: Progress | None = None,
        **options: float,
    ) -> None:
        self.shapes = np.ascontiguousarray(shapes, np.float64)
        if self.shapes.ndim != 3 or not len(self.shapes):
            raise ValueError(f"shapes must be #S by #V by k, not {self.shapes.shape}")
        if not np.isfinite(self.shapes).all():
            raise ValueError("the shapes have coordinates that are not finite: repair them first")
        self.mesh = Mesh(self.shapes[0], triangles)
        if report := self._errors():
            raise ValueError(report)
        self.triangles = np.ascontiguousarray(triangles, np.int32)
        self.functions = functions or make_functions(
            *(Dictionary.EIGENFUNCTIONS, self.mesh, self.shapes, ()),
            group_count=GROUPS,
            progress=part(progress, 0.0, 0.6),
        )
        self.options = options
        # One vertex of each part: rows that serve until others take their place.
        anywhere = Rows.pin(np.unique(self.mesh.components(), return_index=True)[1])
        self._model = Model(
            *(self.mesh, self.shapes, self.functions.weights, anywhere, self.functions.groups),
            stiffness=stiffness,
            smoothness=smoothness,
            progress=part(progress, 0.6, 1.0),
        )

    @property
    def rest(self) -> np.ndarray:
        """#V by k."""
        return self.shapes[0]

    def solver(self, rows: Rows, firmness: np.ndarray | None = None) -> Solver:
        """A solver that holds the body by these rows: pinned, or softly and as many as wanted where
        they have a firmness, #H (see tug_change_rows). Some tens of milliseconds."""
        with self._model.change_rows(rows, firmness) as model:
            return Solver(model, **self.options)

    def _errors(self) -> str:
        report = self.mesh.check()
        return "\n".join(report.text.splitlines()[: report.errors])
