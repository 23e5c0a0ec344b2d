# SPDX-License-Identifier: GPL-3.0-or-later
"""A flat chameleon that opens its mouth as it reaches forward, and shuts it on what it has caught.

Like the three squares, its drawings lie on one way of the snout: the mouth is shut at rest, open
half-way, shut again at the end. The body is a strip along a spine, from the tail's tip to the
snout; from the corner of the mouth on it is two, the jaws. Legs are strips that grow from the
belly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .sample import BASIS, Sample, Waypoint, grid_quads
from .sculpt import bump, smoothstep
from .spine import spine

ACROSS, ALONG = 13, 101  # vertices of the body's strip, from back to belly and from tail to snout
MIDDLE, CORNER = 6, 87  # the row of the mouth, and the column where it begins
LEG_ACROSS, LEG_ALONG = 5, 12
HIND, FRONT = 54, 74  # the belly's columns where legs begin
LENGTH = 4.6
JAWS = ((ALONG - 1) * ACROSS + MIDDLE, ACROSS * ALONG + ALONG - CORNER - 2)  # tips, above and below
GAPING, SNAPPING, CURLED = "Gaping", "Snapping", "Curled"


@dataclass(frozen=True)
class Posture:
    """reach:  how much the trunk is longer than at rest, as a fraction
    gape:   angle between the jaws in radians
    nod:    of the head, in radians
    turns:  of the tail's spiral
    stride: angle in radians by which the front leg swings forward
    """

    reach: float = 0.0
    gape: float = 0.0
    nod: float = 0.0
    turns: float = 1.1
    stride: float = 0.0


POSTURES = {
    BASIS: Posture(),
    GAPING: Posture(reach=0.45, gape=1.15, nod=-0.1, stride=0.2),
    SNAPPING: Posture(reach=0.9, nod=0.1, stride=0.4),
    CURLED: Posture(reach=-0.1, nod=0.75, turns=1.7, stride=-0.15),
}


def trunk(u: np.ndarray) -> np.ndarray:
    """One in the trunk's middle, zero in tail and head."""
    return smoothstep(0.48, 0.58, u) * smoothstep(0.86, 0.76, u)


def above(u: np.ndarray) -> np.ndarray:
    """From the spine to the back: tail, arched trunk, casque, upper jaw."""
    tail = 0.02 + 0.10 * smoothstep(0.0, 0.5, u)
    casque = 0.12 * smoothstep(0.76, 0.82, u) + 0.24 * bump(u - 0.83, 0.075)
    snout = np.sqrt(np.clip((1.004 - u) / 0.10, 0.0, 1.0))
    return (tail + 0.30 * bump(u - 0.64, 0.18) + casque) * snout


def below(u: np.ndarray) -> np.ndarray:
    """From the spine to the belly: tail, belly, throat, lower jaw."""
    tail = 0.02 + 0.08 * smoothstep(0.0, 0.5, u)
    throat = 0.10 * smoothstep(0.76, 0.84, u)
    snout = np.sqrt(np.clip((1.004 - u) / 0.10, 0.0, 1.0))
    return (tail + 0.26 * bump(u - 0.63, 0.17) + throat) * snout


