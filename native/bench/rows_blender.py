# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on the same drag inside Blender: blender_laplacian_10k, _25k and _100k."""

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
from blenders import TESTED, UnavailableError, Wheel  # noqa: E402

SCRIPT = Path(__file__).resolve().with_name("blender_deform.py")
# The last long-term one and the newest that come as a Python module.
BLENDERS = [blender for blender in TESTED if isinstance(blender, Wheel)][-2:]
SECONDS_ALLOWED = 1200
BLENDER_ROWS = {  # names, and numbers of vertices
    "blender_laplacian_10k": 10_000,
    "blender_laplacian_25k": 25_000,
    "blender_laplacian_100k": 100_000,
}


def blender_rows(suite: Suite, wanted: set[str]) -> Iterator[Row]:
    """Tug, Laplacian Deform with hooks, and hooks alone; a quick run takes the newest Blender."""
    for name in (name for name in BLENDER_ROWS if name in wanted):
        for blender in BLENDERS[-1:] if suite.quick else BLENDERS:
            try:
                blender.provide()
                yield from run(blender, name, int(suite.size * BLENDER_ROWS[name]))
            except UnavailableError as reason:
                yield not_run(name, f"{blender.name}: {reason}")


def run(blender: Wheel, name: str, vertices: int) -> list[Row]:
    """What the script measures in a process of this Blender."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        command = blender.command(SCRIPT, name, str(vertices), str(out))
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS_ALLOWED)
        except subprocess.TimeoutExpired as error:
            raise UnavailableError(f"no end after {SECONDS_ALLOWED} s") from error
        if not out.exists():
            said = [line for line in ended.stderr.splitlines() if line and not line[0].isspace()]
            raise UnavailableError(said[-1] if said else f"exit code {ended.returncode}")
        return [Row(**row) for row in json.loads(out.read_text())]
