# SPDX-License-Identifier: GPL-3.0-or-later
"""AMRAP's Figure 5: what goes wrong in MeshIK. A fox jumps between two poses; a coiled snake, held
where its drawing has the ends, becomes something else; a puffed square, one of its handles pushed a
little, goes flat as the mean of all squares is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from paths import Jump, follow, line, worst_jump
from problems import Method, Problem, mean_blend, mean_distance
from project import Sample, chameleon, creature, snake, squares

if TYPE_CHECKING:
    from matplotlib.figure import SubFigure

TIMES = np.linspace(0, 1, 31)
ROUNDS = 1000  # the coil takes 488
COIL = "Coiled"
PUSHES = (0.05, 0.1, 0.2, 0.4)  # of the rest shape's diagonal
PUSHED = {"squares": squares.sample, "snake": snake.sample, "chameleon": chameleon.sample}
METHODS = ("mesh_ik", "ours")


@dataclass(frozen=True)
class Recall:
    """What a method makes of the handles of each drawing: poses (#S by #V by 2) and objectives."""

    poses: np.ndarray
    objectives: np.ndarray


@dataclass(frozen=True)
class Push:
    """A handle of an example pushed aside, and each method's blend and pose."""

    example: int
    targets: np.ndarray
    blends: dict[str, np.ndarray]
    poses: dict[str, np.ndarray]


@dataclass(frozen=True)
class Artefacts:
    """pushes: for each scene and length all pushes."""

    fox: Problem
    jumps: dict[str, Jump]
    snake: Problem
    recalls: dict[str, Recall]
    squares: Problem
    pushes: dict[str, dict[float, list[Push]]]


def make_methods(problem: Problem) -> dict[str, Method]:
    return {"mesh_ik": problem.peer("mesh_ik", max_rounds=ROUNDS), "ours": problem.tug()}


def find_jumps(fox: Problem, times: np.ndarray) -> dict[str, Jump]:
    way = line(np.stack([fox.targets("Stretched"), fox.targets("Curled")]))
    return {
        name: worst_jump(method, way, follow(method, way, times))
        for name, method in make_methods(fox).items()
    }


def recall(problem: Problem, method: Method) -> Recall:
    poses, objectives = [], []
    for name in problem.sample.shapes:
        objectives.append(method.solve(problem.targets(name)).objective)
        poses.append(method.positions())
    return Recall(np.array(poses), np.array(objectives))


def pushed(problem: Problem, length: float) -> Iterator[Push]:
    """Every handle of every example pushed to the four sides."""
    methods = make_methods(problem)
    sides = problem.diagonal * length * np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    for example, handle, side in np.ndindex(len(problem.shapes), len(problem.handles), 4):
        targets = problem.shapes[example, problem.handles]
        targets[handle] += sides[side]
        for method in methods.values():
            method.solve(targets)
        yield Push(
            example,
            targets,
            {name: mean_blend(method) for name, method in methods.items()},
            {name: method.positions() for name, method in methods.items()},
        )


def measure(
    times: np.ndarray = TIMES,
    lengths: Sequence[float] = PUSHES,
    scenes: Sequence[str] = tuple(PUSHED),
) -> Artefacts:
    fox = Problem.of(creature.sample(), ("Head", "Tail", "Front Paw.L", "Hind Paw.R"))
    held = Problem.of(snake.sample(), ("Tail", "Head"))
    all_pushes: dict[str, dict[float, list[Push]]] = {}
    for scene in scenes:
        make: Callable[[], Sample] = PUSHED[scene]
        problem = Problem.of(make())
        all_pushes[scene] = {length: list(pushed(problem, length)) for length in lengths}
    recalls = {name: recall(held, method) for name, method in make_methods(held).items()}
    return Artefacts(
        fox, find_jumps(fox, times), held, recalls, Problem.of(squares.sample()), all_pushes
    )


def to_even(blend: np.ndarray) -> float:
    """Distance of the weights from those of the mean."""
    return float(np.linalg.norm(blend - 1 / len(blend)))


def to_one(blend: np.ndarray) -> float:
    """Distance of the weights from those of the nearest example."""
    return float(np.linalg.norm(np.eye(len(blend)) - blend, axis=1).min())


def numbers(found: Artefacts) -> dict[str, dict]:
    """Lengths in parts of the rest shape's diagonal.

    Of each method what is left of the fox's worst step; for each drawing of the snake whose handles
    are given the objective, and the mean distance of the vertices from that drawing. For each scene
    and length of a push: the mean weight of the example that was pushed, and how many blends of all
    are nearer to the even one than to any example.
    """
    table: dict[str, dict] = {}
    names = list(found.snake.sample.shapes)
    for method in METHODS:
        jump, held = found.jumps[method], found.recalls[method]
        apart = map(mean_distance, held.poses, found.snake.shapes)
        table[method] = {
            "movement_jump": jump.movement / found.fox.diagonal,
            "weight_jump": jump.weight,
            "jump_at": jump.time,
            "objective": dict(zip(names, held.objectives.tolist(), strict=True)),
            "distance": {n: d / found.snake.diagonal for n, d in zip(names, apart, strict=True)},
        }
    table["pushes"] = {
        scene: {str(length): _summary(pushes) for length, pushes in lengths.items()}
        for scene, lengths in found.pushes.items()
    }
    return table


def _summary(pushes: list[Push]) -> dict[str, float]:
    summary: dict[str, float] = {"pushes": len(pushes)}
    for method in METHODS:
        blends = [push.blends[method] for push in pushes]
        kept = [push.blends[method][push.example] for push in pushes]
        summary[f"{method}_kept"] = float(np.mean(kept))
        summary[f"{method}_nearer_to_even"] = sum(to_even(b) < to_one(b) for b in blends)
    return summary


def draw(found: Artefacts, path: Path) -> None:
    import drawing

    figure = drawing.plt.figure(figsize=(13.5, 4.6))
    parts = figure.subfigures(1, 3, width_ratios=[1.5, 0.9, 1.45], wspace=0.0)
    titles = ("discontinuous change", "local minimum", "regression to the mean")
    for part, title in zip(parts, titles, strict=True):
        part.suptitle(title, fontsize=12, y=0.985)
    draw_jump(parts[0], found)
    draw_coil(parts[1], found)
    draw_push(parts[2], found)
    drawing.save(figure, path)


def draw_jump(part: SubFigure, found: Artefacts) -> None:
    """The two poses of the fox for the same handles."""
    import drawing

    camera = drawing.Camera(*found.fox.sample.view)
    poses = [camera.project(pose) for pose in found.jumps["mesh_ik"].poses]
    window = drawing.window_around(poses)
    row = part.subplots(1, 2)
    part.subplots_adjust(0.01, 0.01, 0.99, 0.86, 0.02)
    for axes, pose, when in zip(row, poses, ("just before", "just after"), strict=True):
        drawing.draw_pose(axes, found.fox, pose, window)
        axes.set_title(f"MeshIK {when}", fontsize=10, color=drawing.GREY)


def draw_coil(part: SubFigure, found: Artefacts) -> None:
    """The drawing whose handles are given above, MeshIK's pose below."""
    import drawing

    problem = found.snake
    drawn = problem.shape(COIL)
    posed = found.recalls["mesh_ik"].poses[problem.number(COIL)]
    window = drawing.window_around([drawn, posed])
    column = part.subplots(2, 1)
    part.subplots_adjust(0.02, 0.01, 0.98, 0.86, 0, 0.14)
    for axes, pose, title in zip(column, (drawn, posed), ("example", "MeshIK"), strict=True):
        drawing.draw_pose(axes, problem, pose, window)
        axes.set_title(title, fontsize=10, color=drawing.GREY)


def draw_push(part: SubFigure, found: Artefacts) -> None:
    """The push of the shortest length whose blend by MeshIK is nearest to the even one."""
    import drawing

    problem = found.squares
    push = min(found.pushes["squares"][PUSHES[0]], key=lambda p: to_even(p.blends["mesh_ik"]))
    even = np.full(len(problem.shapes), 1 / len(problem.shapes))
    example, mean = problem.shapes[push.example], problem.shapes.mean(axis=0)
    own = np.eye(len(problem.shapes))[push.example]
    panels = (
        ("example", example, own, example[problem.handles]),
        ("mean of the examples", mean, even, mean[problem.handles]),
        ("AMRAP, middle handle pushed", push.poses["ours"], push.blends["ours"], push.targets),
        ("MeshIK, the same", push.poses["mesh_ik"], push.blends["mesh_ik"], push.targets),
    )
    window = drawing.window_around([pose for _, pose, _, _ in panels])
    grid = part.subplots(2, 2)
    part.subplots_adjust(0.02, 0.01, 0.98, 0.86, 0.05, 0.14)
    for axes, (title, pose, blend, handles) in zip(grid.flat, panels, strict=True):
        color = np.clip(blend @ drawing.SHAPE_COLORS, 0, 1)
        drawing.draw_grid(axes, pose, problem.sample.faces, color)
        drawing.draw_handles(axes, handles)
        drawing.frame(axes, window)
        axes.set_title(title, fontsize=10, color=drawing.GREY)