def strip(posture: Posture, jaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Spine and vectors to its left, the snout turned by half the gape times `jaw`."""
    corner = CORNER / (ALONG - 1)

    def direction(u: np.ndarray) -> np.ndarray:
        spiral = 2 * np.pi * posture.turns * np.clip(1 - u / 0.5, 0.0, 1.0) ** 1.6
        opened = 0.5 * jaw * posture.gape * smoothstep(corner, corner + 0.07, u)
        return spiral - posture.nod * smoothstep(0.72, 0.84, u) + opened

    return spine(direction, lambda u: LENGTH * (1 + posture.reach * trunk(u)), ALONG)


def body(posture: Posture) -> np.ndarray:
    """#V by 2: the strip column by column, then the mouth's edge of the lower jaw."""
    u = np.linspace(0.0, 1.0, ALONG)
    thinner = 1 / np.sqrt(1 + posture.reach * trunk(u))
    (upper, up), (lower, left) = strip(posture, 1.0), strip(posture, -1.0)
    side = np.linspace(1.0, -1.0, ACROSS)[None, :, None]
    back = upper[:, None] + side * (above(u) * thinner)[:, None, None] * up[:, None]
    belly = lower[:, None] + side * (below(u) * thinner)[:, None, None] * left[:, None]
    flat = np.where(side >= 0, back, belly)
    return np.concatenate([flat.reshape(-1, 2), lower[CORNER + 1 :]])


def root(column: int) -> list[int]:
    """The belly's vertices that a leg grows from, the foremost first."""
    return [(column + i) * ACROSS + ACROSS - 1 for i in reversed(range(LEG_ACROSS))]


def leg(start: np.ndarray, length: float, swing: float, knee: float) -> np.ndarray:
    """What grows from `start` (#A by 2): #V by 2, row by row. Down, bent by `knee` half-way, and
    into a foot that points forward."""
    along = np.linspace(0.0, 1.0, LEG_ALONG)

    def direction(v: np.ndarray) -> np.ndarray:
        bend = -knee + 2 * knee * smoothstep(0.3, 0.5, v)
        return -0.5 * np.pi + swing + bend + (1.4 - knee) * smoothstep(0.74, 0.9, v)

    points, left = spine(direction, lambda v: np.full_like(v, length), LEG_ALONG)
    half = 0.10 - 0.045 * smoothstep(0.0, 0.5, along)
    side = np.linspace(1.0, -1.0, LEG_ACROSS)[None, :, None]
    grown = start.mean(axis=0) + points[:, None] + side * half[:, None, None] * left[:, None]
    share = smoothstep(0.0, 0.35, along)[:, None, None]
    return ((1 - share) * (start + points[:, None]) + share * grown)[1:].reshape(-1, 2)


def drawing(posture: Posture) -> np.ndarray:
    """#V by 3; the hind foot stands at the same place in all of them."""
    strip = body(posture)
    hind = leg(strip[root(HIND)], 0.85, -0.1, -0.35)
    front = leg(strip[root(FRONT)], 1.0, posture.stride, 0.35)
    flat = np.concatenate([strip, hind, front]) - hind[-1]
    return np.column_stack([flat, np.zeros(len(flat))])


def faces() -> list[tuple[int, ...]]:
    """Quads of body and legs."""
    size = ACROSS * ALONG
    edge = {j * ACROSS + MIDDLE: size + j - CORNER - 1 for j in range(CORNER + 1, ALONG)}
    quads = [
        tuple(edge.get(v, v) for v in quad) if max(v % ACROSS for v in quad) > MIDDLE else quad
        for quad in grid_quads(ACROSS, ALONG)
    ]
    first = size + len(edge)
    for column in (HIND, FRONT):
        grown = range(first, first + LEG_ACROSS * (LEG_ALONG - 1))
        number = [*root(column), *grown]
        quads += [tuple(number[v] for v in quad) for quad in grid_quads(LEG_ACROSS, LEG_ALONG)]
        first = grown.stop
    return quads


def painted() -> np.ndarray:
    """#V by 3, linear RGB: green, paler below, with bands and an eye."""
    count = len(drawing(Posture()))
    color = np.tile((0.16, 0.42, 0.10), (count, 1))
    u = np.repeat(np.linspace(0, 1, ALONG), ACROSS)
    side = np.tile(np.linspace(1, -1, ACROSS), ALONG)
    band = smoothstep(0.2, 0.7, np.sin(2 * np.pi * 17 * u)) * smoothstep(0.82, 0.78, u)
    eye = bump(np.hypot((u - 0.862) / 0.011, (side - 0.5) / 0.22), 1.5)
    strip = color[: len(u)]
    for mask, paint in (
        (0.8 * smoothstep(0.0, -1.0, side), (0.62, 0.66, 0.22)),
        (0.7 * band, (0.05, 0.22, 0.16)),
        (np.minimum(2 * eye, 1), (0.01, 0.01, 0.01)),
    ):
        strip += mask[:, None] * (np.array(paint) - strip)
    return color


def sample() -> Sample:
    """About 1,400 vertices in the XY plane, the head towards +X."""
    body_size = ACROSS * ALONG + ALONG - CORNER - 1
    foot = LEG_ACROSS * (LEG_ALONG - 1)
    return Sample(
        name="chameleon",
        faces=faces(),
        shapes={name: drawing(posture) for name, posture in POSTURES.items()},
        handles={
            "Tail": MIDDLE,
            "Hind Foot": body_size + foot - 1 - LEG_ACROSS // 2,
            "Front Foot": body_size + 2 * foot - 1 - LEG_ACROSS // 2,
            "Nape": 80 * ACROSS,
            "Snout": JAWS[0],
        },
        motion=[
            Waypoint(1, BASIS),
            Waypoint(13, GAPING),
            Waypoint(22, SNAPPING),
            Waypoint(30, BASIS),
            Waypoint(40, CURLED),
            Waypoint(48, BASIS),
        ],
        colors=painted(),
        view=(0, 90),
    )
