#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""in_environment.py SCRIPT [ARGUMENTS]: run a script of this folder, or any given by its path, with
what the requirements.txt beside it lists, in a virtual environment in the cache."""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

sys.path.insert(0, str(HERE.parents[1] / "blender_tests"))
from blenders import UnavailableError, provide_environment  # noqa: E402


def main() -> None:
    given, *arguments = sys.argv[1:]
    beside, elsewhere = HERE / given, Path(given).resolve()
    script = beside if beside.exists() else elsewhere
    try:
        python = provide_environment(script.parent.name, script.with_name("requirements.txt"))
    except UnavailableError as reason:
        sys.exit(f"not run: {reason}")
    os.execv(python, [python, str(script), *arguments])


if __name__ == "__main__":
    main()
