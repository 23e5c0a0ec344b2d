# SPDX-License-Identifier: GPL-3.0-or-later
"""Blends and rotations averaged over time.

Each frame is solved on its own, so an average over the frames around one is a function of their
handles alone: a piece of a range, which solves the frames around it too, agrees with the whole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Solution:
    """What a solve found for targets (#H by k): blend, #G by #S; rotations, #G by #S by k by k.
    firmness: #H, how firmly the targets were held, where that changes from solve to solve. scale:
    by how much the shapes are larger in the pose than given."""

    targets: np.ndarray
    blend: np.ndarray
    rotations: np.ndarray
    firmness: np.ndarray | None = None
    scale: float = 1.0


def reach(smoothing: float) -> int:
    """How many frames on either side count: to three standard deviations of `smoothing` frames."""
    return math.ceil(3 * smoothing)


def average(window: Sequence[Solution], smoothing: float) -> Solution:
    """The Gaussian average of the 2 reach(smoothing) + 1 solutions around the middle one, for whose
    targets, held as firmly, it is. Rotations: those closest to the average."""
    middle = window[reach(smoothing)]
    distance = np.arange(len(window)) - reach(smoothing)
    weights = np.exp(-0.5 * (distance / smoothing) ** 2)
    weights /= weights.sum()
    blend = sum(w * one.blend for w, one in zip(weights, window, strict=True))
    rotations = sum(w * one.rotations for w, one in zip(weights, window, strict=True))
    blend /= blend.sum(axis=1, keepdims=True)
    scale = sum(w * one.scale for w, one in zip(weights, window, strict=True))
    return Solution(middle.targets, blend, closest_rotations(rotations), middle.firmness, scale)


def closest_rotations(matrices: np.ndarray) -> np.ndarray:
    """Rotations (... by k by k) closest to matrices in the sum of squares."""
    left, _, right = np.linalg.svd(matrices)
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[..., None]
    return left @ right
