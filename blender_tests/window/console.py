# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender and Python print, kept for tests to look through."""

from __future__ import annotations

import os
import sys
from pathlib import Path


class Console:
    """From now on standard output and error go to a file, and to where they went before once
    closed. By file descriptors: Blender prints past Python."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.before = os.dup(1)
        self.start = 0
        with path.open("w") as file:
            os.dup2(file.fileno(), 1)
        os.dup2(1, 2)

    def mark(self) -> None:
        """What was printed so far counts no more."""
        self.start = len(self.read())

    def read(self) -> str:
        sys.stdout.flush()
        sys.stderr.flush()
        return self.path.read_text(errors="replace")

    def check(self) -> None:
        """Fails if an exception was printed since the mark."""
        text = self.read()[self.start :]
        assert "Traceback (most recent call last)" not in text, text

    def close(self) -> None:
        os.write(self.before, self.read().encode())
        self.path.unlink()
