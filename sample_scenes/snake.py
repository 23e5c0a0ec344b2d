# SPDX-License-Identifier: GPL-3.0-or-later
"""A flat snake in five drawings. A drawing is a spine, given by its direction along the body, and
a half width along it; the body is the grid of points to the left and right of the spine."""

from __future__ import annotations

import numpy as np

from .sample import BASIS, Sample, Waypoint, grid_quads
from .sculpt import bump, smoothstep
from .spine import Along, spine

ACROSS, ALONG = 9, 91
LENGTH = 4.0


def half_width(u: np.ndarray) -> np.ndarray:
    """At rest, from the tail's tip (u = 0) over the neck to the snout (u = 1)."""
    body = 0.03 + 0.15 * smoothstep(0.0, 0.55, u)
    neck = 1.0 - 0.38 * bump(u - 0.87, 0.13)
    head = 0.05 * bump(u - 0.945, 0.07)
    snout = np.sqrt(np.clip((1.004 - u) / 0.05, 0.0, 1.0))
    return (body * neck + head) * snout


def drawing(direction: Along, width: Along, length: float = LENGTH) -> np.ndarray:
    """#V by 3, centred on the origin, row by row from tail to head.

    direction: u in 0..1 -> angle of the spine in radians
    """
    points, left = spine(direction, lambda u: np.full_like(u, length), ALONG)
    half = width(np.linspace(0.0, 1.0, ALONG))
    side = np.linspace(1.0, -1.0, ACROSS)
    flat = points[:, None] + (half[:, None] * side)[..., None] * left[:, None]
    flat = flat.reshape(-1, 2)
    flat -= flat.mean(axis=0)
    return np.column_stack([flat, np.zeros(len(flat))])


def coil(u: np.ndarray) -> np.ndarray:
    """Direction along a spiral of constant pitch with the tail inside; the neck straightens."""
    inner, pitch = 0.16, 0.42 / (2 * np.pi)
    s = LENGTH * np.minimum(u, 0.82)
    turn = (np.sqrt(inner**2 + 2 * pitch * s) - inner) / pitch
    return turn - turn.max() - 1.9 * smoothstep(0.76, 0.93, u) + 1.1


def drawings() -> dict[str, np.ndarray]:
    """The example shapes."""

    def wave(height: float, waves: float) -> Along:
        return lambda u: height * np.cos(2 * np.pi * waves * u)

    def scared(u: np.ndarray) -> np.ndarray:
        return half_width(u) * (1.25 + 0.9 * bump(u - 0.45, 0.45))

    return {
        BASIS: drawing(np.zeros_like, half_width),
        "S-Bent": drawing(wave(1.15, 1.5), half_width),
        "Coiled": drawing(coil, half_width),
        "Scared": drawing(wave(0.18, 1.5), scared, 0.55 * LENGTH),
        "Stretched": drawing(wave(-0.12, 1.0), lambda u: 0.62 * half_width(u), 1.5 * LENGTH),
    }


def painted() -> np.ndarray:
    """#V by 3, linear RGB: green with bands, dark eyes."""
    u, side = np.meshgrid(np.linspace(0, 1, ALONG), np.linspace(1, -1, ACROSS), indexing="ij")
    band = smoothstep(0.1, 0.5, np.sin(2 * np.pi * 15 * u - 1.2 * np.abs(side)))
    band *= smoothstep(0.9, 0.86, u)
    eye = bump(np.hypot((u - 0.95) / 0.0075, (np.abs(side) - 0.5) / 0.2), 1.6)
    color = np.tile((0.20, 0.46, 0.07), (*u.shape, 1))
    color += band[..., None] * (np.array((0.70, 0.62, 0.12)) - color)
    color += np.minimum(2 * eye, 1)[..., None] * (np.array((0.01, 0.01, 0.01)) - color)
    return color.reshape(-1, 3)


def sample() -> Sample:
    """819 vertices in the XY plane, the head towards +X."""

    def on_spine(u: float) -> int:
        return round(u * (ALONG - 1)) * ACROSS + ACROSS // 2

    return Sample(
        name="snake",
        faces=grid_quads(ACROSS, ALONG),
        shapes=drawings(),
        handles={
            "Tail": on_spine(0.0),
            "Back": on_spine(0.3),
            "Middle": on_spine(0.6),
            "Neck": on_spine(0.86),
            "Head": on_spine(1.0),
        },
        motion=[
            Waypoint(1, BASIS),
            Waypoint(9, "S-Bent"),
            Waypoint(13, "S-Bent", {"Head": (0.1, 0.35, 0), "Neck": (0, 0.2, 0)}),
            Waypoint(22, "Coiled"),
            Waypoint(27, "Coiled", {"Head": (0.3, 0.3, 0), "Neck": (0.15, 0.15, 0)}),
            Waypoint(33, "Scared"),
            Waypoint(36, "Scared", {"Head": (-0.1, 0, 0), "Tail": (0.1, 0, 0)}),
            Waypoint(42, "Stretched"),
            Waypoint(48, BASIS),
        ],
        colors=painted(),
        view=(0, 90),
    )
