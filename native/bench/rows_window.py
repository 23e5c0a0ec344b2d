# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on a bind in a window of Blender: window_bind_100k."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

from library import CHECKOUT
from suite import Row, compare, not_run

sys.path.insert(0, str(CHECKOUT / "blender_tests"))
from blenders import TESTED, Root, UnavailableError  # noqa: E402

NAME = "window_bind_100k"
RESULTS = CHECKOUT / "build" / "results"
MEASURED = RESULTS / "long_bind.json"  # what window/test_long_bind.py writes
RUNNER = CHECKOUT / "blender_tests" / "window" / "run.py"
SECONDS_ALLOWED = 600


def window_bind_rows() -> Iterator[Row]:
    """How long the window is silent during a bind, and how soon Esc ends it. By the test in a
    window, so of the extension that `make package` made last."""
    for root in (blender for blender in TESTED if isinstance(blender, Root)):
        try:
            root.provide()
            yield from rows(root.name, measure(root))
        except UnavailableError as reason:
            yield not_run(NAME, f"{root.name}: {reason}")


def measure(root: Root) -> dict[str, float]:
    extension = next((CHECKOUT / "build" / "package").glob("*.zip"), None)
    if extension is None:
        raise UnavailableError("the extension is not packaged: make package")
    RESULTS.mkdir(exist_ok=True)
    MEASURED.unlink(missing_ok=True)
    report = RESULTS / f"{NAME}.xml"
    command = root.window_command(extension, RUNNER, str(report), "test_long_bind")
    subprocess.run(command, capture_output=True, timeout=SECONDS_ALLOWED)
    measured = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
    if "esc_seconds" not in measured:
        raise UnavailableError(f"the test failed: see {report}")
    return measured


def rows(blender: str, measured: dict[str, float]) -> Iterator[Row]:
    sizes = {"blender": blender, "vertices": measured["vertices"]}
    yield compare(
        NAME,
        f"{blender}: longest silence",
        "s",
        measured["longest_silence"],
        "drawing it",
        measured["silence_of_drawing"],
        None,
        sizes,
    )
    held = measured["longest_held"]
    yield Row(NAME, f"{blender}: longest that Tug keeps it waiting", "s", held, sizes=sizes)
    yield Row(NAME, f"{blender}: whole bind", "s", measured["bind_seconds"], sizes=sizes)
    yield Row(NAME, f"{blender}: from Esc to the end", "s", measured["esc_seconds"], sizes=sizes)
