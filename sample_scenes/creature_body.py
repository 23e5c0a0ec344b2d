# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a young fox: an implicit sculpture, its bones and its colours. NumPy only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .implicit import Cone, surface_nets, union
from .sculpt import edges_of, settle, skin_weights, smoothstep
from .skeleton import Bone, Leg, Skeleton

SPACING = 0.036


def mirrored(name: str, *cones: Cone) -> dict[str, list[Cone]]:
    """The cones of the animal's left side (+X) and the same on its right."""
    flip = np.array((-1, 1, 1))
    right = [replace(c, start=flip * c.start, end=flip * c.end) for c in cones]
    return {f"{name}.L": list(cones), f"{name}.R": right}


# Part by part; the first cone of each is also where the part's bone lies.
BODY = {
    "hips": [Cone((0, 0.44, 0.70), (0, 0.30, 0.70), (0.215, 0.22))],
    "loin": [Cone((0, 0.30, 0.70), (0, 0.02, 0.69), (0.215, 0.215), blend=0.03)],
    "chest": [
        Cone((0, 0.02, 0.69), (0, -0.30, 0.72), (0.215, 0.24), blend=0.03),
        Cone((0, -0.36, 0.68), (0, -0.42, 0.80), (0.17, 0.16), blend=0.12),
    ],
    "neck": [Cone((0, -0.36, 0.86), (0, -0.58, 1.08), (0.17, 0.16), blend=0.12)],
    "head": [
        Cone((0, -0.58, 1.10), (0, -0.72, 1.18), (0.15, 0.2)),
        Cone((0, -0.66, 1.22), (0, -0.78, 1.20), (0.29, 0.28), (0.9, 1, 1), blend=0.1),
        Cone((0.16, -0.78, 1.09), (0.30, -0.72, 1.05), (0.15, 0.05), blend=0.12),
        Cone((-0.16, -0.78, 1.09), (-0.30, -0.72, 1.05), (0.15, 0.05), blend=0.12),
        Cone((0, -0.92, 1.10), (0, -1.17, 1.06), (0.15, 0.07), blend=0.14),
    ],
    **mirrored(
        "ear",
        Cone((0.17, -0.64, 1.38), (0.29, -0.62, 1.76), (0.17, 0.035), (1, 1.7, 1), blend=0.05),
        Cone((0.20, -0.74, 1.51), (0.27, -0.68, 1.66), (0.085, 0.03), (1, 1.2, 1), 0.04, True),
    ),
    **mirrored(
        "upper arm", Cone((0.15, -0.30, 0.60), (0.16, -0.24, 0.38), (0.135, 0.095), blend=0.1)
    ),
    **mirrored("forearm", Cone((0.16, -0.24, 0.38), (0.16, -0.28, 0.12), (0.095, 0.075))),
    **mirrored(
        "front paw", Cone((0.16, -0.29, 0.08), (0.165, -0.38, 0.07), (0.085, 0.09), blend=0.06)
    ),
    **mirrored("thigh", Cone((0.14, 0.42, 0.60), (0.175, 0.30, 0.38), (0.185, 0.115), blend=0.1)),
    **mirrored("shin", Cone((0.175, 0.30, 0.38), (0.165, 0.45, 0.13), (0.105, 0.075))),
    **mirrored("hind paw", Cone((0.165, 0.44, 0.08), (0.17, 0.33, 0.07), (0.08, 0.09), blend=0.06)),
    "tail 1": [Cone((0, 0.56, 0.78), (0, 0.78, 0.84), (0.075, 0.10), blend=0.08)],
    "tail 2": [Cone((0, 0.78, 0.84), (0, 1.00, 0.95), (0.10, 0.15), blend=0.02)],
    "tail 3": [Cone((0, 1.00, 0.95), (0, 1.17, 1.12), (0.15, 0.165), blend=0.02)],
    "tail 4": [Cone((0, 1.17, 1.12), (0, 1.27, 1.33), (0.165, 0.12), blend=0.02)],
    "tail 5": [Cone((0, 1.27, 1.33), (0, 1.30, 1.56), (0.12, 0.02), blend=0.02)],
}
FACE = {
    "nose": Cone((0, -1.22, 1.085), (0, -1.235, 1.09), (0.06, 0.055), (0.85, 1, 1.1), 0.03),
    "eye.L": Cone((0.14, -0.98, 1.24), (0.145, -0.99, 1.245), (0.075, 0.07), blend=0.02),
    "eye.R": Cone((-0.14, -0.98, 1.24), (-0.145, -0.99, 1.245), (0.075, 0.07), blend=0.02),
}

