# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the poses of rigs to PC2 files and show them through the Mesh Cache modifier.

Also a script: `blender -b scene.blend --python-exit-code 1 --python bake.py -- --output FILE`, or
`python bake.py scene.blend --output FILE` where bpy is installed; `cli` has the rest.
"""

from __future__ import annotations

import errno
import importlib.util
import os
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import bpy


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
    from . import handlers, live, mesh_cache, pc2, rig, shape_keys
    from .inputs import RigError
    from .native import Progress

NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def bake(
    obj: bpy.types.Object,
    first: int,
    last: int,
    path: str | Path,
    progress: Progress | None = None,
) -> Path:
    """Bake frames first to last of one rig; see `bake_rigs`."""
    return bake_rigs({obj: path}, first, last, progress)[0]


def bake_rigs(
    paths: Mapping[bpy.types.Object, str | Path],
    first: int,
    last: int,
    progress: Progress | None = None,
) -> list[Path]:
    """Bake frames first to last, both included, of each rig to its PC2 file.

    A file holds what the rig shows, keys that add on top included, and appears whole or not at all.
    A modifier is then set up to show frame f of it at frame f. Paths may start with // for the
    folder of the .blend file. An exception that `progress` raises cancels the bake.
    """
    if last < first:
        raise RigError(f"there is nothing to bake from frame {first} to {last}")
    files = {obj: _absolute(path) for obj, path in paths.items()}
    if len(set(files.values())) < len(files):
        raise RigError("two rigs would be baked to the same file: rename one of them")
    for obj in files:
        live.touch(obj)
        live.current(obj, bpy.context.scene)
    _write_files(files, first, last, progress)
    for obj, path in files.items():
        mesh_cache.set_up(obj, path, first)
    return list(files.values())


def _write_files(
    files: Mapping[bpy.types.Object, Path], first: int, last: int, progress: Progress | None
) -> None:
    count = last - first + 1
    scene = bpy.context.scene
    before, subframe = scene.frame_current, scene.frame_subframe
    try:
        with ExitStack() as stack, handlers.paused():
            writers = {}
            for obj, path in files.items():
                path.parent.mkdir(parents=True, exist_ok=True)
                writer = pc2.Writer(path, len(obj.data.vertices), first, count)
                writers[obj] = stack.enter_context(writer)
            for number in range(count):
                _write_frame(writers, first + number)
                if progress:
                    progress(f"frame {first + number}", (number + 1) / count)
    except OSError as error:
        raise RigError(_explain(error, files, count)) from error
    finally:
        scene.frame_set(before, subframe=subframe)


def _write_frame(writers: Mapping[bpy.types.Object, pc2.Writer], frame: int) -> None:
    bpy.context.scene.frame_set(frame)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for obj, writer in writers.items():
        positions = rig.positions(obj, depsgraph)
        writer.write(positions + shape_keys.added_on_top(obj, obj.tug.result))


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
