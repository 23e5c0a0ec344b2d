# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions for Blender's own monkey, as smooth displacements found by position alone.

She looks along -Y; her head reaches from -1.3 to 1.3 in X and from -1 to 0.9 in Z. Each eyeball
is a component of its own and has a handle of its own. NumPy only.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from .sample import BASIS, Sample, Waypoint, nearest_pair, nearest_vertex
from .sculpt import bump, components, edges_of, smoothstep

EYE = np.array((0.33, -0.585, 0.245))  # middle of the left eyeball
EYE_RADIUS = 0.25
PUPIL = np.array((0.35, -0.82, 0.245))
MOUTH = np.array((0.0, -0.73, -0.815))
LIPS = np.array((0.088, 0.055))  # half width and half height of the mouth at rest


def pulled(
    rest: np.ndarray, centre: Sequence[float], radii: Sequence[float], move: Sequence[float]
) -> np.ndarray:
    """#V by 3: `move` at `centre`, fading out over an ellipsoid; the same mirrored in X."""
    total = np.zeros_like(rest)
    for side in (1, -1):
        mirror = np.array((side, 1, 1))
        distance = np.linalg.norm((rest - mirror * centre) / np.asarray(radii), axis=1)
        total += bump(distance, 1.0)[:, None] * (mirror * move)
    return total


def mouth(
    rest: np.ndarray, lips: Sequence[float], curve: float = 0.0, deep: float = 0.0
) -> np.ndarray:
    """#V by 3: lips of other half width and half height, corners lifted by `curve`, the hollow
    between them pushed in by `deep`."""
    x, height = rest[:, 0], rest[:, 2] - MOUTH[2]
    radius = np.hypot(x / LIPS[0], height / LIPS[1])
    front = smoothstep(-0.45, -0.6, rest[:, 1])
    fade = front * smoothstep(3.2, 1.0, radius)
    reach = fade / np.maximum(radius, 1.0)
    across = (lips[0] / LIPS[0] - 1) * x * reach
    upward = (lips[1] / LIPS[1] - 1) * height * reach
    corner = np.clip(np.abs(x) / LIPS[0], 0, 1.6) ** 2
    # The muzzle is about the parabola y = x^2 there: the lips slide along it.
    back = (x + across) ** 2 - x**2 + deep * front * smoothstep(1.0, 0.7, radius)
    return np.stack([across, back, upward + curve * corner * fade], axis=1)


def jaw(rest: np.ndarray, drop: float) -> np.ndarray:
    """#V by 3: everything below the upper lip lowered by `drop`, the cheeks drawn along."""
    aside = smoothstep(0.07, 0.16, np.abs(rest[:, 0]))
    behind = smoothstep(-0.6, -0.45, rest[:, 1])
    loose = np.maximum(aside, behind)
    top, bottom = MOUTH[2] + 0.01 + 0.22 * loose, MOUTH[2] - 0.02 - 0.05 * loose
    share = smoothstep(0.0, 1.0, np.clip((top - rest[:, 2]) / (top - bottom), 0, 1))
    # The lip's ends hang less than its middle: the open mouth is round.
    lip = smoothstep(-0.93, -0.87, rest[:, 2]) * (1 - loose)
    hang = drop * (1 - 0.45 * np.clip(rest[:, 0] / 0.1, -1, 1) ** 2 * lip)
    return (share * hang)[:, None] * np.array((0.0, 0.25, -1.0))


def from_eye(points: np.ndarray) -> np.ndarray:
    """#V by 3: from the middle of the eyeball on the same side."""
    return points - np.where(points[:, :1] < 0, (-1, 1, 1), (1, 1, 1)) * EYE


def lids(rest: np.ndarray, upper: float, lower: float) -> np.ndarray:
    """#V by 3: what is above an eye's middle lowered and what is below it raised, as fractions."""
    x, _, height = from_eye(rest).T
    fade = smoothstep(0.46, 0.25, np.hypot(x, height)) * smoothstep(-0.35, -0.5, rest[:, 1])
    closing = fade * np.where(height > 0, upper, lower)
    return np.outer(-closing * height, (0, 0, 1))


def over_eyes(rest: np.ndarray, move: np.ndarray) -> np.ndarray:
    """#V by 3: `move` with what comes close to an eyeball sliding over it."""
    offset = from_eye(rest + move)
    distance = np.linalg.norm(offset, axis=1)
    # The folds around the eyes reach into the eyeballs at rest and stay where nothing moves.
    moving = smoothstep(0.0, 0.03, np.linalg.norm(move, axis=1)) * (offset[:, 1] < 0)
    lift = moving * np.maximum(EYE_RADIUS / distance - 1, 0)
    return move + lift[:, None] * offset


