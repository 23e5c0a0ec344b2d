# SPDX-License-Identifier: GPL-3.0-or-later
"""PC2 files: what is in them, and that they appear whole or not at all."""

from __future__ import annotations

import errno
import struct

import numpy as np
import pytest

from addon.caches import pc2

FRAMES = np.arange(24, dtype=np.float32).reshape(2, 4, 3)


def write(path, frames, announced=None):
    count = len(frames) if announced is None else announced
    with pc2.Writer(path, 4, 20, count) as writer:
        for frame in frames:
            writer.write(frame)


def test_a_file_has_the_header_and_the_frames_that_blender_reads(tmp_path):
    write(tmp_path / "a.pc2", FRAMES.astype(np.float64))
    data = (tmp_path / "a.pc2").read_bytes()
    assert struct.unpack("<12siiffi", data[:32]) == (b"POINTCACHE2\0", 1, 4, 20.0, 1.0, 2)
    assert data[32:] == FRAMES.astype("<f4").tobytes()


def test_an_older_file_is_replaced(tmp_path):
    (tmp_path / "a.pc2").write_text("older")
    write(tmp_path / "a.pc2", FRAMES)
    assert (tmp_path / "a.pc2").stat().st_size == 32 + FRAMES.nbytes
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("kind", [KeyboardInterrupt, RuntimeError])
def test_an_exception_leaves_what_was_there(tmp_path, kind):
    (tmp_path / "a.pc2").write_text("older")
    with pytest.raises(kind), pc2.Writer(tmp_path / "a.pc2", 4, 1, 2) as writer:
        writer.write(FRAMES[0])
        raise kind
    assert [path.read_text() for path in tmp_path.iterdir()] == ["older"]


def test_a_full_disk_leaves_nothing(tmp_path, monkeypatch):
    def full(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        write(tmp_path / "a.pc2", FRAMES)
    assert not list(tmp_path.iterdir())


def test_missing_frames_are_an_error(tmp_path):
    with pytest.raises(ValueError, match="1 frames were announced but not written"):
        write(tmp_path / "a.pc2", FRAMES, announced=3)
    assert not list(tmp_path.iterdir())


def test_a_frame_of_another_size_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"a frame must be \(4, 3\)"):
        write(tmp_path / "a.pc2", FRAMES[:, :3])
    assert not list(tmp_path.iterdir())
