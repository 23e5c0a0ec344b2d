#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Take the pictures of the manual anew: docs/manual/*.png, by the tests that play what it tells."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
RESULTS = CHECKOUT / "build" / "results"
PICTURES = CHECKOUT / "docs" / "manual"
PREFIX = "manual_"

sys.path.insert(0, str(CHECKOUT / "blender_tests"))
from blenders import TESTED, Root, UnavailableError  # noqa: E402


def main() -> None:
    root = [blender for blender in TESTED if isinstance(blender, Root)][-1]
    (extension,) = (CHECKOUT / "build" / "package").glob("*.zip")
    try:
        root.provide()
    except UnavailableError as reason:
        sys.exit(f"no screenshots: {reason}")
    RESULTS.mkdir(exist_ok=True)
    runner = Path(__file__).with_name("run.py")
    report = RESULTS / "screenshots.xml"
    subprocess.run(root.window_command(extension, runner, str(report), "test_manual"), check=True)
    PICTURES.mkdir(exist_ok=True)
    for picture in sorted(RESULTS.glob(f"{PREFIX}*.png")):
        shutil.copy(picture, PICTURES / picture.name.removeprefix(PREFIX))


if __name__ == "__main__":
    main()
