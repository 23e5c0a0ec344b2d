# SPDX-License-Identifier: GPL-3.0-or-later
"""blender_deform.py NAME VERTICES OUT: inside Blender, the same drag of one mesh by Tug, by
Laplacian Deform with hooks, and by hooks alone; as rows of this name in the file OUT.

A frame is: ten empties are moved, the scene is brought up to date, the evaluated mesh is there.
Tug solves and writes its shape key in between.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "blender_tests"), str(CHECKOUT / "native" / "bench")]
from blenders import arguments  # noqa: E402
from continuity import draw_paths, farthest  # noqa: E402
from data import ExampleSet  # noqa: E402
from generated import tube  # noqa: E402
from suite import HANDLES, Row, compare  # noqa: E402
from support import add_keys, add_mesh, depsgraph, evaluated  # noqa: E402

import addon  # noqa: E402
from addon.rigging import rig  # noqa: E402

SHAPES, FRAMES = 6, 12
REPEATS = (1, 5)  # of the rotations in Laplacian Deform


@dataclass(frozen=True)
class Drag:
    """A mesh, its handle vertices and where they are to be: frames by #H by 3."""

    poses: ExampleSet
    handles: np.ndarray
    frames: np.ndarray


@dataclass(frozen=True)
class Timed:
    """One way through a drag; seconds, medians over its frames but the first."""

    frame: float
    solve: float  # of it, what Tug itself does
    handle_error: float  # largest distance of a handle's vertex from its place, in diagonals
    converged: bool
    bind: float = 0.0


def add_object(poses: ExampleSet) -> bpy.types.Object:
    """The first pose, on an emptied scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return add_mesh("Tube", poses.shapes[0], poses.triangles.tolist())


def by_tug(drag: Drag) -> Timed:
    """With the first pose as rest shape and the others as keys."""
    obj = add_object(drag.poses)
    add_keys(obj, *drag.poses.shapes[1:])
    empties = [rig.add_handle(obj, int(v), f"Handle {i}") for i, v in enumerate(drag.handles)]
    start = time.perf_counter()
    rig.bind(obj)
    bound = time.perf_counter() - start
    return follow(drag, obj, empties, bound, lambda: rig.solve(obj, depsgraph()).converged)


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


def by_hooks(drag: Drag) -> Timed:
    """Nothing but the ten vertices moves: what any use of modifiers costs."""
    obj = add_object(drag.poses)
    return follow(drag, obj, add_hooks(obj, drag.handles))


def by_laplacian(drag: Drag, repeat: int) -> Timed:
    """The handles' vertices as its anchors, moved by hooks."""
    obj = add_object(drag.poses)
    empties = add_hooks(obj, drag.handles)
    anchors = obj.vertex_groups.new(name="Anchors")
    anchors.add([int(vertex) for vertex in drag.handles], 1.0, "REPLACE")
    modifier = obj.modifiers.new("Laplacian", "LAPLACIANDEFORM")
    modifier.vertex_group, modifier.iterations = anchors.name, repeat
    start = time.perf_counter()
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    evaluated(obj)
    bound = time.perf_counter() - start
    if not modifier.is_bind:
        raise RuntimeError("Laplacian Deform did not bind")
    return follow(drag, obj, empties, bound)


def follow(
    drag: Drag,
    obj: bpy.types.Object,
    empties: list[bpy.types.Object],
    bind: float = 0.0,
    solve: Callable[[], bool] = lambda: True,
) -> Timed:
    """All frames; `solve` tells whether it has converged."""
    times, converged, error = [], True, 0.0
    for targets in drag.frames:
        start = time.perf_counter()
        for empty, target in zip(empties, targets, strict=True):
            empty.location = target
        bpy.context.view_layer.update()
        before_solve = time.perf_counter()
        converged &= solve()
        after_solve = time.perf_counter()
        obj.evaluated_get(depsgraph()).data.vertices[0].co.copy()
        times.append((time.perf_counter() - start, after_solve - before_solve))
        error = max(error, farthest(evaluated(obj)[drag.handles], targets))
    frame, own = np.median(times[1:], axis=0).tolist()
    return Timed(frame, own, error / drag.poses.diagonal, converged, bind)


def measure(name: str, vertices: int) -> list[Row]:
    """Tug beside each of the others."""
    poses = tube(vertices, SHAPES)
    handles = poses.spread_handles(HANDLES)
    drag = Drag(poses, handles, next(draw_paths(poses, handles, 1)).frames(FRAMES - 1))
    own = by_tug(drag)
    sizes = {"vertices": len(poses.shapes[0]), "shapes": SHAPES, "handles": HANDLES}
    sizes |= {"blender": bpy.app.version_string, "handle_error": own.handle_error}
    of = f"{sizes['vertices']} vertices, Blender {sizes['blender']}"
    metric = f"solve, positions and writing the key, {of}"
    rows = [Row(name, metric, "ms", 1e3 * own.solve, converged=own.converged, sizes=sizes)]
    others = {"hooks alone": by_hooks(drag)}
    for repeat in REPEATS:
        others[f"Laplacian Deform, Repeat {repeat}, and hooks"] = by_laplacian(drag, repeat)
    for peer, other in others.items():
        both = sizes | {"peer_handle_error": other.handle_error}
        times = (1e3 * own.frame, peer, 1e3 * other.frame)
        rows.append(compare(name, f"a frame, {of}", "ms", *times, own.converged, both))
        if other.bind:
            rows.append(compare(name, f"bind, {of}", "s", own.bind, peer, other.bind, None, both))
    return rows


def main() -> None:
    name, vertices, out = arguments(sys.argv)
    addon.register()
    Path(out).write_text(json.dumps([asdict(row) for row in measure(name, int(vertices))]))


if __name__ == "__main__":
    main()
