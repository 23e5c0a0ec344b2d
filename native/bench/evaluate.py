#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate methods on a folder of example poses, as JSON.

evaluate.py --data DIR --sets lion,cat --methods amrap,fast --handles 10 --examples 8 --out out.json
"""

from __future__ import annotations

import argparse
import functools
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np
from data import ExampleSet, MissingDataError, default_folder, load, set_names
from library import native
from methods import ABLATIONS, DEFAULT, OWN, Tally, make, peers
from quality import HeldOut, drag_dependence, leave_one_out, recognise, start_cold
from rigs import Rig

COLD_FRAMES = 13


def parse_arguments() -> argparse.Namespace:
    known = [*OWN, *ABLATIONS, *peers()]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--data", type=Path, default=default_folder(), help="folder of .npz files; default TUG_DATA"
    )
    parser.add_argument("--sets", type=names, help="comma-separated; default: all of the folder")
    parser.add_argument(
        "--methods", type=names, default=[DEFAULT], help=f"comma-separated, of {', '.join(known)}"
    )
    parser.add_argument("--handles", type=int, default=10, help="farthest points from vertex 0")
    parser.add_argument(
        "--examples", type=int, help="use the first so many poses of a set, two or more"
    )
    parser.add_argument("--out", type=Path, required=True, help="JSON file to write")
    given = parser.parse_args()
    if unknown := set(given.methods) - set(known):
        parser.error(f"no method {', '.join(sorted(unknown))}; there are: {', '.join(known)}")
    if given.examples is not None and given.examples < 2:
        parser.error(f"--examples {given.examples}: a pose is left out, so two are the least")
    if given.handles < 1:
        parser.error(f"--handles {given.handles}: one is the least")
    return given


def names(text: str) -> list[str]:
    """At least one, each once."""
    found = list(dict.fromkeys(name for name in text.split(",") if name))
    if not found:
        raise argparse.ArgumentTypeError("no names")
    return found


def load_sets(given: argparse.Namespace) -> list[ExampleSet]:
    """All that are asked for, before the first is worked on. Raises MissingDataError where one
    cannot be evaluated."""
    found = []
    for name in given.sets or set_names(given.data):
        poses = load(given.data, name).first(given.examples)
        count, vertices, _ = poses.shapes.shape
        if count < 2:
            raise MissingDataError(
                f"{name} has {count} pose: one is left out, so two are the least"
            )
        if vertices < given.handles:
            raise MissingDataError(
                f"{name} has {vertices} vertices, too few for {given.handles} handles"
            )
        found.append(poses)
    return found


def evaluate_set(poses: ExampleSet, methods: list[str], handle_count: int) -> dict:
    """All measures of all methods on one set."""
    handles = poses.spread_handles(handle_count)
    held_out = leave_one_out(poses, handles, methods, Tally())
    result = {}
    for name in methods:
        start = time.perf_counter()
        rig = Rig(poses.shapes, poses.triangles, handles)
        method = make(name, rig)
        result[name] = {
            "bind_seconds": time.perf_counter() - start,
            "leave_one_out": summarise([one for one in held_out if one.method == name]),
            "cold_start": asdict(start_cold(poses, handles, method, COLD_FRAMES)),
            "recognition": [asdict(one) for one in recognise(poses, handles, method)],
            "drag_dependence": drag_dependence(
                poses, handles, functools.partial(make, name, rig), Tally()
            ),
        }
        method.close()
        print(f"{poses.name}: {name}: {describe(result[name])}", flush=True)
    count, vertices, dimension = poses.shapes.shape
    sizes = {"poses": count, "vertices": vertices, "dimension": dimension, "handles": len(handles)}
    return {"sizes": sizes, "methods": result}


def summarise(poses: list[HeldOut]) -> dict:
    """Over the poses of a set: the mean error's mean, the largest of the others."""
    return {
        "mean_error": float(np.mean([pose.mean for pose in poses])),
        "largest_error": max(pose.largest for pose in poses),
        "fbt_mean": float(np.mean([pose.fbt for pose in poses])),
        "fbt_largest": max(pose.fbt for pose in poses),
        "unconverged": sum(not pose.converged for pose in poses),
        "poses": [asdict(pose) for pose in poses],
    }


def describe(result: dict) -> str:
    """One line for people."""
    left_out, cold = result["leave_one_out"], result["cold_start"]
    recognised = max((one["error"] for one in result["recognition"]), default=float("nan"))
    return (
        f"leave-one-out {left_out['mean_error']:.4f} (largest {left_out['largest_error']:.3f}, "
        f"FBT {left_out['fbt_mean']:.3f}), recognition {recognised:.1e} of "
        f"{len(result['recognition'])}, drags {result['drag_dependence']:.1e}, cold "
        f"{cold['rounds_median']:g} rounds {cold['milliseconds_median']:.1f} ms, "
        f"bind {result['bind_seconds']:.2f} s"
    )


def main() -> None:
    given = parse_arguments()
    sets = load_sets(given)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    result = {one.name: evaluate_set(one, given.methods, given.handles) for one in sets}
    given.out.write_text(json.dumps({"handles": given.handles, "sets": result}, indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except (MissingDataError, native.LibraryError, native.TugError) as error:
        sys.exit(f"evaluate.py: {error}")
