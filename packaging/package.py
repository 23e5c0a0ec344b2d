#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the extension: build/package/tug-VERSION-linux_x64.zip, by Blender's own commands.

The folder it is made from, build/package/tug, has the add-on, its sample and a wheel with libtug.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from wheel import write_wheel

CHECKOUT = Path(__file__).resolve().parent.parent
ADDON = CHECKOUT / "addon"
LIBRARY = CHECKOUT / "build" / "release" / "libtug.so"
OUTPUT = CHECKOUT / "build" / "package"

MANIFEST = "blender_manifest.toml"
FIRST_TABLE = "\n[permissions]"  # what stands above it in the manifest belongs to no table

sys.path.insert(0, str(CHECKOUT / "blender_tests"))
from blenders import (  # noqa: E402
    CACHE,
    Program,
    UnavailableError,
    packaging_blender,
    provide_tools,
)

# The terms of what libtug has inside.
LICENSES = {
    "SuiteSparse.txt": CACHE / "suitesparse-5.12.0" / "LICENSE.txt",
    "OpenBLAS.txt": Path("/usr/share/doc/libopenblas-pthread-dev/copyright"),
}


def main() -> None:
    try:
        blender = packaging_blender()
        blender.provide()
        print(package(blender))
    except UnavailableError as reason:
        sys.exit(f"not packaged: {reason}")


def package(blender: Program) -> Path:
    """The zip, made and checked by this Blender. Whatever was in the folder is gone."""
    shutil.rmtree(OUTPUT, ignore_errors=True)
    source = stage(OUTPUT / "tug")
    extension(blender, "validate", str(source))
    build = ("--source-dir", str(source), "--output-dir", str(OUTPUT), "--split-platforms")
    extension(blender, "build", *build)
    (made,) = OUTPUT.glob("*.zip")
    extension(blender, "validate", str(made))
    return made


def stage(folder: Path) -> Path:
    """Fill a new folder with what goes into the zip."""
    shutil.copytree(ADDON, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(CHECKOUT / "LICENSE", folder)
    python, script = provide_tools(), Path(__file__).with_name("sample.py")
    subprocess.run([python, str(script), str(folder / "sample.npz")], check=True)
    manifest = folder / MANIFEST
    version = tomllib.loads(manifest.read_text())["version"]
    wheel = write_wheel(LIBRARY, version, LICENSES, folder / "wheels")
    lines = f'platforms = ["linux-x64"]\nwheels = ["./wheels/{wheel.name}"]\n'
    manifest.write_text(manifest.read_text().replace(FIRST_TABLE, lines + FIRST_TABLE, 1))
    return folder


def extension(blender: Program, *arguments: str) -> None:
    subprocess.run([*blender.program(), "--command", "extension", *arguments], check=True)


if __name__ == "__main__":
    main()
