# SPDX-License-Identifier: GPL-3.0-or-later
"""A hand in eight poses, made with the tools of the sample scenes. NumPy only."""

from __future__ import annotations

from functools import cache

import numpy as np
from project import Sample

from sample_scenes.implicit import Cone, surface_nets, union
from sample_scenes.sample import BASIS
from sample_scenes.sculpt import edges_of, settle, skin_weights
from sample_scenes.skeleton import Bone, Pose, Skeleton, Skin

SPACING = 0.034
VIEW = (-20, 12)
# Where each finger begins, which way it points, and how long its bones are.
FINGERS = {
    "thumb": ((0.20, -0.06, 0.40), (0.72, -0.22, 0.62), (0.36, 0.31, 0.25)),
    "index": ((0.33, 0.0, 1.06), (0.11, 0, 1), (0.42, 0.27, 0.20)),
    "middle": ((0.11, 0.0, 1.10), (0.03, 0, 1), (0.46, 0.30, 0.22)),
    "ring": ((-0.12, 0.0, 1.06), (-0.05, 0, 1), (0.42, 0.28, 0.21)),
    "little": ((-0.34, 0.0, 0.95), (-0.14, 0, 1), (0.33, 0.21, 0.18)),
}
SKIN = (0.72, 0.34, 0.22)


def bends(**fingers: tuple[float, float, float]) -> Pose:
    """A pose: for each finger the angles in degrees by which its joints bend into the palm."""
    turns = {
        f"{finger} {number}": bend(finger, number, angle)
        for finger, angles in fingers.items()
        for number, angle in enumerate(angles, 1)
    }
    return Pose(turns=turns)


def bend(finger: str, number: int, angle: float) -> tuple[float, float, float]:
    """Fingers bend forward, the thumb across the palm."""
    if finger != "thumb":
        return (angle, 0, 0)
    return (0.75 * angle, -0.6 * angle, 0) if number == 1 else (0.3 * angle, -0.9 * angle, 0)


CLOSED, HOOKED = (84, 92, 55), (8, 75, 55)
POSES = {
    "Fist": bends(thumb=(50, 35, 40), index=CLOSED, middle=CLOSED, ring=CLOSED, little=CLOSED),
    "Pointing": bends(thumb=(45, 30, 30), middle=CLOSED, ring=CLOSED, little=CLOSED),
    "Thumb Up": bends(
        thumb=(-12, -8, -10), index=CLOSED, middle=CLOSED, ring=CLOSED, little=CLOSED
    ),
    "Hook": bends(thumb=(10, 10, 10), index=HOOKED, middle=HOOKED, ring=HOOKED, little=HOOKED),
    "Four": bends(thumb=(48, 38, 35)),
    "Pinch": bends(thumb=(48, 18, 25), index=(52, 48, 25), middle=(18, 12, 8), ring=(8, 8, 5)),
    "Two": bends(thumb=(48, 38, 35), ring=CLOSED, little=CLOSED),
}


def parts() -> dict[str, list[Cone]]:
    """By bone; the first cone of each is where it lies."""
    found = {"palm": [Cone((0, 0, 0.10), (0, 0, 0.50), (0.25, 0.27), (1, 1.5, 1))]}
    for finger, (start, way, lengths) in FINGERS.items():
        start, way = np.array(start), np.array(way) / np.linalg.norm(way)
        thumb = finger == "thumb"
        if not thumb:
            found["palm"].append(Cone((0.55 * start[0], 0, 0.42), start, (0.19, 0.125), blend=0.12))
        radius, thinner = (0.155, 0.016) if thumb else (0.108, 0.007)
        for number, length in enumerate(lengths, 1):
            radii = (radius, radius - thinner)
            end = start + length * way
            found[f"{finger} {number}"] = [Cone(start, end, radii, blend=0.1 if thumb else 0.04)]
            start, radius = end, radii[1]
    return found


def skeleton(cones: dict[str, list[Cone]]) -> Skeleton:
    bones = {}
    for name, (first, *_) in cones.items():
        finger, _, number = name.partition(" ")
        parent = f"{finger} {int(number) - 1}" if number > "1" else "palm"
        bones[name] = Bone(parent if number else None, first.start, first.end)
    return Skeleton(bones, [])


@cache
def sample() -> Sample:
    """Open at rest, the palm towards -Y."""
    cones = parts()
    field = union([cone for part in cones.values() for cone in part])
    rest, quads = surface_nets(field, (-0.85, -0.5, -0.1), (1.25, 0.5, 2.3), SPACING)
    edges = edges_of(quads)
    rest = settle(rest, edges, field, 12)
    skin = Skin(skeleton(cones), rest, edges, skin_weights(list(cones.values()), rest, edges))
    shapes = {BASIS: rest} | {name: skin.posed(pose) for name, pose in POSES.items()}
    return Sample(
        name="hand",
        faces=quads.tolist(),
        shapes=shapes,
        handles={},
        motion=[],
        colors=np.tile(SKIN, (len(rest), 1)),
        view=VIEW,
    )
