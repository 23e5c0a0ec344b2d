# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on drags inside Blender: blender_laplacian_10k, _25k, _100k, blender_drag_10k, _100k."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from library import CHECKOUT
from suite import Row, Suite, not_run

sys.path.insert(0, str(CHECKOUT / "blender_tests"))
from blenders import TESTED, Blender, Root, UnavailableError, Wheel  # noqa: E402

FOLDER = Path(__file__).resolve().parent
# The last long-term one and the newest that come as a Python module.
BLENDERS = [blender for blender in TESTED if isinstance(blender, Wheel)][-2:]
WINDOWS = [blender for blender in TESTED if isinstance(blender, Root)][-1:]
SCRIPTS = {"blender_laplacian": "blender_deform", "blender_drag": "blender_drag"}
SECONDS_ALLOWED = 1200
BLENDER_ROWS = {  # names, and numbers of vertices
    "blender_laplacian_10k": 10_000,
    "blender_laplacian_25k": 25_000,
    "blender_laplacian_100k": 100_000,
    "blender_drag_10k": 10_000,
    "blender_drag_100k": 100_000,
}


def blender_rows(suite: Suite, wanted: set[str]) -> Iterator[Row]:
    """The same drag by Tug, Laplacian Deform with hooks, and hooks alone; a step of it in parts, in
    a window too. A quick run takes the newest Blender."""
    wheels = BLENDERS[-1:] if suite.quick else BLENDERS
    for name in (name for name in BLENDER_ROWS if name in wanted):
        for blender in (*wheels, *(WINDOWS if name.startswith("blender_drag") else ())):
            try:
                blender.provide()
                yield from run(blender, name, int(suite.size * BLENDER_ROWS[name]))
            except UnavailableError as reason:
                yield not_run(name, f"{blender.name}: {reason}")


def run(blender: Blender, name: str, vertices: int) -> list[Row]:
    """What the script measures in a process of this Blender."""
    # A sandbox may write to the build folder only.
    with tempfile.TemporaryDirectory(dir=CHECKOUT / "build") as folder:
        out = Path(folder) / "rows.json"
        script = FOLDER / f"{SCRIPTS[name.rpartition('_')[0]]}.py"
        start = blender.in_window if isinstance(blender, Root) else blender.command
        command = start(script, name, str(vertices), str(out))
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS_ALLOWED)
        except subprocess.TimeoutExpired as error:
            raise UnavailableError(f"no end after {SECONDS_ALLOWED} s") from error
        if not out.exists():
            said = [line for line in ended.stderr.splitlines() if line and not line[0].isspace()]
            raise UnavailableError(said[-1] if said else f"exit code {ended.returncode}")
        return [Row(**row) for row in json.loads(out.read_text())]
