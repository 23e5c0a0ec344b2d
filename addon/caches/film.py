# SPDX-License-Identifier: GPL-3.0-or-later
"""Frame after frame to PC2 files, which modifiers then show."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Protocol

import bpy

from .. import handlers
from ..native import Progress
from ..rigging.inputs import RigError
from . import mesh_cache, pc2

NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class Film(Protocol):
    """Writes one object's frames."""

    def visit(self, depsgraph: bpy.types.Depsgraph) -> None:
        """The next frame, which the scene is at."""


def shoot(
    paths: Mapping[bpy.types.Object, str | Path],
    first: int,
    last: int,
    make: Callable[[bpy.types.Object, pc2.Writer], Film],
    progress: Progress | None,
    *,
    reach: int = 0,
) -> list[Path]:
    """Visit frames first to last, both included, and `reach` more on either side, with the film of
    each object; then show each file through a modifier.

    All files appear whole, or none does; the scene's frame is as before. Paths may start with //
    for the folder of the .blend file. An exception that `progress` raises cancels.
    """
    files = {obj: _absolute(path) for obj, path in paths.items()}
    with closing(roll(files, first, last, make, reach=reach)) as frames:
        for stage, fraction in frames:
            if progress:
                progress(stage, fraction)
    return list(files.values())


def roll(
    paths: Mapping[bpy.types.Object, str | Path],
    first: int,
    last: int,
    make: Callable[[bpy.types.Object, pc2.Writer], Film],
    *,
    reach: int = 0,
) -> Iterator[tuple[str, float]]:
    """`shoot`, a frame each time it is asked for the next, with the progress that has been made.
    Closing it cancels."""
    for obj in paths:
        if obj.library:
            raise RigError(
                f'"{obj.name}" is linked from another file and cannot have a modifier that shows '
                "its bake: make a library override of it first"
            )
    if last < first:
        raise RigError(f"there is nothing to bake from frame {first} to {last}")
    files = {obj: _absolute(path) for obj, path in paths.items()}
    if len(set(files.values())) < len(files):
        raise RigError("two rigs would be baked to the same file: rename one of them")
    scene, count = bpy.context.scene, last + 1 - first
    before, subframe = scene.frame_current, scene.frame_subframe
    visited = range(first - reach, last + 1 + reach)
    try:
        with ExitStack() as stack, handlers.paused():
            films = []
            for obj, path in files.items():
                path.parent.mkdir(parents=True, exist_ok=True)
                writer = pc2.Writer(path, len(obj.data.vertices), first, count)
                films.append(make(obj, stack.enter_context(writer)))
            for number, frame in enumerate(visited, 1):
                scene.frame_set(frame)
                for film in films:
                    film.visit(bpy.context.evaluated_depsgraph_get())
                yield f"frame {frame}", number / len(visited)
    except OSError as error:
        raise RigError(_explain(error, files, count)) from error
    finally:
        scene.frame_set(before, subframe=subframe)
    for obj, path in files.items():
        mesh_cache.set_up(obj, path, first)


def _absolute(path: str | Path) -> Path:
    path = os.fspath(path)
    if path.startswith("//") and not bpy.data.filepath:
        raise RigError(f"{path} is beside the .blend file, which has not been saved: save it first")
    return Path(os.path.abspath(bpy.path.abspath(path)))


def _explain(error: OSError, files: Mapping[bpy.types.Object, Path], count: int) -> str:
    names = ", ".join(str(path) for path in files.values())
    if error.errno in NO_SPACE:
        size = sum(12 * count * len(obj.data.vertices) for obj in files) / 1e6
        return f"no space left to bake to {names}: {size:.1f} MB are needed"
    return f"cannot bake to {names}: {error.strerror}; choose a folder you may write to"
