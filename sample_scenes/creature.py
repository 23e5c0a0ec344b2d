# SPDX-License-Identifier: GPL-3.0-or-later
"""A young fox in seven poses. NumPy only."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .creature_body import painted, sculpture, skeleton, weights
from .implicit import smooth_min
from .sample import BASIS, Sample, Waypoint, nearest_pair, nearest_vertex
from .sculpt import edges_of
from .skeleton import Pose, Skin

# The examples besides the rest pose.
POSES = {
    "Stretched": Pose(
        move=(0, 0.16, 0.02),
        turns={
            "hips": (18, 0, 0),
            "loin": (5, 0, 0),
            "chest": (-6, 0, 0),
            "neck": (-30, 0, 0),
        },
        facing={
            "head": (-8, 0, 0),
            "tail 1": (14, 0, 0),
            "tail 2": (8, 0, 0),
            "tail 3": (-4, 0, 0),
            "tail 4": (-20, 0, 0),
            "tail 5": (-34, 0, 0),
        },
        paws={
            "front paw.L": (0.19, -0.84, 0.12),
            "front paw.R": (-0.17, -0.74, 0.12),
            "hind paw.L": (0.19, 0.74, 0.13),
            "hind paw.R": (-0.19, 0.66, 0.13),
        },
        length={"loin": 1.3, "chest": 1.25, "neck": 1.15},
    ),
    "Curled": Pose(
        move=(-0.1, 0.0, -0.46),
        turns={
            "hips": (0, 0, -10),
            "loin": (0, 0, 35),
            "chest": (0, 0, 40),
            "neck": (72, 0, 38),
        },
        paws={
            "front paw.L": (0.50, 0.24, 0.09),
            "front paw.R": (0.56, -0.02, 0.09),
            "hind paw.L": (0.20, 0.27, 0.09),
            "hind paw.R": (-0.26, 0.18, 0.09),
        },
        facing={
            "head": (8, 0, 118),
            "tail 1": (-45, 0, -50),
            "tail 2": (-36, 0, -85),
            "tail 3": (-46, 0, -95),
            "tail 4": (-62, 0, -112),
            "tail 5": (-80, 0, -140),
            "front paw.L": (0, 0, 75),
            "front paw.R": (0, 0, 85),
            "hind paw.L": (0, 0, 30),
            "hind paw.R": (0, 0, 10),
        },
    ),
    "Looking Left": Pose(
        turns={
            "chest": (0, 0, 8),
            "neck": (0, 0, 30),
            "head": (-4, -10, 38),
            "tail 1": (0, 0, 12),
            "tail 2": (0, 0, 16),
            "tail 3": (0, 0, 18),
            "tail 4": (0, 0, 16),
        },
        paws={
            "front paw.L": (0.16, -0.28, 0.12),
            "front paw.R": (-0.16, -0.30, 0.12),
        },
    ),
    "Sitting": Pose(
        move=(0, -0.09, -0.44),
        turns={
            "hips": (-38, 0, 0),
            "neck": (12, 0, 0),
            "head": (26, 0, 0),
            "tail 1": (18, 0, -15),
            "tail 2": (-10, 0, -30),
            "tail 3": (-16, 0, -30),
            "tail 4": (-18, 0, -30),
            "tail 5": (-16, 0, -25),
        },
        paws={
            "front paw.L": (0.13, -0.30, 0.12),
            "front paw.R": (-0.13, -0.30, 0.12),
            "hind paw.L": (0.24, 0.10, 0.13),
            "hind paw.R": (-0.24, 0.10, 0.13),
        },
        facing={"hind paw.L": (0, 0, 15), "hind paw.R": (0, 0, -15)},
    ),
    "Stepping": Pose(
        move=(0.0, -0.03, 0.0),
        turns={
            "hips": (-3, 0, 0),
            "neck": (-10, 0, 0),
            "head": (8, 0, 0),
            "tail 1": (12, 0, 0),
            "tail 2": (10, 0, 0),
        },
        paws={
            "front paw.L": (0.16, -0.60, 0.46),
            "front paw.R": (-0.14, -0.22, 0.12),
            "hind paw.L": (0.16, 0.58, 0.15),
            "hind paw.R": (-0.16, 0.26, 0.13),
        },
        facing={"front paw.L": (55, 0, 0), "hind paw.L": (15, 0, 0)},
    ),
    "Pouncing": Pose(
        move=(0, 0.1, 0.45),
        turns={
            "hips": (2, 0, 0),
            "loin": (14, 0, 0),
            "chest": (14, 0, 0),
            "neck": (0, 0, 0),
            "head": (6, 0, 0),
            "tail 1": (10, 0, 0),
            "tail 3": (-12, 0, 0),
            "tail 4": (-14, 0, 0),
        },
        paws={
            "front paw.L": (0.13, -0.62, 0.46),
            "front paw.R": (-0.13, -0.56, 0.42),
            "hind paw.L": (0.16, 0.98, 0.82),
            "hind paw.R": (-0.16, 0.94, 0.76),
        },
        facing={
            "front paw.L": (30, 0, 0),
            "front paw.R": (30, 0, 0),
            "hind paw.L": (110, 0, 0),
            "hind paw.R": (110, 0, 0),
        },
        length={"loin": 1.1, "chest": 1.1},
    ),
}


def posed(rest: np.ndarray, quads: np.ndarray, poses: Mapping[str, Pose]) -> dict[str, np.ndarray]:
    """The shape of each pose; what would sink into the ground is pressed flat."""
    edges = edges_of(quads)
    skin = Skin(skeleton(), rest, edges, weights(rest, edges))
    shapes = {}
    for name, pose in poses.items():
        shape = skin.posed(pose)
        shape[:, 2] = -smooth_min(-shape[:, 2], np.zeros(len(shape)), 0.03)
        shapes[name] = shape
    return shapes


def sample() -> Sample:
    """About 6,600 vertices; it looks along -Y."""
    rest, quads = sculpture()
    return Sample(
        name="creature",
        faces=quads.tolist(),
        shapes={BASIS: rest} | posed(rest, quads, POSES),
        handles={
            "Head": nearest_vertex(rest, (0, -1.29, 1.09)),
            "Crown": nearest_vertex(rest, (0, -0.70, 1.50)),
            "Chest": nearest_vertex(rest, (0, -0.57, 0.70)),
            "Back": nearest_vertex(rest, (0, 0.10, 0.91)),
            "Rump": nearest_vertex(rest, (0, 0.50, 0.92)),
            "Tail": nearest_vertex(rest, (0, 1.30, 1.58)),
            **nearest_pair("Front Paw", rest, (0.165, -0.47, 0.07)),
            **nearest_pair("Hind Paw", rest, (0.17, 0.24, 0.07)),
        },
        motion=[
            Waypoint(1, BASIS),
            Waypoint(8, "Looking Left"),
            Waypoint(14, "Stepping"),
            Waypoint(19, "Stretched"),
            Waypoint(23, "Pouncing"),
            Waypoint(29, "Sitting"),
            Waypoint(33, "Sitting", {"Front Paw.L": (0.05, -0.2, 0.4), "Head": (0, 0.05, 0.15)}),
            Waypoint(41, "Curled"),
            Waypoint(48, BASIS),
        ],
        colors=painted(rest),
        view=(40, 14),
    )
