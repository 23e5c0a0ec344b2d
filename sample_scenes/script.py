# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts here share. They run as `blender -b --python X.py -- ARGUMENTS` and, where a
Python has the bpy module, as `python X.py ARGUMENTS`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

import addon
from addon import terminal
from addon.rigging import rig

from .blend_scene import add_sample, empty_file
from .sample import Sample


@contextmanager
def registered() -> Iterator[None]:
    """The add-on is known to Blender; afterwards no more, since a Python that ends with its classes
    still registered in the bpy module crashes."""
    addon.register()
    try:
        yield
    finally:
        addon.unregister()


def arguments() -> list[str]:
    """The script's own arguments."""
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]


def save_scene(sample: Sample, path: Path) -> tuple[bpy.types.Object, rig.BindSummary]:
    """Makes the scene of `sample` in place of the open file, binds it, and saves it at `path`."""
    empty_file()
    obj = add_sample(sample)
    bar = terminal.Bar("bind")
    try:
        summary = rig.bind(obj, bar)
    finally:
        bar.close()
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()))
    return obj, summary


def report(summary: rig.BindSummary) -> None:
    """Prints what a bind made and how long it took."""
    print(f"vertices  {summary.vertices}")
    print(f"shapes    {summary.shapes}")
    print(f"handles   {summary.handles}")
    print(f"weights   {summary.weights_seconds:.3f} s")
    print(f"model     {summary.model_seconds:.3f} s")
