# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh follows its handles in a window, whatever moves them, and comes back exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
import numpy as np
from mathutils import Vector
from scenes import add_creature, key_of, shown
from window import Window

from addon.rigging import rig

BODY, HANDLE, OTHER = "Creature", "Tail", "Head"
FRAMES = 12


def start(ui: Window) -> Iterator[None]:
    add_creature()
    yield from ui.frame_all()
    ui.undo_base()


def state() -> tuple[bytes, bytes]:
    """The result key, and the mesh as it is shown."""
    return key_of(BODY).tobytes(), shown(BODY).tobytes()


def answer() -> np.ndarray:
    """What the solver says for the handles as they are."""
    positions = rig.positions(bpy.data.objects[BODY], bpy.context.evaluated_depsgraph_get())
    return positions.astype(np.float32)


def assert_followed() -> None:
    np.testing.assert_array_equal(key_of(BODY), answer())


def diagonal() -> float:
    return float(np.linalg.norm(np.ptp(shown(BODY), axis=0)))


def click(ui: Window, name: str, shift: bool = False) -> Iterator[None]:
    ui.point_at(bpy.data.objects[name])
    yield
    ui.tap("LEFTMOUSE", shift=shift)
    yield


def grab(ui: Window, name: str, dx: float, dy: float) -> Iterator[None]:
    """G on what is selected, from the object on. (A click first would be a step of undo.)"""
    ui.point_at(bpy.data.objects[name])
    yield
    ui.tap("G")
    yield
    yield from ui.travel(dx, dy)


def assert_undone_and_redone(ui: Window, states: list[tuple[bytes, bytes]]) -> Iterator[None]:
    """Back through all states and forth again."""
    for before in reversed(states[:-1]):
        yield from ui.undo()
        assert state() == before
    for after in states[1:]:
        yield from ui.redo()
        assert state() == after


