# SPDX-License-Identifier: GPL-3.0-or-later
"""Each test starts in an empty scene of a Blender in which Tug is registered."""

import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "blender_tests")]

bpy = pytest.importorskip("bpy", reason="not run: this Python has no Blender")
import addon  # noqa: E402

collect_ignore = ["window"]  # run by window/run.py, not by pytest


@pytest.fixture(autouse=True)
def empty_scene() -> None:
    if not hasattr(bpy.types.Object, "tug"):
        addon.register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
