#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender: the same drag by Tug, by Laplacian Deform with hooks, and by hooks alone.

    python3 blender_tests/run_script.py native/bench/blender_deform.py [VERTICES ...]

A frame is: ten empties are moved, the scene is brought up to date, the evaluated mesh is there.
Tug writes its shape key in between. The rows go to build/bench_blender.json.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import bpy
import numpy as np

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "blender_tests"), str(CHECKOUT / "native" / "bench")]
from blenders import arguments  # noqa: E402
from continuity import draw_paths  # noqa: E402
from data import ExampleSet  # noqa: E402
from generated import tube  # noqa: E402
from suite import Row, compare  # noqa: E402
from support import add_keys, add_mesh, depsgraph, evaluated  # noqa: E402

import addon  # noqa: E402
from addon import rig  # noqa: E402

OUT = CHECKOUT / "build" / "bench_blender.json"
SIZES = (5_000, 20_000, 100_000)
SHAPES, HANDLES, FRAMES = 6, 10, 12
REPEATS = (1, 5)  # of the rotations in Laplacian Deform


def add_object(poses: ExampleSet) -> bpy.types.Object:
    """The first pose, on an emptied scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return add_mesh("Tube", poses.shapes[0], poses.triangles.tolist())


def by_tug(poses: ExampleSet, handles: np.ndarray, frames: np.ndarray) -> tuple[float, float]:
    """Seconds to bind, and for a frame."""
    obj = add_object(poses)
    add_keys(obj, *poses.shapes[1:])
    empties = [rig.add_handle(obj, int(v), f"Handle {i}") for i, v in enumerate(handles)]
    start = time.perf_counter()
    rig.bind(obj)
    bound = time.perf_counter() - start
    return bound, frame_seconds(obj, empties, frames, lambda: rig.solve(obj, depsgraph()))


def add_hooks(obj: bpy.types.Object, handles: np.ndarray) -> list[bpy.types.Object]:
    """An empty at each handle, and a modifier that lets it pull the vertex."""
    empties = []
    for number, vertex in enumerate(handles):
        empty = bpy.data.objects.new(f"Hook {number}", None)
        empty.location = obj.data.vertices[vertex].co
        bpy.context.scene.collection.objects.link(empty)
        empties.append(empty)
    bpy.context.view_layer.update()
    for empty, vertex in zip(empties, handles, strict=True):
        hook = obj.modifiers.new(empty.name, "HOOK")
        hook.object = empty
        hook.vertex_indices_set([int(vertex)])
        hook.matrix_inverse = empty.matrix_world.inverted()
    return empties


def by_hooks(poses: ExampleSet, handles: np.ndarray, frames: np.ndarray) -> float:
    """Seconds for a frame; nothing but the ten vertices moves."""
    obj = add_object(poses)
    return frame_seconds(obj, add_hooks(obj, handles), frames, lambda: None)


def by_laplacian(
    poses: ExampleSet, handles: np.ndarray, frames: np.ndarray, repeat: int
) -> tuple[float, float]:
    """Seconds to bind, and for a frame."""
    obj = add_object(poses)
    empties = add_hooks(obj, handles)
    anchors = obj.vertex_groups.new(name="Anchors")
    anchors.add([int(vertex) for vertex in handles], 1.0, "REPLACE")
    modifier = obj.modifiers.new("Laplacian", "LAPLACIANDEFORM")
    modifier.vertex_group, modifier.iterations = anchors.name, repeat
    start = time.perf_counter()
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    evaluated(obj)
    bound = time.perf_counter() - start
    if not modifier.is_bind:
        raise RuntimeError("Laplacian Deform did not bind")
    return bound, frame_seconds(obj, empties, frames, lambda: None)


def frame_seconds(
    obj: bpy.types.Object,
    empties: list[bpy.types.Object],
    frames: np.ndarray,
    solve: Callable[[], object],
) -> float:
    """Median; the first frame does not count."""
    seconds = []
    for targets in frames:
        start = time.perf_counter()
        for empty, target in zip(empties, targets, strict=True):
            empty.location = target
        bpy.context.view_layer.update()
        solve()
        obj.evaluated_get(depsgraph()).data.vertices[0].co.copy()
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds[1:]))


def measure(vertices: int) -> list[Row]:
    """Tug beside each of the others on one mesh."""
    poses = tube(vertices, SHAPES)
    handles = poses.spread_handles(HANDLES)
    frames = next(draw_paths(poses, handles, 1)).frames(FRAMES)
    sizes = {"vertices": len(poses.shapes[0]), "shapes": SHAPES, "handles": HANDLES}
    sizes["blender"] = bpy.app.version_string
    bound, frame = by_tug(poses, handles, frames)
    name, label = "blender_frame", f"a frame, {sizes['vertices']} vertices"
    hooks = by_hooks(poses, handles, frames)
    rows = [compare(name, label, "ms", 1e3 * frame, "hooks alone", 1e3 * hooks, None, sizes)]
    for repeat in REPEATS:
        peer = f"Laplacian Deform, Repeat {repeat}, and hooks"
        peer_bound, peer_frame = by_laplacian(poses, handles, frames, repeat)
        rows.append(compare(name, label, "ms", 1e3 * frame, peer, 1e3 * peer_frame, None, sizes))
    label = f"bind, {sizes['vertices']} vertices"
    rows.append(compare("blender_bind", label, "s", bound, peer, peer_bound, None, sizes))
    return rows


def main() -> None:
    addon.register()
    rows = []
    for vertices in map(int, arguments(sys.argv) or SIZES):
        for row in measure(vertices):
            print(row, flush=True)
            rows.append(asdict(row))
    OUT.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
