# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel that carries libtug into an extension. It needs no Python of its own: ctypes loads the
library."""

from __future__ import annotations

import base64
import hashlib
import re
import subprocess
import zipfile
from pathlib import Path

NAME = "tug_native"  # the module that addon/native.py looks for
LIBRARIES_OF_GLIBC = {"libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2"}
MODULE = '''"""libtug, the library of the Blender extension Tug, beside this file."""\n'''


class WheelError(Exception):
    """The library cannot go into a wheel, with the reason."""


def write_wheel(library: Path, version: str, licenses: dict[str, Path], folder: Path) -> Path:
    """Write the wheel into a new folder. licenses: of what the library has inside, by file name.

    Its version ends in a digest of the library: Blender does not unpack a wheel again of which it
    has the same version.
    """
    content = library.read_bytes()
    version = f"{version}+{hashlib.sha256(content).hexdigest()[:12]}"
    tag = f"py3-none-{platform_tag(library)}"
    info = f"{NAME}-{version}.dist-info"
    files = {
        f"{NAME}/__init__.py": MODULE.encode(),
        f"{NAME}/{library.name}": content,
        f"{info}/METADATA": (
            f"Metadata-Version: 2.1\nName: {NAME}\nVersion: {version}\n"
            "Summary: The library of the Blender extension Tug\nLicense: GPL-3.0-or-later\n"
        ).encode(),
        f"{info}/WHEEL": (
            f"Wheel-Version: 1.0\nGenerator: tug\nRoot-Is-Purelib: false\nTag: {tag}\n"
        ).encode(),
        **{f"{info}/licenses/{name}": file.read_bytes() for name, file in licenses.items()},
    }
    files[f"{info}/RECORD"] = record(files, f"{info}/RECORD")
    folder.mkdir(parents=True)
    wheel = folder / f"{NAME}-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return wheel


def platform_tag(library: Path) -> str:
    """The oldest glibc that has every symbol the library asks for; of nothing else may it ask."""
    said = subprocess.run(
        ["objdump", "-p", str(library)], check=True, capture_output=True, text=True
    ).stdout
    needed = set(re.findall(r"NEEDED\s+(\S+)", said)) - LIBRARIES_OF_GLIBC
    if needed:
        raise WheelError(f"{library} is not self-contained, it needs {', '.join(sorted(needed))}")
    major, minor = max((int(a), int(b)) for a, b in re.findall(r"GLIBC_(\d+)\.(\d+)", said))
    return f"manylinux_{major}_{minor}_x86_64"


def record(files: dict[str, bytes], own_name: str) -> bytes:
    lines = []
    for name, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={digest},{len(data)}\n")
    return "".join([*lines, f"{own_name},,\n"]).encode()
