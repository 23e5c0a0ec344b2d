# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `bake.py`."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy

from . import bake, terminal
from .inputs import RigError
from .native import LibraryError

FAILED = 1
CANCELLED = 130  # as shells say of a program that Ctrl-C ended

FRAMES = re.compile(r"(-?\d+)(?:-(-?\d+)(?:x(\d+))?)?")


def parse_frames(text: str) -> list[int]:
    """Frames of a list such as `1-48`, `1,5,9` or `1-48x2` (every second), sorted."""
    frames: set[int] = set()
    for part in text.split(","):
        match = FRAMES.fullmatch(part.strip())
        if not match:
            raise ValueError(f"{part!r} is neither a frame, as 7, nor a range of frames, as 1-48")
        first = int(match[1])
        last = first if match[2] is None else int(match[2])
        step = int(match[3] or 1)
        if step < 1 or last < first:
            raise ValueError(f"the range {part!r} is empty")
        frames.update(range(first, last + 1, step))
    return sorted(frames)


def main() -> int:
    """Bake as sys.argv says; the exit code."""
    options = _parser().parse_args(_arguments())
    try:
        with terminal.cancelling() as check:
            _open(options.scene)
            _bake(options, check)
    except KeyboardInterrupt:
        print("cancelled: nothing was written", file=sys.stderr)
        return CANCELLED
    except (RigError, LibraryError) as error:
        print(f"error: {error}", file=sys.stderr)
        return FAILED
    return 0


def _arguments() -> list[str]:
    """Ours: after a `--`, or all where this Python is no Blender program."""
    if "--" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1 :]
    return [] if bpy.app.binary_path else sys.argv[1:]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bake.py", description="Bake the poses of Tug's rigs.")
    parser.add_argument("scene", nargs="?", type=Path, help=".blend file, if not the open one")
    parser.add_argument("--frames", type=_frames, help="as 1-48; default: the scene's range")
    parser.add_argument(
        "--output", required=True, type=Path, help="a .pc2 file for one rig, or a folder"
    )
    parser.add_argument(
        "--object", action="append", help="name of a rig, again for more; default: all of the scene"
    )
    parser.add_argument(
        "--smoothing",
        type=float,
        default=0.0,
        help="frames over which blends and rotations are averaged (standard deviation); default: 0",
    )
    parser.add_argument(
        "--save", action="store_true", help="save the scene, in which modifiers now show the bake"
    )
    return parser


def _frames(text: str) -> list[int]:
    try:
        return parse_frames(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _open(path: Path | None) -> None:
    if path is None:
        return
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()))
    except RuntimeError as error:
        raise RigError(f"cannot open {path}: {error}") from error


def _bake(options: argparse.Namespace, check_cancelled: Callable[[], None]) -> None:
    scene = bpy.context.scene
    frames = options.frames or list(range(scene.frame_start, scene.frame_end + 1))
    first, last = frames[0], frames[-1]
    if len(frames) != last - first + 1:
        raise RigError(f"a PC2 file has no gaps: bake all frames from {first} to {last}")
    paths = _paths(_rigs(options.object), options.output)
    bar = terminal.Bar("bake")
    started = time.perf_counter()

    def progress(stage: str, fraction: float) -> None:
        check_cancelled()
        bar(stage, fraction)

    try:
        files = bake.bake_rigs(paths, first, last, progress, smoothing=options.smoothing)
    finally:
        bar.close()
    if options.save:
        bpy.ops.wm.save_mainfile()
    seconds = (time.perf_counter() - started) / len(frames)
    print(f"baked {len(frames)} frames, {seconds:.4f} s each, to {', '.join(map(str, files))}")


def _rigs(names: Sequence[str] | None) -> list[bpy.types.Object]:
    rigs = {
        obj.name: obj for obj in bpy.context.scene.objects if obj.type == "MESH" and obj.tug.bound
    }
    if not rigs:
        raise RigError("the scene has no bound rig")
    if missing := sorted(set(names or ()) - rigs.keys()):
        raise RigError(f'"{missing[0]}" is no bound rig; there are: {", ".join(rigs)}')
    return [rigs[name] for name in names or rigs]


def _paths(rigs: Sequence[bpy.types.Object], output: Path) -> dict[bpy.types.Object, Path]:
    if output.suffix.lower() != ".pc2":
        return {obj: output / f"{bpy.path.clean_name(obj.name)}.pc2" for obj in rigs}
    if len(rigs) > 1:
        raise RigError(f"{output} is one file, but there are {len(rigs)} rigs: give a folder")
    return {rigs[0]: output}
