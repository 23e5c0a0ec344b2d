# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact sheets: labelled poses of one mesh, side by side in a single PNG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import studio

TILE_WIDTH, TILE_HEIGHTS = 320, (120, 260)
LABEL = 0.11  # height of the label's strip, in tile widths
MARGIN = 0.94  # part of what is left that the largest pose fills
DEPTH = 3.0  # between one tile and the next, so that none stands in another's shadow
COLUMNS, BAKED_POSES = 4, 8


@dataclass(frozen=True)
class Tile:
    """A pose and what is written under it.

    positions: #V by 3, in the object's own space
    """

    label: str
    positions: np.ndarray


def contact_sheet(
    obj: bpy.types.Object,
    rows: Sequence[Sequence[Tile]],
    path: Path,
    view: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Renders `rows` of poses of the mesh of `obj` to the PNG at `path`.

    view: azimuth and elevation of the camera in degrees; azimuth 0 looks along +Y.

    All poses stand in one scene before an orthographic camera, so that one render makes the sheet.
    The scene is removed afterwards.
    """
    scene = bpy.data.scenes.new("Contact Sheet")
    before = _known()
    try:
        grid = _Grid.around(obj, rows, view)
        _fill(scene, obj, rows, grid)
        studio.add_lights(scene, grid.turn)
        width, height, depth = (
            grid.columns,
            grid.rows * grid.height,
            grid.columns * grid.rows * DEPTH,
        )
        studio.add_camera(scene, grid.turn, width, height, depth)
        studio.render(scene, path, round(TILE_WIDTH * width), round(TILE_WIDTH * height))
    finally:
        bpy.data.batch_remove([*(_known() - before), scene])


def baked_sheet(obj: bpy.types.Object, path: Path, view: tuple[float, float]) -> None:
    """A sheet of the shape keys of `obj` that show examples, and of poses spread over the scene's
    frames as its modifiers (the bake) leave them."""
    scene = bpy.context.scene
    keys = [key for key in obj.data.shape_keys.key_blocks if key.name != obj.tug.result]
    examples = [Tile(key.name, key_positions(key)) for key in keys]
    frames = np.linspace(scene.frame_start, scene.frame_end, BAKED_POSES + 2)[1:-1]
    baked = [Tile(f"frame {f}", evaluated_positions(obj, f)) for f in map(round, frames.tolist())]
    rows = [
        tiles[i : i + COLUMNS] for tiles in (examples, baked) for i in range(0, len(tiles), COLUMNS)
    ]
    contact_sheet(obj, rows, path, view)


def evaluated_positions(obj: bpy.types.Object, frame: int) -> np.ndarray:
    """#V by 3: the vertices of `obj` as its modifiers leave them at `frame`."""
    bpy.context.scene.frame_set(frame)
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def key_positions(key: bpy.types.ShapeKey) -> np.ndarray:
    """#V by 3: the vertices of a shape key."""
    flat = np.empty(3 * len(key.points), dtype=np.float32)
    key.points.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def _known() -> set[bpy.types.ID]:
    kinds = ("objects", "meshes", "curves", "lights", "cameras", "materials", "worlds")
    return {block for kind in kinds for block in getattr(bpy.data, kind)}


@dataclass(frozen=True)
class _Grid:
    """Where the tiles are. Lengths are in tile widths.

    turn:   the camera's rotation; its columns are right, up and back in the world
    middle: of all poses in the camera's right-up plane, in object units
    scale:  of object units
    height: of a tile
    """

    turn: Matrix
    middle: Vector
    scale: float
    height: float
    columns: int
    rows: int

    @staticmethod
    def around(
        obj: bpy.types.Object, rows: Sequence[Sequence[Tile]], view: tuple[float, float]
    ) -> _Grid:
        azimuth, elevation = (radians(degrees) for degrees in view)
        upright = Matrix.Rotation(pi / 2 - elevation, 3, "X")
        turn = Matrix.Rotation(azimuth, 3, "Z") @ upright
        right_up = np.array(turn.transposed() @ obj.matrix_world.to_3x3().normalized())[:2]
        seen = np.concatenate([tile.positions for row in rows for tile in row]) @ right_up.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        size = (high - low) / MARGIN
        lowest, highest = (pixels / TILE_WIDTH for pixels in TILE_HEIGHTS)
        scale = float(min(1 / size[0], (highest - LABEL) / size[1]))
        return _Grid(
            turn=turn,
            middle=Vector((*(low + high) / 2, 0)),
            scale=scale,
            height=max(lowest, scale * size[1] + LABEL),
            columns=max(len(row) for row in rows),
            rows=len(rows),
        )

    def pose_origin(self, column: int, row: int) -> Vector:
        """Where the object's origin goes."""
        inset = Vector((0, LABEL / 2, 0)) - self.scale * self.middle
        return self.turn @ (self._centre(column, row) + inset)

    def label_origin(self, column: int, row: int) -> Vector:
        """The middle of the label's base line, in front of the pose."""
        return self.turn @ (self._centre(column, row) + Vector((0, (LABEL - self.height) / 2, 1)))

    def _centre(self, column: int, row: int) -> Vector:
        depth = -DEPTH * (row * self.columns + column)
        return Vector((column + 0.5, -(row + 0.5) * self.height, depth))


def _fill(
    scene: bpy.types.Scene, obj: bpy.types.Object, rows: Sequence[Sequence[Tile]], grid: _Grid
) -> None:
    clean, ink = _unposed(obj), studio.ink()
    standing = obj.matrix_world.to_quaternion()
    size = Vector((grid.scale,) * 3)
    for row, tiles in enumerate(rows):
        for column, tile in enumerate(tiles):
            origin = grid.pose_origin(column, row)
            _add_pose(scene, clean, tile, Matrix.LocRotScale(origin, standing, size))
            facing = Matrix.LocRotScale(grid.label_origin(column, row), grid.turn, None)
            _add_label(scene, tile.label, ink, facing)


def _unposed(obj: bpy.types.Object) -> bpy.types.Mesh:
    """The mesh of `obj` without shape keys, smooth, in the sheet's own material."""
    clean = bpy.data.meshes.new_from_object(obj)
    clean.materials.clear()
    clean.materials.append(studio.clay(clean))
    clean.shade_smooth()
    return clean


def _add_pose(scene: bpy.types.Scene, clean: bpy.types.Mesh, tile: Tile, placed: Matrix) -> None:
    mesh = clean.copy()
    flat = np.ascontiguousarray(tile.positions, dtype=np.float32).ravel()
    mesh.attributes["position"].data.foreach_set("vector", flat)
    mesh.update()
    pose = bpy.data.objects.new(tile.label, mesh)
    pose.matrix_world = placed
    scene.collection.objects.link(pose)


def _add_label(scene: bpy.types.Scene, label: str, ink: bpy.types.Material, placed: Matrix) -> None:
    text = bpy.data.curves.new(label, "FONT")
    text.body, text.size, text.align_x = label, 0.062, "CENTER"
    text.materials.append(ink)
    written = bpy.data.objects.new(label, text)
    written.matrix_world = placed
    scene.collection.objects.link(written)
