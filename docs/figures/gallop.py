# SPDX-License-Identifier: GPL-3.0-or-later
"""The fox of the sample scenes as it gallops, which none of its examples shows."""

from __future__ import annotations

from functools import cache

import numpy as np
from project import creature

from sample_scenes.skeleton import Pose

EXAMPLES = ("Basis", "Stretched", "Stepping", "Pouncing")  # of the scene: what is known of the fox
VIEW = (66, 9)
POSES = {
    "Flying": Pose(
        move=(0, 0.04, 0.16),
        turns={
            "hips": (8, 0, 0),
            "loin": (-7, 0, 0),
            "chest": (-9, 0, 0),
            "neck": (6, 0, 0),
            "tail 1": (6, 0, 0),
            "tail 4": (-26, 0, 0),
            "tail 5": (-30, 0, 0),
        },
        paws={
            "front paw.L": (0.15, -0.84, 0.56),
            "front paw.R": (-0.15, -0.72, 0.40),
            "hind paw.L": (0.17, 0.86, 0.36),
            "hind paw.R": (-0.17, 0.96, 0.52),
        },
        facing={
            "front paw.L": (20, 0, 0),
            "front paw.R": (30, 0, 0),
            "hind paw.L": (105, 0, 0),
            "hind paw.R": (120, 0, 0),
        },
        length={"loin": 1.1, "chest": 1.08},
    ),
    "Gathered": Pose(
        move=(0, 0.0, 0.10),
        turns={
            "hips": (-22, 0, 0),
            "loin": (22, 0, 0),
            "chest": (22, 0, 0),
            "neck": (-14, 0, 0),
            "head": (-4, 0, 0),
            "tail 1": (26, 0, 0),
            "tail 2": (10, 0, 0),
        },
        paws={
            "front paw.L": (0.14, -0.02, 0.22),
            "front paw.R": (-0.14, 0.08, 0.32),
            "hind paw.L": (0.19, 0.02, 0.22),
            "hind paw.R": (-0.19, -0.10, 0.14),
        },
        facing={
            "front paw.L": (70, 0, 0),
            "front paw.R": (95, 0, 0),
            "hind paw.L": (-10, 0, 0),
            "hind paw.R": (-15, 0, 0),
        },
    ),
}


@cache
def shapes() -> dict[str, np.ndarray]:
    """Name -> #V by 3."""
    sample = creature.sample()
    return creature.posed(sample.rest, np.array(sample.faces), POSES)
