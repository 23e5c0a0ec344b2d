# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits and bakes that run beside the window: to their end, and stopped by Esc."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from scenes import NAME, add_creature, add_moving_creature, diagonal, key_of, shown
from window import Window

from addon.caches import mesh_cache
from addon.rigging import shape_keys
from addon.ui import work


def add_scan(name: str) -> bpy.types.Object:
    """One of the creature's shape keys as a mesh of its own, with empties where the handles are."""
    creature = bpy.data.objects[NAME]
    mesh = creature.data
    positions = shape_keys.coordinates(mesh.shape_keys.key_blocks[name])
    copy = bpy.data.meshes.new("Scan")
    copy.from_pydata(positions.tolist(), [], [list(face.vertices) for face in mesh.polygons])
    scan = bpy.data.objects.new("Scan", copy)
    bpy.context.scene.collection.objects.link(scan)
    for handle in creature.tug.handles:
        empty = bpy.data.objects.new(handle.name, None)
        bpy.context.scene.collection.objects.link(empty)
        empty.parent, empty.location = scan, positions[handle.vertex].tolist()
    creature.tug.fit_target = scan
    bpy.context.view_layer.objects.active = creature
    return scan


def example() -> str:
    return bpy.data.objects[NAME].data.shape_keys.key_blocks[1].name


def positions_of(name: str) -> np.ndarray:
    return shape_keys.coordinates(bpy.data.objects[NAME].data.shape_keys.key_blocks[name])


def start(ui: Window, operator: str) -> None:
    with ui.context():
        getattr(bpy.ops.tug, operator)("INVOKE_DEFAULT")


def at_work() -> bool:
    return work.running(bpy.data.objects[NAME]) is not None


def test_a_fit_runs_beside_the_window(ui: Window) -> Iterator[None]:
    add_creature()
    add_scan(example())
    yield from ui.frame_all()
    ui.undo_base()
    before = key_of(NAME)
    start(ui, "fit")
    assert at_work()
    yield from ui.wait_until(lambda: not at_work())
    yield
    distance = np.linalg.norm(key_of(NAME) - positions_of(example()), axis=1)
    assert distance.mean() < 0.01 * diagonal(NAME)
    fitted = shown(NAME)
    ui.picture("fit")
    yield from ui.undo()
    np.testing.assert_array_equal(key_of(NAME), before)
    yield from ui.redo()
    np.testing.assert_array_equal(shown(NAME), fitted)


def test_esc_stops_a_fit(ui: Window) -> Iterator[None]:
    add_creature()
    add_scan(example())
    yield from ui.frame_all()
    before = key_of(NAME)
    start(ui, "fit")
    ui.tap("ESC")
    yield from ui.wait_until(lambda: not at_work())
    yield
    np.testing.assert_array_equal(key_of(NAME), before)


def choose_file(path: Path) -> bool:
    """Confirm the file browser, once it is there."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "FILE_BROWSER" and area.spaces.active.params is not None:
                area.spaces.active.params.directory = str(path.parent).encode()
                area.spaces.active.params.filename = path.name
                region = next(region for region in area.regions if region.type == "WINDOW")
                with bpy.context.temp_override(window=window, area=area, region=region):
                    bpy.ops.file.execute()
                return True
    return False


def is_baked() -> bool:
    return mesh_cache.NAME in bpy.data.objects[NAME].modifiers


def test_frames_are_written_one_after_the_other(ui: Window) -> Iterator[None]:
    add_moving_creature()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 4
    scene.frame_set(3)
    bpy.context.view_layer.objects.active = bpy.data.objects[NAME]
    yield from ui.frame_all()
    ui.undo_base()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bake.pc2"
        start(ui, "bake")
        yield from ui.wait_until(lambda: choose_file(path))
        yield from ui.wait_until(is_baked)
        yield
        assert path.exists()
        assert scene.frame_current == 3
        yield from ui.undo()
        assert not is_baked()


def test_esc_stops_the_writing(ui: Window) -> Iterator[None]:
    add_moving_creature()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 5000
    scene.frame_set(3)
    bpy.context.view_layer.objects.active = bpy.data.objects[NAME]
    yield from ui.frame_all()
    with tempfile.TemporaryDirectory() as folder:
        start(ui, "bake")
        yield from ui.wait_until(lambda: choose_file(Path(folder) / "bake.pc2"))
        yield from ui.wait_until(lambda: scene.frame_current > 5)
        ui.tap("ESC")
        yield
        yield
        assert scene.frame_current == 3
        assert not is_baked()
        assert not list(Path(folder).iterdir())
