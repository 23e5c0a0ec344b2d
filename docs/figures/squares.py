# SPDX-License-Identifier: GPL-3.0-or-later
"""squares.py OUTPUT: AMRAP's Figure 2, rows a and b, as a picture: the three squares of Figure 1
while the right handle is dragged out and back, and the blend weights on the way."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from addon.solver import Form, make_solver  # noqa: E402
from sample_scenes import squares  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

COLORS = np.array([[0.15, 0.35, 0.75], [0.15, 0.6, 0.25], [0.8, 0.2, 0.15]])  # one a shape
ROWS = (("a) without rotations", Form.NO_ROTATIONS), ("b) with rotations", Form.STEADY))
STEPS, POSES = 241, 7


def drag(form: Form) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dragged positions (#steps), mean blends (#steps by 3) and poses (#steps by #V by 2)."""
    sample = squares.sample()
    shapes = np.stack(list(sample.shapes.values()))[:, :, :2]
    handles = list(sample.handles.values())
    stops = shapes[:, handles[-1], 0]
    out = np.interp(np.linspace(0, 2, (STEPS + 1) // 2), [0, 1, 2], stops)
    path = np.concatenate([out, out[-2::-1]])
    targets, blends, poses = shapes[0][handles], [], []
    with make_solver(shapes, sample.triangles(), handles, form=form, single_blend=True) as solver:
        for x in path:
            targets[-1, 0] = x
            solver.solve(targets)
            blends.append(solver.blend().mean(axis=0))
            poses.append(solver.positions())
    return path, np.array(blends), np.array(poses)


def draw_shape(axes: plt.Axes, vertices: np.ndarray, color: np.ndarray) -> None:
    sample = squares.sample()
    pale = 0.45 * color + 0.55
    faces = PolyCollection(
        vertices[np.array(sample.faces)], facecolor=pale, edgecolor=color, linewidth=0.15
    )
    axes.add_collection(faces)
    axes.plot(*vertices[list(sample.handles.values())].T, "ko", markersize=3)
    axes.set(xlim=(-0.1, 1.95), ylim=(-0.85, 0.85), aspect="equal")
    axes.axis("off")


def draw(path: Path) -> None:
    sample = squares.sample()
    figure = plt.figure(figsize=(14, 5.4))
    grid = figure.add_gridspec(3, POSES + 3, width_ratios=[1.0] * 3 + [1.3] * POSES)
    for i, (name, shape) in enumerate(sample.shapes.items()):
        axes = figure.add_subplot(grid[0, 3 + 2 * i])
        draw_shape(axes, shape[:, :2], COLORS[i])
        axes.set_title(name, fontsize=10)
    for row, (title, form) in enumerate(ROWS, start=1):
        _, blends, poses = drag(form)
        graph = figure.add_subplot(grid[row, :3])
        for shape in range(3):
            graph.plot(np.linspace(0, 1, STEPS), blends[:, shape], color=COLORS[shape])
        graph.set(xlabel="time", ylabel="blend", ylim=(-0.03, 1.03))
        graph.set_title(title, fontsize=10, loc="left")
        for column, step in enumerate(np.linspace(0, STEPS - 1, POSES).round().astype(int)):
            axes = figure.add_subplot(grid[row, 3 + column])
            draw_shape(axes, poses[step], blends[step] @ COLORS)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