def eyeballs(rest: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """#V bool: all but the largest component."""
    part = components(edges_of(quads), len(rest))
    return part != np.bincount(part).argmax()


def expressions(rest: np.ndarray, eyeball: np.ndarray) -> dict[str, np.ndarray]:
    """The example shapes, the rest pose first. The eyeballs stay where they are: their handles
    could not tell."""

    pull = partial(pulled, rest)
    cheek, brow = (0.36, -0.62, -0.12), (0.32, -0.75, 0.66)
    moves = {
        "Smile": mouth(rest, (0.24, 0.05), curve=0.055, deep=0.06)
        + pull((0.24, -0.62, -0.72), (0.26, 0.4, 0.3), (0.10, 0.03, 0.06))
        + pull(cheek, (0.34, 0.4, 0.26), (0.06, -0.07, 0.09))
        + lids(rest, 0.0, 0.35),
        "Open": mouth(rest, (0.12, 0.10), deep=0.22)
        + jaw(rest, 0.30)
        + pull(brow, (0.9, 0.4, 0.30), (0, 0, 0.04)),
        "Brows Up": pull(brow, (0.9, 0.45, 0.32), (0, 0, 0.11)) + mouth(rest, (0.07, 0.07)),
        "Frown": pull((0.18, -0.75, 0.60), (0.34, 0.4, 0.30), (-0.04, -0.06, -0.20))
        + pull((0.66, -0.6, 0.46), (0.26, 0.4, 0.24), (0.03, 0, 0.09))
        + mouth(rest, (0.15, 0.04), curve=-0.035),
        "Puffed": pull((0.28, -0.5, -0.55), (0.34, 0.42, 0.42), (0.21, -0.06, 0))
        + mouth(rest, (0.05, 0.035))
        + pull(MOUTH, (0.12, 0.3, 0.12), (0, -0.04, 0)),
        "Squint": lids(rest, 0.5, 0.5)
        + pull(cheek, (0.34, 0.4, 0.28), (0.02, -0.06, 0.10))
        + pull((0.3, -0.75, 0.56), (0.4, 0.4, 0.22), (-0.02, -0.03, -0.10)),
    }
    skin = ~eyeball[:, None]
    return {BASIS: rest} | {
        name: rest + skin * over_eyes(rest, move) for name, move in moves.items()
    }


def painted(rest: np.ndarray, eyeball: np.ndarray) -> np.ndarray:
    """#V by 3, linear RGB: brown fur, a lighter face, white eyes with dark pupils."""
    x, y, z = np.abs(rest[:, 0]), rest[:, 1], rest[:, 2]
    from_pupil = np.hypot(x - PUPIL[0], z - PUPIL[2])
    front = smoothstep(-0.25, -0.45, y)
    face = front * np.maximum(smoothstep(-0.15, -0.3, z), smoothstep(0.46, 0.36, from_pupil))
    in_mouth = np.hypot(x / LIPS[0], (z - MOUTH[2]) / LIPS[1]) < 0.95
    color = np.tile((0.17, 0.065, 0.03), (len(rest), 1))
    for mask, paint in (
        (face, (0.60, 0.36, 0.22)),
        (in_mouth * front, (0.16, 0.02, 0.02)),
        (1.0 * eyeball, (0.85, 0.85, 0.82)),
        (eyeball * smoothstep(0.105, 0.085, from_pupil), (0.02, 0.012, 0.01)),
    ):
        color += mask[:, None] * (np.array(paint) - color)
    return color


def sample(rest: np.ndarray, quads: np.ndarray) -> Sample:
    """The face on `rest` (#V by 3) and `quads` of the subdivided monkey."""
    eyeball = eyeballs(rest, quads)
    return Sample(
        name="face",
        faces=quads.tolist(),
        shapes=expressions(rest, eyeball),
        handles={
            "Crown": nearest_vertex(rest, (0, 0.1, 0.92)),
            **nearest_pair("Brow", rest, (0.25, -0.75, 0.66)),
            **nearest_pair("Lid", rest, (0.35, -0.74, 0.02)),
            **nearest_pair("Cheek", rest, (0.28, -0.6, -0.5)),
            **nearest_pair("Lips", rest, (0.088, -0.71, -0.815)),
            "Chin": nearest_vertex(rest, (0, -0.63, -0.94)),
            **nearest_pair("Eye", rest, PUPIL),
        },
        motion=[
            Waypoint(1, BASIS),
            Waypoint(8, "Smile"),
            Waypoint(12, "Smile", {"Brow.L": (0, 0, 0.1)}),
            Waypoint(19, "Open"),
            Waypoint(25, "Brows Up"),
            Waypoint(31, "Frown"),
            Waypoint(37, "Squint"),
            Waypoint(42, "Puffed"),
            Waypoint(48, BASIS),
        ],
        colors=painted(rest, eyeball),
        view=(12, 4),
    )
