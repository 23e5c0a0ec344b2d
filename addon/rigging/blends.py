# SPDX-License-Identifier: GPL-3.0-or-later
"""Which examples the last pose is made of, around a handle and over the whole mesh."""

from __future__ import annotations

import bpy
import numpy as np

from . import inputs, live


def around(obj: bpy.types.Object, empty: bpy.types.Object) -> tuple[list[str], np.ndarray]:
    """Names of the examples, and the weight of each around a handle: #S, of sum one. Both are empty
    before the first pose."""
    solved = _solved(obj)
    vertex = next((h.vertex for h in obj.tug.handles if h.empty == empty), None)
    if solved is None or vertex is None:
        return [], np.zeros(0)
    return inputs.bound_examples(obj), solved.shares[vertex] @ solved.blend()


def example_colours(obj: bpy.types.Object, colours: np.ndarray) -> np.ndarray | None:
    """#V by 3: the colours of the examples (#S by 3), mixed as in the last pose; None before it."""
    solved = _solved(obj)
    return None if solved is None else solved.shares @ (solved.blend() @ colours)


def group_count(obj: bpy.types.Object) -> int:
    solved = _solved(obj)
    return 0 if solved is None else solved.solver.sizes.groups


def group_colours(obj: bpy.types.Object, colours: np.ndarray) -> np.ndarray | None:
    """#V by 3: the colours of the edge groups (#G by 3), each vertex between those it touches."""
    solved = _solved(obj)
    return None if solved is None else solved.shares @ colours


def _solved(obj: bpy.types.Object) -> live.Live | None:
    known = live.known(obj)
    return known if known is not None and known.last is not None else None
