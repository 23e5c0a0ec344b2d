# SPDX-License-Identifier: GPL-3.0-or-later
"""PC2 point caches, the files that Blender's Mesh Cache modifier reads.

A header of 32 bytes, then frame after frame of #V by 3 little-endian float32 in object space.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import Self
from uuid import uuid4

import numpy as np

HEADER = struct.Struct("<12siiffi")  # magic, version, vertices, first frame, step, frames
MAGIC = b"POINTCACHE2\0"


class Writer:
    """A cache that appears at `path` whole or not at all.

    Frames go to a temporary file beside it, which is renamed when the `with` block ends and removed
    when the block raises. Any OSError is the system's own.
    """

    def __init__(self, path: Path, vertex_count: int, first_frame: int, frame_count: int) -> None:
        self._path, self._shape = path, (vertex_count, 3)
        self._part = path.with_name(f"{path.name}.{uuid4().hex}.part")
        self._header = HEADER.pack(MAGIC, 1, vertex_count, first_frame, 1.0, frame_count)
        self._missing = frame_count

    def __enter__(self) -> Self:
        self._file = self._part.open("xb")
        self._file.write(self._header)
        return self

    def write(self, positions: np.ndarray) -> None:
        """Append a frame: #V by 3, in object space."""
        frame = np.ascontiguousarray(positions, "<f4")
        if frame.shape != self._shape:
            raise ValueError(f"a frame must be {self._shape}, not {frame.shape}")
        self._file.write(frame.data)
        self._missing -= 1

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            with self._file:
                if kind is None:
                    self._finish()
            if kind is None:
                self._part.replace(self._path)
        finally:
            self._part.unlink(missing_ok=True)

    def _finish(self) -> None:
        if self._missing:
            raise ValueError(f"{self._missing} frames were announced but not written")
        self._file.flush()
        os.fsync(self._file.fileno())
