# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of meshes in space: an orthographic z-buffer with smooth normals. NumPy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SAMPLES = 2  # along a side of a pixel
# Direction (right, up, towards the eye) and strength of each light, and of what comes from all
# around, more of it from above.
LIGHTS = (((-0.55, 0.65, 0.60), 0.85), ((0.9, 0.1, 0.4), 0.18))
SKY, GROUND = 0.42, 0.20


@dataclass(frozen=True)
class Camera:
    """Looks from `azimuth` and `elevation` in degrees; azimuth 0 looks along +Y."""

    azimuth: float
    elevation: float

    def axes(self) -> np.ndarray:
        """3 by 3, rows: right, up, towards the eye."""
        a, e = np.radians((self.azimuth, self.elevation))
        right = np.array((np.cos(a), np.sin(a), 0))
        back = np.array((np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)))
        return np.stack([right, np.cross(back, right), back])

    def project(self, points: np.ndarray) -> np.ndarray:
        """#P by 3 in the world -> #P by 3: right, up, towards the eye."""
        return points @ self.axes().T


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """#V by 3 unit normals, weighted by area."""
    a, b, c = (vertices[corner] for corner in triangles.T)
    across = np.cross(b - a, c - a)
    columns = [
        np.bincount(triangles.ravel(), np.repeat(column, 3), len(vertices)) for column in across.T
    ]
    normals = np.stack(columns, axis=1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def render(
    seen: np.ndarray,
    triangles: np.ndarray,
    colors: np.ndarray,
    window: tuple[float, float, float, float],
    resolution: float,
) -> np.ndarray:
    """#rows by #columns by 4 sRGB and opacity in 0..1, the top row first.

    seen: #V by 3 as from Camera.project; colors: #V by 3 linear RGB
    window: left, right, bottom, top; resolution: pixels per unit
    """
    left, right, bottom, top = window
    scale = SAMPLES * resolution
    width, height = (SAMPLES * round(resolution * side) for side in (right - left, top - bottom))
    points = np.stack([(seen[:, 0] - left) * scale, (top - seen[:, 1]) * scale, seen[:, 2]], axis=1)
    pixel, triangle, share = _visible(points, triangles, width, height)
    corners = triangles[triangle]
    normals = np.einsum("pc,pci->pi", share, vertex_normals(seen, triangles)[corners])
    paint = np.einsum("pc,pci->pi", share, colors[corners])
    picture = np.zeros((height * width, 4))
    picture[pixel, :3] = paint * _light(normals)[:, None]
    picture[pixel, 3] = 1.0
    fine = picture.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, 4)
    return _finish(fine.mean(axis=(1, 3)))


def _light(normals: np.ndarray) -> np.ndarray:
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    light = GROUND + (SKY - GROUND) * (0.5 + 0.5 * normals[:, 1])
    for direction, strength in LIGHTS:
        towards = np.array(direction) / np.linalg.norm(direction)
        light = light + strength * np.maximum(normals @ towards, 0.0)
    return light


def _finish(mean: np.ndarray) -> np.ndarray:
    """From linear RGB times opacity to sRGB and opacity."""
    opacity = mean[..., 3:]
    color = np.clip(mean[..., :3] / np.maximum(opacity, 1e-9), 0.0, 1.0)
    curve = np.where(color < 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055)
    return np.concatenate([curve, opacity], axis=2)


def _visible(
    points: np.ndarray, triangles: np.ndarray, width: int, height: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each pixel that something covers: its number, the nearest triangle, and the shares of
    that triangle's corners."""
    pixels, owners, shares, depths = [], [], [], []
    corners = points[triangles]
    first = np.floor(corners[:, :, :2].min(axis=1)).astype(int)
    sizes = np.ceil(corners[:, :, :2].max(axis=1)).astype(int) - first
    for dx, dy in np.ndindex(*sizes.max(axis=0)):
        owner = np.flatnonzero((sizes[:, 0] > dx) & (sizes[:, 1] > dy))
        x, y = first[owner, 0] + dx, first[owner, 1] + dy
        share = _barycentric(corners[owner, :, :2], x + 0.5, y + 0.5)
        hit = (share.min(axis=1) >= 0) & (x >= 0) & (x < width) & (y >= 0) & (y < height)
        pixels.append(y[hit] * width + x[hit])
        owners.append(owner[hit])
        shares.append(share[hit])
        depths.append(np.einsum("pc,pc->p", share[hit], corners[owner[hit], :, 2]))
    pixel, owner, share, depth = map(np.concatenate, (pixels, owners, shares, depths))
    order = np.lexsort((depth, pixel))
    nearest = order[np.flatnonzero(np.diff(pixel[order], append=-1))]
    return pixel[nearest], owner[nearest], share[nearest]


def _barycentric(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """#P by 3, all of them in 0..1 inside; -1 for a triangle seen edge-on."""
    to = corners - np.stack([x, y], axis=1)[:, None]
    parts = [
        to[:, i, 0] * to[:, j, 1] - to[:, i, 1] * to[:, j, 0] for i, j in ((1, 2), (2, 0), (0, 1))
    ]
    area = sum(parts)
    flat = np.abs(area) < 1e-12
    return np.where(flat, -1.0, np.stack(parts) / np.where(flat, 1.0, area)).T
