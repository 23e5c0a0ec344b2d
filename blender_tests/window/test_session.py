# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does in a sitting: bind, pull, change the mind, animate, bake, save, come back."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from scenes import NAME, add_creature, add_moving_creature, diagonal, key_of, pose_asked, shown
from window import Window

from addon import bake

SAME = 1e-5  # of the diagonal: poses that should be one
GRAB = 2  # undo steps: the click that selects, and the move


def test_bind_pull_and_change_the_mind(ui: Window) -> Iterator[None]:
    add_creature(bound=False)
    yield from ui.frame_all()
    ui.undo_base()
    rest = shown(NAME)
    yield from bind(ui)
    bound = shown(NAME)
    np.testing.assert_allclose(bound, rest, atol=SAME * diagonal(NAME))
    yield from ui.grab("Head", -60, 40)
    ui.tap("RET")
    yield
    first = shown(NAME)
    assert np.abs(first - rest).max() > 0.1
    np.testing.assert_array_equal(key_of(NAME), pose_asked(NAME))
    yield from ui.grab("Tail", 40, 50)
    ui.tap("LEFTMOUSE")
    yield
    second = shown(NAME)
    for _ in range(2):
        yield from ui.undo(GRAB)
        np.testing.assert_array_equal(shown(NAME), first)
        yield from ui.undo(GRAB)
        np.testing.assert_array_equal(shown(NAME), bound)
        yield from ui.redo(GRAB)
        np.testing.assert_array_equal(shown(NAME), first)
        yield from ui.redo(GRAB)
        np.testing.assert_array_equal(shown(NAME), second)
    yield from ui.grab("Front Paw.L", -50, 20)
    ui.tap("RIGHTMOUSE")
    yield
    np.testing.assert_array_equal(shown(NAME), second)
    steps = 1 + GRAB + GRAB + 1  # the bind, the grabs, the click on what was not grabbed
    yield from ui.undo(steps)
    assert not bpy.data.objects[NAME].tug.bound
    np.testing.assert_array_equal(shown(NAME), rest)
    yield from ui.redo(steps)
    np.testing.assert_array_equal(shown(NAME), second)


def test_frames_are_the_same_however_they_are_reached(ui: Window) -> Iterator[None]:
    add_moving_creature()
    yield from ui.frame_all()
    frames = [1, 4, 8]
    jumped = {}
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        jumped[frame] = shown(NAME)
    near = SAME * diagonal(NAME)

    bpy.context.scene.frame_set(frames[0])
    for frame in range(frames[0], frames[-1] + 1):
        assert bpy.context.scene.frame_current == frame
        if frame in jumped:
            np.testing.assert_allclose(shown(NAME), jumped[frame], atol=near)
        ui.tap("RIGHT_ARROW")
        yield
    ui.tap("LEFT_ARROW")
    yield
    for frame in range(frames[-1], frames[0], -1):
        assert bpy.context.scene.frame_current == frame
        if frame in jumped:
            np.testing.assert_allclose(shown(NAME), jumped[frame], atol=near)
        ui.tap("LEFT_ARROW")
        yield

    played = yield from play(ui)
    assert len(played) > 3
    for frame, pose in played.items():
        bpy.context.scene.frame_set(frame)
        np.testing.assert_allclose(pose, key_of(NAME), atol=near)


def test_a_bake_shows_what_was_posed(ui: Window) -> Iterator[None]:
    add_moving_creature()
    yield from ui.frame_all()
    poses = {}
    for frame in (1, 5, 8):
        bpy.context.scene.frame_set(frame)
        poses[frame] = shown(NAME)
    with tempfile.TemporaryDirectory() as folder:
        bake.bake(bpy.data.objects[NAME], 1, 8, Path(folder, "creature.pc2"))
        for frame, pose in poses.items():
            bpy.context.scene.frame_set(frame)
            yield
            np.testing.assert_allclose(shown(NAME), pose, atol=1e-6 * diagonal(NAME))


def test_a_file_that_is_saved_comes_back_as_it_was(ui: Window) -> Iterator[None]:
    add_creature()
    yield from ui.frame_all()
    yield from ui.grab("Head", -60, 40)
    ui.tap("RET")
    yield
    before = shown(NAME)
    yield from save_and_open()
    np.testing.assert_array_equal(shown(NAME), before)
    np.testing.assert_array_equal(key_of(NAME), pose_asked(NAME))
    yield from ui.grab("Head", 30, 0)
    ui.tap("RET")
    yield
    assert np.abs(shown(NAME) - before).max() > 0.05
    np.testing.assert_array_equal(key_of(NAME), pose_asked(NAME))


def test_what_was_not_keyed_is_gone_from_handles_and_mesh_alike(ui: Window) -> Iterator[None]:
    """A handle that was pulled but not keyed is back on its curve when the file is opened."""
    add_moving_creature()
    yield from ui.frame_all()
    keyed = shown(NAME)
    yield from ui.grab("Head", -60, 40)
    ui.tap("RET")
    yield
    assert np.abs(shown(NAME) - keyed).max() > 0.1
    yield from save_and_open()
    np.testing.assert_allclose(shown(NAME), keyed, atol=SAME * diagonal(NAME))
    np.testing.assert_array_equal(key_of(NAME), pose_asked(NAME))


def save_and_open() -> Iterator[float]:
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder, "creature.blend"))
        bpy.ops.wm.save_as_mainfile(filepath=file)
        yield 0.1
        bpy.ops.wm.open_mainfile(filepath=file)
        yield 0.3


def bind(ui: Window) -> Iterator[None]:
    with ui.context():
        bpy.ops.tug.bind("INVOKE_DEFAULT")
    yield from ui.wait_until(lambda: bpy.data.objects[NAME].tug.bound)


def play(ui: Window) -> Iterator[None]:
    """Play for a second. Result: the poses that were shown, by frame."""
    played = {}

    def record(scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph) -> None:
        played[scene.frame_current] = key_of(NAME)

    bpy.app.handlers.frame_change_post.append(record)
    try:
        ui.move(*ui.pixels_of((0, 0, 0)))
        ui.tap("SPACE")
        yield from ui.wait_until(lambda: len(played) > 8)
        ui.tap("SPACE")
        yield
    finally:
        bpy.app.handlers.frame_change_post.remove(record)
    return played
