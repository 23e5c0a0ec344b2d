# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's three squares: dragging the right handle through the examples gives weights that are
piecewise linear in its position (Figure 2, rows a and b). A property of the handles' weights: other
functions let the square's parts move on their own."""

from __future__ import annotations

import numpy as np
import pytest

from addon.dictionaries import Dictionary
from addon.solver import Form, Solver, make_solver
from sample_scenes import squares


def weights_along_drag(form: Form) -> tuple[np.ndarray, np.ndarray]:
    """Mean blends (#steps by 3) and what they are expected to be."""
    sample = squares.sample()
    shapes = np.stack(list(sample.shapes.values()))[:, :, :2]
    handles = list(sample.handles.values())
    stops = shapes[:, handles[-1], 0]
    steps = np.linspace(stops[0], stops[-1], 201)
    options = {"dictionary": Dictionary.HANDLES, "form": form, "single_blend": True}
    solver: Solver = make_solver(shapes, sample.triangles(), handles, **options)
    targets, blends = shapes[0][handles], []
    for x in steps:
        targets[-1, 0] = x
        solver.solve(targets)
        blends.append(solver.blend().mean(axis=0))
    hats = [np.interp(steps, stops, hat) for hat in np.eye(3)]
    return np.array(blends), np.stack(hats, axis=1)


@pytest.mark.parametrize(("form", "tolerance"), [(Form.NO_ROTATIONS, 1e-6), (Form.STEADY, 1e-2)])
def test_weights_are_piecewise_linear(form, tolerance):
    blends, expected = weights_along_drag(form)
    np.testing.assert_allclose(blends, expected, atol=tolerance)
