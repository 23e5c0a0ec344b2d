# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones that pose a sculpture: forward kinematics, two-bone legs, smooth skinning. NumPy only.

World axes serve as every bone's axes at rest. Animals look along -Y with +X on their left, so that
a positive turn about X lowers the nose, about Y leans to the right, about Z looks to the left.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .sculpt import smoothed

Turn = tuple[float, float, float]


@dataclass(frozen=True)
class Bone:
    """A bone from `head` to `tail`; `parent` comes earlier in the skeleton, None at the root."""

    parent: str | None
    head: Sequence[float]
    tail: Sequence[float]


@dataclass(frozen=True)
class Leg:
    """Two bones that reach for a target, the joint between them pushed towards `pole`."""

    upper: str
    lower: str
    paw: str
    pole: Sequence[float]


@dataclass(frozen=True)
class Pose:
    """move:   added to the root bone's head
    turns:  bone -> degrees about X, Y, Z on top of the parent's turn
    facing: bone -> degrees about X, Y, Z in the world, whatever the parent does
    paws:   paw bone -> where the bone above ends, itself level; other legs swing with the parent
    length: bone -> factor along the bone; its girth shrinks so that the volume stays
    """

    move: Sequence[float] = (0.0, 0.0, 0.0)
    turns: Mapping[str, Turn] = field(default_factory=dict)
    facing: Mapping[str, Turn] = field(default_factory=dict)
    paws: Mapping[str, Sequence[float]] = field(default_factory=dict)
    length: Mapping[str, float] = field(default_factory=dict)


def rotation(turn: Turn) -> np.ndarray:
    """3 by 3: first about Y, then X, then Z, in degrees."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_x @ about_y


def rotation_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation that takes the direction of `a` to that of `b` (not opposite)."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    v = np.cross(a, b)
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + a @ b)


class Skeleton:
    """Bones by name, parents first, and the legs among them."""

    def __init__(self, bones: Mapping[str, Bone], legs: Sequence[Leg]) -> None:
        self.bones = bones
        self.legs = {leg.upper: leg for leg in legs}

    def place(self, pose: Pose) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Bone -> (A, t): a rest point x of that bone goes to A x + t."""
        turned: dict[str, np.ndarray] = {}
        shaped: dict[str, np.ndarray] = {}
        heads: dict[str, np.ndarray] = {}
        for name, bone in self.bones.items():
            head = np.asarray(bone.head, dtype=float)
            if bone.parent is None:
                turned[name], heads[name] = np.eye(3), head + pose.move
            else:
                offset = head - np.asarray(self.bones[bone.parent].head)
                heads[name] = heads[bone.parent] + shaped[bone.parent] @ offset
                turned.setdefault(name, turned[bone.parent])
            turned[name] = turned[name] @ rotation(pose.turns.get(name, (0, 0, 0)))
            if name in pose.facing:
                turned[name] = rotation(pose.facing[name])
            leg = self.legs.get(name)
            if leg and leg.paw in pose.paws:
                self._reach(leg, np.asarray(pose.paws[leg.paw], dtype=float), heads, turned)
            shaped[name] = turned[name] @ self._stretch(name, pose.length.get(name, 1.0))
        return {
            name: (shaped[name], heads[name] - shaped[name] @ np.asarray(bone.head))
            for name, bone in self.bones.items()
        }

    def _reach(
        self,
        leg: Leg,
        target: np.ndarray,
        heads: dict[str, np.ndarray],
        turned: dict[str, np.ndarray],
    ) -> None:
        """Turns a leg so that its lower bone ends at the target if within reach, the paw level."""
        upper, lower = self._along(leg.upper), self._along(leg.lower)
        a, b = np.linalg.norm(upper), np.linalg.norm(lower)
        start, parent = heads[leg.upper], turned[leg.upper]
        reach = target - start
        span = np.clip(np.linalg.norm(reach), abs(a - b) + 1e-3, 0.999 * (a + b))
        reach /= np.linalg.norm(reach)
        pole = parent @ np.asarray(leg.pole, dtype=float)
        pole -= reach * (reach @ pole)
        cosine = (a * a + span * span - b * b) / (2 * a * span)
        knee = a * (cosine * reach + np.sqrt(1 - cosine**2) * pole / np.linalg.norm(pole))
        turned[leg.upper] = rotation_between(parent @ upper, knee) @ parent
        shin = span * reach - knee
        turned[leg.lower] = rotation_between(turned[leg.upper] @ lower, shin) @ turned[leg.upper]
        turned[leg.paw] = np.eye(3)

    def _along(self, name: str) -> np.ndarray:
        bone = self.bones[name]
        return np.asarray(bone.tail, dtype=float) - np.asarray(bone.head, dtype=float)

    def _stretch(self, name: str, factor: float) -> np.ndarray:
        along = self._along(name)
        axis = np.outer(along, along) / (along @ along)
        return factor * axis + (np.eye(3) - axis) / np.sqrt(factor)


class Skin:
    """Vertices that follow a skeleton.

    weights: #V by #B, bones in the skeleton's order, rows of sum one
    """

    def __init__(
        self, skeleton: Skeleton, rest: np.ndarray, edges: np.ndarray, weights: np.ndarray
    ) -> None:
        self.skeleton, self.rest, self.edges, self.weights = skeleton, rest, edges, weights
        self.detail = rest - smoothed(rest, edges, self.ROUNDS)

    ROUNDS = 10

    def posed(self, pose: Pose) -> np.ndarray:
        """#V by 3. Skinning alone pinches the joints: the skinned mesh is smoothed, and the detail
        that smoothing takes from the rest pose is put back, turned with the bones."""
        placed = self.skeleton.place(pose)
        turns = np.einsum("vb,bij->vij", self.weights, np.array([a for a, _ in placed.values()]))
        shift = self.weights @ np.array([t for _, t in placed.values()])
        skinned = np.einsum("vij,vj->vi", turns, self.rest) + shift
        u, _, vt = np.linalg.svd(turns)
        base = smoothed(skinned, self.edges, self.ROUNDS)
        return base + np.einsum("vij,vj->vi", u @ vt, self.detail)