def test_grabs_are_followed_undone_and_redone(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    states = [state()]
    for dx, dy in ((60, 40), (-30, 20)):
        yield from grab(ui, HANDLE, dx, dy)
        before = key_of(BODY)
        ui.move(ui.pointer[0] + 5, ui.pointer[1])
        yield
        assert not np.array_equal(key_of(BODY), before)  # while it moves
        ui.tap("RET")
        yield
        assert_followed()
        states.append(state())
    yield from assert_undone_and_redone(ui, states)


def test_escape_from_a_grab_restores_the_mesh(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    for button in ("ESC", "RIGHTMOUSE"):
        before = state()
        yield from grab(ui, HANDLE, 60, 40)
        assert state() != before
        ui.tap(button)
        yield
        assert state() == before


def test_rotating_and_scaling_handles_together_is_followed(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    yield from click(ui, OTHER, shift=True)
    states = [state()]
    for letter in "RS":
        ui.tap(letter)
        yield
        yield from ui.travel(0, -60)
        ui.tap("RET")
        yield
        assert state() != states[-1]
        assert_followed()
        states.append(state())
    yield from assert_undone_and_redone(ui, states)


def add_empty(name: str, place: Vector) -> bpy.types.Object:
    empty = bpy.data.objects.new(name, None)
    empty.location = place
    bpy.context.scene.collection.objects.link(empty)
    return empty


def by_parent(empty: bpy.types.Object) -> None:
    parent = add_empty("Lever", empty.location + Vector((0.3, 0.3, 0.3)))
    bpy.context.view_layer.update()
    empty.parent = parent
    empty.matrix_parent_inverse = parent.matrix_world.inverted()


def by_constraint(empty: bpy.types.Object) -> None:
    goal = add_empty("Lever", empty.location + Vector((0.3, 0.3, 0.3)))
    constraint = empty.constraints.new("COPY_LOCATION")
    constraint.target, constraint.use_offset = goal, False


def by_driver(empty: bpy.types.Object) -> None:
    source = add_empty("Lever", empty.location + Vector((0.3, 0.3, 0.3)))
    for axis, name in enumerate(("LOC_X", "LOC_Y", "LOC_Z")):
        driver = empty.driver_add("location", axis).driver
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        variable.targets[0].id, variable.targets[0].transform_type = source, name
        driver.expression = variable.name


def by_bone(empty: bpy.types.Object) -> None:
    armature = bpy.data.objects.new("Lever", bpy.data.armatures.new("Lever"))
    armature.location = empty.location + Vector((0.3, 0.3, 0.3))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 0.3)
    bpy.ops.object.mode_set(mode="OBJECT")
    constraint = empty.constraints.new("CHILD_OF")
    constraint.target, constraint.subtarget = armature, "Bone"
    bpy.context.view_layer.update()
    bone_in_world = armature.matrix_world @ armature.pose.bones["Bone"].matrix
    constraint.inverse_matrix = bone_in_world.inverted()


def indirectly(hang: Callable[[bpy.types.Object], None]) -> Callable[[Window], Iterator[None]]:
    """A test that grabs what the handle hangs on."""

    def test(ui: Window) -> Iterator[None]:
        yield from start(ui)
        hang(bpy.data.objects[HANDLE])
        yield
        bpy.ops.object.select_all(action="DESELECT")  # the handle may lie on its lever
        bpy.context.view_layer.objects.active = bpy.data.objects["Lever"]
        bpy.data.objects["Lever"].select_set(True)
        ui.undo_base()
        yield
        states = [state()]
        yield from grab(ui, "Lever", 40, 30)
        ui.tap("RET")
        yield
        assert state() != states[0]
        assert_followed()
        states.append(state())
        yield from grab(ui, "Lever", 40, 30)
        ui.tap("ESC")
        yield
        assert state() == states[-1]
        yield from assert_undone_and_redone(ui, states)

    return test


test_a_parent_is_followed = indirectly(by_parent)
test_a_constraint_is_followed = indirectly(by_constraint)
test_a_driver_is_followed = indirectly(by_driver)
test_a_bone_is_followed = indirectly(by_bone)


def test_a_posed_bone_is_followed(ui: Window) -> Iterator[None]:
    yield from start(ui)
    by_bone(bpy.data.objects[HANDLE])
    armature = bpy.data.objects["Lever"]
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="POSE")
    with ui.context():
        bpy.ops.pose.select_all(action="SELECT")
    ui.undo_base()
    yield
    states = [state()]
    ui.move(*ui.pixels_of(armature.location))
    yield
    ui.tap("R")
    yield
    yield from ui.travel(50, 60)
    ui.tap("RET")
    yield
    assert state() != states[0]
    assert_followed()
    states.append(state())
    yield from assert_undone_and_redone(ui, states)


def animate() -> None:
    """The tail swings over and back, with a turn of the head."""
    for name, offset in ((HANDLE, Vector((0.0, 0.4, 0.3))), (OTHER, Vector((0.2, 0.0, -0.2)))):
        empty = bpy.data.objects[name]
        rest = empty.location.copy()
        for frame, share in ((1, 0.0), (FRAMES // 2, 1.0), (FRAMES, -0.5)):
            empty.location = rest + share * offset
            empty.keyframe_insert("location", frame=frame)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES


def test_frames_show_the_same_however_they_are_reached(ui: Window) -> Iterator[None]:
    """Played, scrubbed backwards by the mouse's arrow keys, and jumped to."""
    yield from start(ui)
    animate()
    scene = bpy.context.scene
    reference = {}
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
        reference[frame] = shown(BODY)
        assert_followed()
    tolerance = 1e-5 * diagonal()

    def assert_reference() -> None:
        frame = scene.frame_current
        np.testing.assert_allclose(shown(BODY), reference[frame], rtol=0, atol=tolerance)
        assert_followed()

    ui.move(ui.region.x + 300, ui.region.y + 100)
    yield
    for _ in range(FRAMES - 1):  # backwards
        ui.tap("LEFT_ARROW")
        yield
        assert_reference()
    assert scene.frame_current == 1
    for frame in (9, 2, 12, 5):
        scene.frame_current = frame
        yield
        assert_reference()
    played = set()
    scene.frame_current = 1
    ui.tap("SPACE")
    for _ in range(60):
        yield 0.05
        assert_reference()
        played.add(scene.frame_current)
        if len(played) >= 5:
            break
    ui.tap("SPACE")
    yield
    assert len(played) >= 5
    assert_reference()


def test_keying_and_undo_of_keys_keep_mesh_and_handles_together(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    bpy.context.preferences.edit.use_keyframe_insert_available = False
    states = [state()]
    yield from grab(ui, HANDLE, 50, 30)
    ui.tap("RET")
    yield
    states.append(state())
    bpy.context.scene.frame_set(10)
    ui.undo_base()
    yield
    yield from grab(ui, HANDLE, -80, 50)
    ui.tap("RET")
    yield
    late = state()
    assert late != states[1]
    bpy.context.scene.frame_set(1)
    assert state() == states[1]
    bpy.context.scene.frame_set(10)
    assert state() == late
    yield from ui.undo()
    assert state() == states[1]  # at frame 10, where the first key held
    yield from ui.redo()
    assert state() == late


def test_a_setting_is_followed_at_once(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    yield from grab(ui, HANDLE, 60, 40)
    ui.tap("RET")
    yield
    before = state()
    bpy.data.objects[BODY].tug.form = "NO_ROTATIONS"
    bpy.data.objects[BODY].update_tag()
    yield
    assert state() != before
    assert_followed()


def test_nothing_follows_where_live_is_off(ui: Window) -> Iterator[None]:
    yield from start(ui)
    yield from click(ui, HANDLE)
    bpy.data.objects[BODY].tug.live = False
    before = state()
    yield from grab(ui, HANDLE, 60, 40)
    ui.tap("RET")
    yield
    assert state() == before
    bpy.data.objects[BODY].tug.live = True
    bpy.data.objects[BODY].update_tag()
    yield
    assert state() != before
    assert_followed()
