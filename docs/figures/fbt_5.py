# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 5: eight points of two poses of a gallop, of which nobody says which foot is which;
and the frames between them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import gallop
import numpy as np
from project import Body, Form, Rows, Solution, creature, find_correspondence, interpolate

LEGS = ("Front Paw.L", "Front Paw.R", "Hind Paw.L", "Hind Paw.R")
KNOWN = ("Head", "Crown", "Rump", "Tail")
FORMS = {"steady": Form.STEADY, "minimal": Form.MINIMAL}
FRAMES = 4  # for one of the given two


@dataclass(frozen=True)
class Match:
    """What was found for one pose, and what is right: orders of the points. objectives: of all 24
    matchings, the right one first."""

    order: np.ndarray
    right: np.ndarray
    solves: int
    objectives: np.ndarray


@dataclass(frozen=True)
class Gallop:
    """points: for each pose 8 by 3, those of the legs shuffled. matches: by form and pose. frames:
    FRAMES + 1 poses, straight: the mixture of both ends by equal parts."""

    examples: np.ndarray
    triangles: np.ndarray
    colors: np.ndarray
    points: dict[str, np.ndarray]
    truths: dict[str, np.ndarray]
    matches: dict[str, dict[str, Match]]
    frames: np.ndarray
    straight: np.ndarray


def measure() -> Gallop:
    fox, truths = creature.sample(), gallop.shapes()
    shapes = np.stack([fox.shapes[name] for name in gallop.EXAMPLES])
    vertices = [fox.handles[name] for name in (*LEGS, *KNOWN)]
    random = np.random.default_rng(5)
    shuffles = {name: np.array([*random.permutation(4), 4, 5, 6, 7]) for name in truths}
    points = {name: truths[name][vertices][shuffles[name]] for name in truths}
    matches: dict[str, dict[str, Match]] = {}
    for name, form in FORMS.items():
        solver = Body(shapes, fox.triangles(), form=form).solver(Rows.pin(vertices))
        matches[name] = {pose: match(solver, points[pose], shuffles[pose]) for pose in truths}
    solver = Body(shapes, fox.triangles()).solver(Rows.pin(vertices))
    ends = [solved(solver, points[pose][found.order]) for pose, found in matches["steady"].items()]
    frames = [shown(solver, interpolate(*ends, share)) for share in np.linspace(0, 1, FRAMES + 1)]
    straight = 0.5 * (frames[0] + frames[-1])
    return Gallop(
        *(shapes, fox.triangles(), fox.colors, points, truths, matches),
        *(np.array(frames), straight),
    )


def match(solver: object, points: np.ndarray, shuffle: np.ndarray) -> Match:
    """Also what every matching costs, by which the right one can be compared with the others."""
    right, objectives = np.argsort(shuffle), []
    for legs in permutations(range(4)):
        objectives.append(solver.solve(points[right][[*legs, 4, 5, 6, 7]]).objective)
    found = find_correspondence(solver, points, [[0, 1, 2, 3]])
    return Match(found.order, right, found.solves, np.array(objectives))


def solved(solver: object, targets: np.ndarray) -> Solution:
    solver.solve(targets)
    return Solution(targets, solver.blend(), solver.rotations())


def shown(solver: object, given: Solution) -> np.ndarray:
    solver.pose(given.targets, given.blend, given.rotations)
    return solver.positions()


def edge_lengths(triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
    corners = positions[triangles]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


def numbers(found: Gallop) -> dict[str, dict]:
    """For each form and pose whether all feet were told apart, how many of the 24 matchings were
    solved for, and the objective of the right one in parts of the best wrong one. Of the frame
    half-way, by rotations and on straight lines: how much the edges are off from the mean of their
    lengths at both ends, on average."""
    table: dict[str, dict] = {"correspondence": {}, "half_way": {}}
    for form, by_pose in found.matches.items():
        table["correspondence"][form] = {
            pose: {
                "solved": bool((one.order == one.right).all()),
                "solves": one.solves,
                "right_to_best_wrong": float(one.objectives[0] / one.objectives[1:].min()),
            }
            for pose, one in by_pose.items()
        }
    ends = [edge_lengths(found.triangles, found.frames[end]) for end in (0, -1)]
    wanted = 0.5 * (ends[0] + ends[1])
    for name, pose in (("rotations", found.frames[FRAMES // 2]), ("straight", found.straight)):
        off = edge_lengths(found.triangles, pose) / wanted - 1
        table["half_way"][name] = float(np.abs(off).mean())
    steps = np.linalg.norm(np.diff(found.frames, axis=0), axis=2).mean(axis=1)
    table["longest_step_to_mean"] = float(steps.max() / steps.mean())
    return table


def draw(found: Gallop, path: Path) -> None:
    from drawing import Camera
    from strips import Panel, Strip
    from strips import draw as draw_strips

    camera, none = Camera(*gallop.VIEW), np.empty((0, 3), int)
    solid = {"triangles": found.triangles, "colors": found.colors}
    first, last = (
        Panel(f"given: 8 points,\n{pose.lower()}", truth, none, found.colors, *split(points))
        for (pose, truth), points in zip(found.truths.items(), found.points.values(), strict=True)
    )
    examples = [
        Panel(name, shape, **solid, boxed=True)
        for name, shape in zip(gallop.EXAMPLES, found.examples, strict=True)
    ]
    titles = ["found", *(f"frame {number} of {FRAMES}" for number in range(1, FRAMES)), "found"]
    frames = [
        Panel(title, shape, **solid) for title, shape in zip(titles, found.frames, strict=True)
    ]
    draw_strips([Strip(camera, [first, *examples, last]), Strip(camera, frames)], path)


def split(points: np.ndarray) -> tuple[np.ndarray, bool, np.ndarray]:
    """What is known, and the feet."""
    return points[4:], False, points[:4]