PARENTS = {
    "loin": "hips",
    "chest": "loin",
    "neck": "chest",
    "head": "neck",
    "ear": "head",
    "upper arm": "chest",
    "forearm": "upper arm",
    "front paw": "forearm",
    "thigh": "hips",
    "shin": "thigh",
    "hind paw": "shin",
    "tail 1": "hips",
    "tail 2": "tail 1",
    "tail 3": "tail 2",
    "tail 4": "tail 3",
    "tail 5": "tail 4",
}

FUR, CREAM, DARK, BLACK = (0.60, 0.17, 0.03), (0.85, 0.74, 0.60), (0.07, 0.03, 0.02), (0.01,) * 3


def sculpture() -> tuple[np.ndarray, np.ndarray]:
    """The rest pose: vertices #V by 3 and quads #F by 4, closed."""
    field = union([cone for cones in BODY.values() for cone in cones] + list(FACE.values()))
    # Half a cell off the symmetry plane, so that both sides get the same vertices.
    half = SPACING * (np.ceil(0.5 / SPACING) + 0.5)
    vertices, quads = surface_nets(field, (-half, -1.4, -0.1), (half, 1.55, 1.9), SPACING)
    return settle(vertices, edges_of(quads), field, 12), quads


def skeleton() -> Skeleton:
    """A bone per part; front elbows point back, hind knees forward, both a little outwards."""
    bones = {}
    for name, cones in BODY.items():
        part, dot, side = name.partition(".")
        parent = PARENTS.get(part)
        own_side = f"{parent}{dot}{side}"
        bones[name] = Bone(own_side if own_side in BODY else parent, cones[0].start, cones[0].end)
    legs = [
        Leg(f"{upper}.{side}", f"{lower}.{side}", f"{paw}.{side}", (sign * pole[0], pole[1], 0))
        for upper, lower, paw, pole in (
            ("upper arm", "forearm", "front paw", (0.1, 1)),
            ("thigh", "shin", "hind paw", (0.3, -1)),
        )
        for side, sign in (("L", 1), ("R", -1))
    ]
    return Skeleton(bones, legs)


def weights(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """#V by #B, of the skeleton's bones."""
    parts = BODY | {"head": BODY["head"] + list(FACE.values())}
    return skin_weights(list(parts.values()), vertices, edges)


def painted(rest: np.ndarray) -> np.ndarray:
    """#V by 3, linear RGB: russet, cream below and at the tail's tip, dark feet and ears."""
    x, y, z = np.abs(rest[:, 0]), rest[:, 1], rest[:, 2]
    head = smoothstep(-0.52, -0.60, y) * smoothstep(0.85, 0.95, z)
    muzzle = head * smoothstep(1.16, 1.10, z + 0.35 * np.maximum(0.16 - x, 0.0))
    bib = smoothstep(-0.43, -0.52, y) * smoothstep(0.5, 0.6, z) * smoothstep(1.04, 0.98, z)
    belly = smoothstep(0.56, 0.50, z) * smoothstep(0.14, 0.08, x) * (y < 0.6)
    tail_tip = smoothstep(1.24, 1.30, 0.4 * (y - 1.2) + z)
    stocking = smoothstep(0.32, 0.24, z)
    ear_tip = smoothstep(1.60, 1.66, z) * (y < 0)
    color = np.tile(FUR, (len(rest), 1))
    for mask, paint in (
        (np.max([muzzle, bib, belly, tail_tip * (y > 0)], axis=0), CREAM),
        (np.maximum(stocking, ear_tip), DARK),
        *((smoothstep(0.016, 0.004, cone.distance(rest)), BLACK) for cone in FACE.values()),
    ):
        color += mask[:, None] * (np.array(paint) - color)
    return color
