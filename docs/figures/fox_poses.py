# SPDX-License-Identifier: GPL-3.0-or-later
"""More poses of the sample fox than its scene has: mixtures of what its bones do in two of them,
with head and tail turned anew. The skeleton poses them, so that they are no blends of shapes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from project import creature

from sample_scenes.creature_body import skeleton
from sample_scenes.skeleton import Pose, Skeleton

FREE = {"neck": 14, "head": 18, "tail 1": 14, "tail 3": 18, "tail 5": 18}  # degrees either way


def mixtures(count: int, random: np.random.Generator) -> dict[str, Pose]:
    """So many poses, each of a pair of named ones that may come again with other shares."""
    bones, poses = skeleton(), [Pose(), *creature.POSES.values()]
    made = {}
    for number in range(count):
        one, other = random.choice(len(poses), 2, replace=False)
        made[f"mixture {number}"] = mixture(
            bones, poses[one], poses[other], random.uniform(0.3, 0.7), random
        )
    return made


def mixture(
    bones: Skeleton, one: Pose, other: Pose, share: float, random: np.random.Generator
) -> Pose:
    """What a pose does not say of a bone is what it does at rest."""
    rest = {leg.paw: bones.bones[leg.paw].head for leg in bones.legs.values()}
    turns = mixed(one.turns, other.turns, share)
    for bone, most in FREE.items():
        free = random.uniform(-most, most, 3) * (1, 0.5, 1)
        turns[bone] = tuple(np.add(turns.get(bone, (0, 0, 0)), free))
    lengths = set(one.length) | set(other.length)
    return Pose(
        move=(1 - share) * np.array(one.move) + share * np.array(other.move),
        turns=turns,
        facing=mixed(one.facing, other.facing, share),
        paws=mixed(rest | dict(one.paws), rest | dict(other.paws), share),
        length={
            bone: (1 - share) * one.length.get(bone, 1) + share * other.length.get(bone, 1)
            for bone in sorted(lengths)
        },
    )


def mixed(
    one: Mapping[str, Sequence[float]], other: Mapping[str, Sequence[float]], share: float
) -> dict[str, tuple]:
    """By name, zeros where one of the two has nothing."""
    names: Iterable[str] = dict.fromkeys([*one, *other])
    none = np.zeros(3)
    return {
        name: tuple(
            (1 - share) * np.array(one.get(name, none)) + share * np.array(other.get(name, none))
        )
        for name in names
    }
