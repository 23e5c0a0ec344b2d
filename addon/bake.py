# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the poses of rigs to PC2 files and show them through the Mesh Cache modifier.

Also a script: `blender -b scene.blend --python-exit-code 1 --python bake.py -- --output FILE`, or
`python bake.py scene.blend --output FILE` where bpy is installed; `cli` has the rest.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import bpy
import numpy as np


def _package() -> str:
    """The package of this file: the one that is registered, else loaded from this folder."""
    registered = bpy.types.PropertyGroup.bl_rna_get_subclass_py("TUG_PG_rig")
    if registered is not None:
        return registered.__module__.rpartition(".")[0]
    folder = Path(__file__).resolve().parent
    spec = importlib.util.spec_from_file_location(
        "tug", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    package = sys.modules["tug"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    package.register()
    return "tug"


if __name__ == "__main__":
    sys.exit(importlib.import_module(f"{_package()}.cli").main())
else:
    from .caches import film, pc2
    from .native import Progress
    from .rigging import live, rig, shape_keys
    from .rigging.inputs import RigError
    from .smoothing import Solution, average
    from .smoothing import reach as smoothing_reach


def bake(
    obj: bpy.types.Object,
    first: int,
    last: int,
    path: str | Path,
    progress: Progress | None = None,
    *,
    smoothing: float = 0.0,
) -> Path:
    """Bake frames first to last of one rig; see `bake_rigs`."""
    return bake_rigs({obj: path}, first, last, progress, smoothing=smoothing)[0]


def bake_rigs(
    paths: Mapping[bpy.types.Object, str | Path],
    first: int,
    last: int,
    progress: Progress | None = None,
    *,
    smoothing: float = 0.0,
) -> list[Path]:
    """Bake frames first to last, both included, of each rig to its PC2 file.

    A file holds what the rig shows, keys that add on top included, and appears whole or not at all.
    A modifier is then set up to show frame f of it at frame f. Paths may start with // for the
    folder of the .blend file. An exception that `progress` raises cancels the bake.

    smoothing: 0, or the standard deviation, in frames, of the Gaussian that blends and rotations
    are averaged with over time. Handles are met as exactly as without. Each frame is solved on its
    own, those around the range too, so that pieces of a range still agree with the whole.
    """
    make = _films(paths, smoothing)
    return film.shoot(paths, first, last, make, progress, reach=smoothing_reach(smoothing))


def roll_rigs(
    paths: Mapping[bpy.types.Object, str | Path], first: int, last: int, *, smoothing: float = 0.0
) -> Iterator[tuple[str, float]]:
    """`bake_rigs`, a frame each time it is asked for the next: see film.roll."""
    make = _films(paths, smoothing)
    return film.roll(paths, first, last, make, reach=smoothing_reach(smoothing))


def _films(
    rigs: Iterable[bpy.types.Object], smoothing: float
) -> Callable[[bpy.types.Object, pc2.Writer], _Film]:
    """What makes a film of each. Raises RigError where one of the rigs is stale."""
    if not 0 <= smoothing < math.inf:
        raise RigError(f"the smoothing is {smoothing:g} frames: it must be 0 or more")
    for obj in rigs:
        live.touch(obj)
        live.current(obj, bpy.context.scene)
    return lambda obj, writer: _Film(obj, writer, smoothing)


class _Film:
    """One rig's frames: each is written when those that it is averaged with have been visited."""

    def __init__(self, obj: bpy.types.Object, writer: pc2.Writer, smoothing: float) -> None:
        self.obj, self.writer, self.smoothing = obj, writer, smoothing
        self.reach = smoothing_reach(smoothing)
        # The last 2 reach + 1 frames: solutions, and what is added on top of them.
        self.window: deque[tuple[Solution, np.ndarray]] = deque(maxlen=2 * self.reach + 1)

    def visit(self, depsgraph: bpy.types.Depsgraph) -> None:
        """The next frame, which the scene is at."""
        on_top = shape_keys.added_on_top(self.obj, self.obj.tug.result)
        if not self.reach:
            self.writer.write(rig.positions(self.obj, depsgraph) + on_top)
            return
        self.window.append((rig.solution(self.obj, depsgraph), on_top))
        if len(self.window) == self.window.maxlen:
            mean = average([solution for solution, _ in self.window], self.smoothing)
            positions = rig.shown(self.obj, depsgraph, mean)
            self.writer.write(positions + self.window[self.reach][1])
