# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses between two poses, by way of their rotations (F, section 5, "Shape interpolation").

Each rotation goes the shortest way from what it is in one pose to what it is in the other, the
blends go straight, and one global step finds the transforms: limbs turn, where straight lines would
shorten them. The turn that the whole mesh makes is taken apart, so that parts which turn by about
half a circle do not go different ways round.
"""

from __future__ import annotations

import numpy as np

from .smoothing import Solution, closest_rotations


def interpolate(
    start: Solution, end: Solution, share: float, targets: np.ndarray | None = None
) -> Solution:
    """What lies between two solutions of one model: start where share is 0, end where it is 1.

    targets: #H by k, of the rows at this share; where they are None, rows go straight in a frame
    that turns with the mesh. Solver.pose gives the positions.
    """
    _check(start, end, share)
    turns = end.rotations @ np.swapaxes(start.rotations, -1, -2)
    common = closest_rotations(turns.mean(axis=(0, 1)))
    so_far = power(common, share)
    if targets is None:
        targets = _path(start.targets, end.targets, common, so_far, share)
    return Solution(
        targets=targets,
        blend=(1 - share) * start.blend + share * end.blend,
        rotations=so_far @ power(common.T @ turns, share) @ start.rotations,
    )


def power(rotations: np.ndarray, exponent: float) -> np.ndarray:
    """Rotations (... by k by k) about the same axes by `exponent` times their angles, which are
    taken from minus to plus half a circle."""
    if rotations.shape[-1] == 2:
        angle = exponent * np.arctan2(rotations[..., 1, 0], rotations[..., 0, 0])
        cos, sin = np.cos(angle), np.sin(angle)
        return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
    axis, angle = _axes_and_angles(rotations)
    cross = np.cross(np.eye(3), axis[..., None, :])  # cross @ v is axis x v
    sin, cos = (f(exponent * angle)[..., None, None] for f in (np.sin, np.cos))
    return np.eye(3) + sin * cross + (1 - cos) * cross @ cross


def _axes_and_angles(rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of rotations in space, by their quaternions: the eigenvectors of the largest eigenvalues of a
    symmetric matrix (Bar-Itzhack 2000), which are exact at half turns too."""
    trace = np.trace(rotations, axis1=-2, axis2=-1)[..., None, None]
    transposed = np.swapaxes(rotations, -1, -2)
    matrix = np.empty((*rotations.shape[:-2], 4, 4))
    matrix[..., 1:, 1:] = rotations + transposed - trace * np.eye(3)
    matrix[..., 0, 0] = trace[..., 0, 0]
    skew = rotations - transposed
    axial = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
    matrix[..., 0, 1:] = matrix[..., 1:, 0] = axial
    quaternion = np.linalg.eigh(matrix)[1][..., -1]
    quaternion *= np.where(quaternion[..., :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1)
    axis = quaternion[..., 1:] / np.maximum(sine, np.finfo(float).tiny)[..., None]
    return axis, 2 * np.arctan2(sine, quaternion[..., 0])


def _path(
    start: np.ndarray, end: np.ndarray, common: np.ndarray, so_far: np.ndarray, share: float
) -> np.ndarray:
    """Straight from start to what end is before the common turn, then turned as far as that has
    come; all about the middles, which go straight."""
    middles = start.mean(axis=0), end.mean(axis=0)
    straight = (1 - share) * (start - middles[0]) + share * (end - middles[1]) @ common
    return (1 - share) * middles[0] + share * middles[1] + straight @ so_far.T


def _check(start: Solution, end: Solution, share: float) -> None:
    if not 0 <= share <= 1:
        raise ValueError(f"the share is {share:g}: it must be from 0 to 1")
    for name in "targets", "blend", "rotations":
        shapes = getattr(start, name).shape, getattr(end, name).shape
        if shapes[0] != shapes[1]:
            raise ValueError(
                f"the solutions have {name} of {shapes[0]} and {shapes[1]}: "
                "both must be of one model"
            )
