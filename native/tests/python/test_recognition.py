# SPDX-License-Identifier: GPL-3.0-or-later
"""The handle positions of an example and nothing else give that example, on the meshes of AMRAP's
Table 1. They are not part of the project: TUG_DATA names their folder, or they are not tested."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from addon.solver import Mesh, Solver, make_solver

DATA = Path(os.environ.get("TUG_DATA", Path(__file__).resolve().parents[4] / "shared" / "data"))
TABLE = {"lion": (6, 7), "horse": (3, 10), "cat": (6, 7)}  # shapes, handles


def load(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Poses (#S by #V by 3) and triangles."""
    path = DATA / f"{name}.npz"
    if not path.exists():
        pytest.skip(f"not run: there is no {name}.npz in the folder TUG_DATA")
    with np.load(path) as file:
        return file["verts"][: TABLE[name][0]].astype(float), file["faces"]


@pytest.fixture(scope="module", params=TABLE)
def case(request) -> tuple[np.ndarray, list[int], Solver]:
    shapes, triangles = load(request.param)
    with Mesh(shapes[0], triangles) as mesh:
        handles = mesh.spread(TABLE[request.param][1]).tolist()
    return shapes, handles, make_solver(shapes, triangles, handles)


def test_every_example_is_recognised(case):
    shapes, handles, solver = case
    diagonal = np.linalg.norm(np.ptp(shapes[0], axis=0))
    for number, shape in enumerate(shapes):
        info = solver.solve(shape[handles])
        error = np.linalg.norm(solver.positions() - shape, axis=1).max()
        assert info.converged
        assert solver.blend()[:, number].mean() >= 0.98
        # An example is in the span of the dictionary: the model's own projection error is zero.
        assert error <= 1e-4 * diagonal


def test_the_pose_does_not_depend_on_the_drag(case):
    shapes, handles, solver = case
    first, second = shapes[0][handles], shapes[1][handles]
    solver.solve(0.5 * (first + second))
    cold = solver.positions()
    for share in np.random.default_rng(0).random(20):
        solver.solve(share * first + (1 - share) * second)
    solver.solve(0.5 * (first + second))
    np.testing.assert_array_equal(solver.positions(), cold)
