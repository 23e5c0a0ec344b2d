#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""in_environment.py SCRIPT [ARGUMENTS]: run a script of this folder with what it imports, in a
virtual environment in the cache, which is made where it is missing."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

sys.path.insert(0, str(HERE.parents[1] / "blender_tests"))
from blenders import (  # noqa: E402
    CACHE,
    UnavailableError,
    find_python,
    make_environment,
    make_in_cache,
)


def provide() -> Path:
    """The environment of requirements.txt as it is now."""
    requirements = HERE / "requirements.txt"
    folder = CACHE / f"bench-{hashlib.sha256(requirements.read_bytes()).hexdigest()[:12]}"
    if not folder.exists():
        make_in_cache(
            folder, lambda empty: make_environment(empty, find_python(), "-r", str(requirements))
        )
    return folder


def main() -> None:
    try:
        python = str(provide() / "bin" / "python")
    except UnavailableError as reason:
        sys.exit(f"not run: {reason}")
    script, *arguments = sys.argv[1:]
    os.execv(python, [python, str(HERE / script), *arguments])


if __name__ == "__main__":
    main()
