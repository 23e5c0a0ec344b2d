# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a solve may start but cold: from the rotations of any pose, of a smaller dictionary, or of
the rows alone (F 20-24). The pose then is a function of the targets and of that start."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from . import native
from .geometry import Mesh, Rows, as_groups, as_shapes
from .objects import as_matrix
from .placing import check_parts, check_vertices, leaves_turn_open
from .solver import SolveInfo, Solver, solve_elastic_net


def find_rotations(
    mesh: Mesh, shapes: np.ndarray, groups: np.ndarray, positions: np.ndarray
) -> np.ndarray:
    """The rotations of any pose, #G by #S by k by k: those that best carry the shapes' edges to the
    pose's, group by group. positions: #V by k. O(#F #S)."""
    shapes, groups, k = as_shapes(mesh, shapes), as_groups(mesh, groups), mesh.dimension
    positions = np.ascontiguousarray(positions, np.float64)
    if positions.shape != (mesh.vertex_count, k):
        raise ValueError(f"positions must be {mesh.vertex_count} by {k}, not {positions.shape}")
    rotations = np.empty((int(groups.max(initial=-1)) + 1, len(shapes), k, k))
    native.library().tug_find_rotations(
        *(mesh._pointer, shapes, len(shapes), groups, len(rotations), positions, rotations)
    )
    return rotations


def solve_in_stages(solvers: Sequence[Solver], targets: np.ndarray) -> SolveInfo:
    """Solve on one dictionary after the other: the first solver starts cold, each later one from
    the rotations of the one before it. The models have the same shapes, groups and rows; the first
    has few weight functions, as four eigenfunctions, and the last those that show details."""
    if not solvers:
        raise ValueError("there is no solver: give those of one dictionary at least")
    info = solvers[0].solve(targets)
    for before, solver in pairwise(solvers):
        info = solver.solve(targets, before.rotations())
    return info


class RowStart:
    """A start without a pose, (F 20-23): the transforms of least squares of the rows alone on a
    small dictionary, smooth and, with a sparsity, with few entries; rigidity does not count yet.

    weights: #V by #W, few eigenfunctions as a rule. energies: #W by #W, the weight functions'
    Laplacian energies, or their diagonal: the squares of the eigenvalues. fit, smoothness and
    sparsity are beta_lc, beta_sm and beta_sp, lengths being parts of the rest shape's diagonal.
    """

    def __init__(
        self,
        mesh: Mesh,
        shapes: np.ndarray,
        weights: np.ndarray,
        energies: np.ndarray,
        rows: Rows,
        groups: np.ndarray,
        *,
        fit: float = 1.0,
        smoothness: float = 1e-3,
        sparsity: float = 0.0,
    ) -> None:
        self._mesh, self._shapes = mesh, as_shapes(mesh, shapes)
        self._groups = as_groups(mesh, groups)
        if not np.isfinite(self._shapes).all():
            raise ValueError("the shapes have coordinates that are not finite: repair them first")
        weights = as_matrix(weights, np.float64, rows=mesh.vertex_count)
        check_vertices(rows.vertices, mesh.vertex_count, "row")
        check_parts(mesh, weights, rows.vertices, "row")
        self._options = {"fit": fit, "smoothness": smoothness, "sparsity": sparsity}
        self._unit = float(np.linalg.norm(np.ptp(self._shapes[0], axis=0)))
        centred = (self._shapes - self._shapes.mean(axis=1, keepdims=True)) / self._unit
        columns = np.concatenate([np.ones((mesh.vertex_count, 1)), *centred], axis=1)
        self._dictionary = (weights[:, :, None] * columns[:, None, :]).reshape(len(columns), -1)
        energies = np.diag(energies) if np.ndim(energies) == 1 else np.asarray(energies)
        if energies.shape != 2 * weights.shape[1:]:
            raise ValueError(
                f"energies must be of the {weights.shape[1]} weight functions, not {energies.shape}"
            )
        self._penalty = np.kron(energies, np.eye(columns.shape[1]))
        self._held = np.zeros((len(rows), self._dictionary.shape[1]))
        of_row = np.repeat(np.arange(len(rows)), np.diff(rows.starts))
        np.add.at(self._held, of_row, rows.values[:, None] * self._dictionary[rows.vertices])

    def positions(self, targets: np.ndarray) -> np.ndarray:
        """#V by k, of the transforms' own pose. O(b^2 #H + b^3 + #V b). Raises ValueError where the
        targets leave open how the body is turned: rotations would be arbitrary."""
        targets = np.asarray(targets, np.float64)
        wanted = (len(self._held), self._mesh.dimension)
        if targets.shape != wanted or not np.isfinite(targets).all():
            raise ValueError(f"targets must be {wanted[0]} by {wanted[1]} finite coordinates")
        if leaves_turn_open(targets):
            raise ValueError(
                "the targets are on one line, or too few to place the body: add rows beside the "
                "line, or start without them"
            )
        middle = np.mean(targets, axis=0)
        scaled = (targets - middle) / self._unit
        transforms, _ = solve_elastic_net(self._held, scaled, self._penalty, **self._options)
        return middle + self._unit * (self._dictionary @ transforms)

    def rotations(self, targets: np.ndarray) -> np.ndarray:
        """#G by #S by k by k, of that pose: what Solver.solve starts from."""
        return find_rotations(self._mesh, self._shapes, self._groups, self.positions(targets))
