# SPDX-License-Identifier: GPL-3.0-or-later
"""What the library file shows of itself, so that it lives with whatever Blender has loaded."""

import os
import re
import subprocess
from pathlib import Path

import pytest

NATIVE = Path(__file__).resolve().parents[2]
LIBRARY = Path(os.environ.get("TUG_LIBRARY", NATIVE.parent / "build" / "release" / "libtug.so"))


def output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_exports_are_the_functions_of_the_header() -> None:
    header = (NATIVE / "include" / "tug.h").read_text()
    declared = set(re.findall(r"^TUG_API [^;]*?\b(tug_\w+)\(", header, re.MULTILINE))
    symbols = output("nm", "--dynamic", "--defined-only", "--format=posix", str(LIBRARY))
    assert {line.split()[0] for line in symbols.splitlines()} == declared


def test_nothing_but_the_c_library_is_needed() -> None:
    needed = re.findall(r"NEEDED.*\[(.*)\]", output("readelf", "--dynamic", str(LIBRARY)))
    if "libcholmod.so.3" in needed:
        pytest.skip("not run: built without native/provide_suitesparse.sh")
    assert {name.split(".so")[0] for name in needed} <= {"libc", "libm", "ld-linux-x86-64"}
