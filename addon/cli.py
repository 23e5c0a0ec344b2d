# SPDX-License-Identifier: GPL-3.0-or-later
"""The command lines: of `bake.py`, and `blender --command tug bake` or `fit`."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bpy

from . import bake, terminal
from .fitting import targets
from .fitting.fit import fit_frames
from .fitting.targets import Place, Target
from .native import LibraryError, Progress
from .rigging.inputs import RigError

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
    parser = argparse.ArgumentParser(prog="bake.py", description="Bake the poses of Tug's rigs.")
    _add_bake(parser)
    return _run(parser.parse_args(_arguments()))


def command(arguments: Sequence[str]) -> int:
    """What comes after `blender --command tug`; the exit code."""
    parser = argparse.ArgumentParser(prog="tug")
    verbs = parser.add_subparsers(required=True, metavar="bake|fit")
    _add_bake(verbs.add_parser("bake", help="bake the poses of rigs"))
    _add_fit(verbs.add_parser("fit", help="fit a rig to a target at every frame"))
    return _run(parser.parse_args(arguments))


def _run(options: argparse.Namespace) -> int:
    try:
        with terminal.cancelling() as check:
            _open(options.scene)
            options.act(options, check)
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


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?", type=Path, help=".blend file, if not the open one")
    parser.add_argument("--frames", type=_frames, help="as 1-48; default: the scene's range")
    parser.add_argument(
        "--output", required=True, type=Path, help="a .pc2 file for one rig, or a folder"
    )
    parser.add_argument(
        "--save", action="store_true", help="save the scene, in which modifiers now show the files"
    )


def _add_bake(parser: argparse.ArgumentParser) -> None:
    _add_common(parser)
    parser.add_argument(
        "--object", action="append", help="name of a rig, again for more; default: all of the scene"
    )
    parser.add_argument(
        "--smoothing",
        type=float,
        default=0.0,
        help="frames over which blends and rotations are averaged (standard deviation); default: 0",
    )
    parser.set_defaults(act=_bake)


def _add_fit(parser: argparse.ArgumentParser) -> None:
    _add_common(parser)
    parser.add_argument("--object", help="name of a rig; default: the only one of the scene")
    parser.add_argument(
        "--target", help="name of an object or a collection; default: what was chosen for the rig"
    )
    parser.set_defaults(act=_fit)


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
    first, last = _range(options)
    paths = _paths(_rigs(options.object), options.output)
    with _timed("bake", "baked", options, last + 1 - first, check_cancelled) as (progress, files):
        files += bake.bake_rigs(paths, first, last, progress, smoothing=options.smoothing)


def _fit(options: argparse.Namespace, check_cancelled: Callable[[], None]) -> None:
    first, last = _range(options)
    rigs = _rigs(options.object and [options.object])
    if len(rigs) > 1:
        raise RigError(f"there are {len(rigs)} rigs: name the one to fit with --object")
    target, pairs = _target(rigs[0], options.target)
    path = _paths(rigs, options.output)[rigs[0]]
    with _timed("fit", "fitted", options, last + 1 - first, check_cancelled) as (progress, files):
        files.append(fit_frames(rigs[0], target, first, last, path, pairs, progress=progress))


def _target(obj: bpy.types.Object, name: str | None) -> tuple[Target, dict[str, Place] | None]:
    if name is None:
        if (target := targets.chosen(obj)) is None:
            raise RigError(f'no target was chosen for "{obj.name}": name one with --target')
        return target, targets.chosen_pairs(obj)
    target = bpy.data.objects.get(name) or bpy.data.collections.get(name)
    if target is None:
        raise RigError(f'there is no object or collection "{name}"')
    return target, None


def _range(options: argparse.Namespace) -> tuple[int, int]:
    scene = bpy.context.scene
    frames = options.frames or list(range(scene.frame_start, scene.frame_end + 1))
    first, last = frames[0], frames[-1]
    if len(frames) != last - first + 1:
        raise RigError(f"a PC2 file has no gaps: bake all frames from {first} to {last}")
    return first, last


@contextmanager
def _timed(
    doing: str,
    done: str,
    options: argparse.Namespace,
    count: int,
    check_cancelled: Callable[[], None],
) -> Iterator[tuple[Progress, list[Path]]]:
    """Gives a progress, and a list to put the files in that are then told of."""
    bar, files = terminal.Bar(doing), []
    started = time.perf_counter()

    def progress(stage: str, fraction: float) -> None:
        check_cancelled()
        bar(stage, fraction)

    try:
        yield progress, files
    finally:
        bar.close()
    if options.save:
        bpy.ops.wm.save_mainfile()
    seconds = (time.perf_counter() - started) / count
    print(f"{done} {count} frames, {seconds:.4f} s each, to {', '.join(map(str, files))}")


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
