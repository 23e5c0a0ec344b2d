# SPDX-License-Identifier: GPL-3.0-or-later
"""blender_drag.py NAME VERTICES OUT: inside Blender, what a step of a drag costs, part by part; as
rows of this name in the file OUT.

events: from the mouse to the place of the handle, and Python on the way to the solver. solve,
positions, write: what Tug adds. depsgraph: Blender's evaluation of the scene, and the normals that
drawing asks for. draw: of the whole window, where there is one. The frame is all of it, and is
compared with that of a mesh that has hooks instead.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import bpy
import numpy as np
from mathutils import Matrix, Vector

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "blender_tests"), str(CHECKOUT / "native" / "bench")]
from blender_deform import SHAPES, add_hooks, add_object  # noqa: E402
from blenders import arguments  # noqa: E402
from data import ExampleSet  # noqa: E402
from generated import tube  # noqa: E402
from suite import HANDLES, Row, compare  # noqa: E402
from support import add_keys, depsgraph  # noqa: E402

import addon  # noqa: E402
from addon.rigging import live, rig, shape_keys  # noqa: E402
from addon.solver import Solver  # noqa: E402
from addon.ui.drag import Drag  # noqa: E402
from addon.ui.pull import Pull  # noqa: E402

STEPS, RADIUS, ROUNDS = 24, 40, 4  # the first round is to settle
OURS = ("solve", "positions", "write")


@contextmanager
def stopwatches(seconds: dict[str, float]) -> Iterator[None]:
    """Adds to `seconds` what calls of the add-on take."""

    def timed(name: str, function: Callable) -> Callable:
        def call(*arguments: object, **named: object) -> object:
            start = time.perf_counter()
            try:
                return function(*arguments, **named)
            finally:
                seconds[name] += time.perf_counter() - start

        return call

    watched = ((Solver, "solve"), (live.Live, "pose"), (shape_keys, "write"), (rig, "follow"))
    with ExitStack() as stack:
        for owner, name in watched:
            call = timed(name, getattr(owner, name))
            stack.enter_context(mock.patch.object(owner, name, call))
        yield


def view_from_above() -> tuple[SimpleNamespace, SimpleNamespace]:
    """What picking and pulling ask of a region and its view."""
    lens = Matrix(((1.5, 0, 0, 0), (0, 2, 0, 0), (0, 0, -1.002, -0.2), (0, 0, -1, 0)))
    matrix = Matrix.Translation((0, 0, -20))
    view = SimpleNamespace(
        view_matrix=matrix,
        perspective_matrix=lens @ matrix,
        is_perspective=True,
        view_perspective="PERSP",
    )
    return SimpleNamespace(width=1920, height=1080), view


def evaluate(obj: bpy.types.Object) -> None:
    """What drawing asks of the evaluated mesh."""
    obj.evaluated_get(depsgraph()).data.corner_normals[0].vector.copy()


def has_window() -> bool:
    return not bpy.app.background and bool(bpy.app.binary_path)


def draw() -> None:
    if has_window():
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)


def mouse_path() -> np.ndarray:
    """ROUNDS * STEPS by 2 pixels: the same circle again and again."""
    angle = np.linspace(0, 2 * np.pi, STEPS, endpoint=False)
    circle = RADIUS * np.stack([np.cos(angle) - 1, np.sin(angle)], axis=1)
    return np.tile(circle, (ROUNDS, 1))


def typical(seconds: Sequence[float]) -> float:
    """In ms, the median over the steps of the least of the rounds, in which other programs were in
    the way the least: every pose is solved cold."""
    return 1e3 * float(np.median(np.reshape(seconds, (ROUNDS, STEPS))[1:].min(axis=0)))


def by_tug(poses: ExampleSet, handles: np.ndarray) -> dict[str, list[float]]:
    """Seconds of each part in each step."""
    obj = add_object(poses)
    add_keys(obj, *poses.shapes[1:])
    empties = [rig.add_handle(obj, int(v), f"Handle {i}") for i, v in enumerate(handles)]
    rig.bind(obj)
    drag = Drag(bpy.context, obj, empties[-1])
    region, view = view_from_above()
    pull = Pull(region, view, drag.start, Vector((960, 540)))
    parts: dict[str, list[float]] = defaultdict(list)
    for x, y in mouse_path():
        seconds: dict[str, float] = defaultdict(float)
        with stopwatches(seconds):
            times = [time.perf_counter()]
            pull.move(Vector((960 + x, 540 + y)), precise=False)
            times.append(time.perf_counter())
            drag.pull(pull.offset)
            times.append(time.perf_counter())
            evaluate(obj)
            times.append(time.perf_counter())
            draw()
            times.append(time.perf_counter())
        mouse, pulled, evaluated, drawn = np.diff(times)
        own = seconds["pose"] + seconds["write"]
        parts["events"].append(mouse + seconds["follow"] - own)
        parts["solve"].append(seconds["solve"])
        parts["positions"].append(seconds["pose"] - seconds["solve"])
        parts["write"].append(seconds["write"])
        parts["depsgraph"].append(pulled - seconds["follow"] + evaluated)
        if has_window():
            parts["draw"].append(drawn)
    return parts


def by_hooks(poses: ExampleSet, handles: np.ndarray) -> list[float]:
    """Seconds of each frame."""
    obj = add_object(poses)
    empties = add_hooks(obj, handles)
    place, frames = empties[-1].location.copy(), []
    for x, y in mouse_path():
        start = time.perf_counter()
        empties[-1].location = place + Vector((x, y, 0)) / 100
        bpy.context.view_layer.update()
        evaluate(obj)
        draw()
        frames.append(time.perf_counter() - start)
    return frames


def measure(name: str, vertices: int) -> list[Row]:
    poses = tube(vertices, SHAPES)
    handles = poses.spread_handles(HANDLES)
    parts = by_tug(poses, handles)
    frame = typical(np.sum(list(parts.values()), axis=0))
    medians = {part: typical(values) for part, values in parts.items()}
    sizes = {"vertices": len(poses.shapes[0]), "shapes": SHAPES, "handles": HANDLES}
    sizes |= {"blender": bpy.app.version_string}
    of = f"{sizes['vertices']} vertices, Blender {sizes['blender']}"
    rows = [Row(name, f"{part}, {of}", "ms", ms, sizes=sizes) for part, ms in medians.items()]
    ours = sum(medians[part] for part in OURS)
    evaluation = ("Blender's own evaluation", medians["depsgraph"])
    rows.append(
        compare(name, f"solve, positions and write, {of}", "ms", ours, *evaluation, None, sizes)
    )
    hooks = ("hooks alone", typical(by_hooks(poses, handles)))
    drawn = "drawn" if has_window() else "not drawn"
    rows.append(compare(name, f"a whole frame, {drawn}, {of}", "ms", frame, *hooks, None, sizes))
    return rows


def main() -> None:
    name, vertices, out = arguments(sys.argv)
    addon.register()
    Path(out).write_text(json.dumps([asdict(row) for row in measure(name, int(vertices))]))


def main_in_window() -> None:
    """Once Blender's loop has begun and there is a window; Blender would stay."""
    try:
        main()
    finally:
        os._exit(0)


if __name__ == "__main__":
    if has_window():
        bpy.app.timers.register(main_in_window, first_interval=0.5)
    else:
        main()
