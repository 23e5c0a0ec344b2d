# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension as Blender installed it from its zip."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from scenes import add_creature, key_of
from window import Window

from addon import native
from addon.rigging import rig

NAME = "bl_ext.user_default.tug"
SOURCES = Path(__file__).resolve().parents[2] / "addon"
GLIBC_OF_BLENDER = 28  # 2.28: what the Blenders from blender.org ask for


def test_it_has_what_it_needs_and_nothing_else(_ui: Window) -> Iterator[None]:
    yield
    sources = {p.relative_to(SOURCES).as_posix() for p in SOURCES.rglob("*.py")}
    besides = {"blender_manifest.toml", "LICENSE", "sample.npz"}
    folder = Path(native.__file__).parent
    files = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    files = {name for name in files if "__pycache__" not in name}
    (wheel,) = [name for name in files if name.startswith("wheels/")]
    assert files - {wheel} == sources | besides
    glibc = re.search(r"-py3-none-manylinux_2_(\d+)_x86_64.whl$", wheel)
    assert int(glibc[1]) <= GLIBC_OF_BLENDER
    library = Path(native.library()._name).parent
    assert {p.name for p in library.iterdir()} - {"__pycache__"} == {"__init__.py", "libtug.so"}


def test_the_library_is_the_one_in_the_wheel(_ui: Window) -> Iterator[None]:
    yield
    installed = Path(bpy.utils.resource_path("USER")) / "extensions"
    assert Path(native.library()._name).is_relative_to(installed)
    assert Path(rig.__file__).is_relative_to(installed)


def test_it_is_disabled_and_enabled_again(_ui: Window) -> Iterator[None]:
    add_creature()
    yield
    pose, handlers = key_of("Creature"), handlers_of_tug()
    assert handlers
    for _ in range(2):
        bpy.ops.preferences.addon_disable(module=NAME)
        try:
            yield
            assert not hasattr(bpy.types.Object, "tug")
            assert not [name for name in dir(bpy.types) if name.startswith("TUG_")]
            assert not handlers_of_tug()
            bpy.ops.preferences.addon_disable(module=NAME)  # already
        finally:
            bpy.ops.preferences.addon_enable(module=NAME)
        yield
        assert handlers_of_tug() == handlers
    np.testing.assert_array_equal(key_of("Creature"), pose)
    assert bpy.data.objects["Creature"].tug.bound
    bpy.data.objects["Head"].location.z += 0.2
    yield
    assert np.abs(key_of("Creature") - pose).max() > 0.05


def test_it_loads_without_its_library_and_says_so(_ui: Window) -> Iterator[None]:
    yield
    library = Path(native.library()._name)
    hidden = library.with_suffix(".hidden")
    library.rename(hidden)
    try:
        result = background(
            "from bl_ext.user_default.tug import native, register, unregister",
            "unregister(); register()",
            "native.library()",
        )
    finally:
        hidden.rename(library)
    assert result.returncode != 0
    assert f"LibraryError: the library of Tug was not found; tried:\n  {library}" in result.stderr


def background(*lines: str) -> subprocess.CompletedProcess:
    """Another Blender of the same user, with the extension enabled."""
    script = ["--python-exit-code", "1", "--python-expr", "\n".join(lines)]
    return subprocess.run(
        [bpy.app.binary_path, "--background", *script], capture_output=True, text=True, timeout=60
    )


def handlers_of_tug() -> list[str]:
    lists = [value for value in bpy.app.handlers if isinstance(value, list)]
    functions = [function for functions in lists for function in functions]
    return [f.__qualname__ for f in functions if f.__module__.startswith(NAME)]
