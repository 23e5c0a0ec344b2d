# SPDX-License-Identifier: GPL-3.0-or-later
"""A monkey at the desk: random actions from a seed, and what must hold after each of them.

TUG_MONKEY says how many actions, TUG_MONKEY_SEED which ones. Without them, a thousand are divided
among the two Blenders that have windows, different ones in each.
"""

from __future__ import annotations

import os
import random
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np
from scenes import key_of, pose_asked, shown
from support import animate, bound_rig
from window import Window

from addon import handlers
from addon.rigging import rig
from addon.rigging.inputs import RigError
from addon.ui import state

ACTIONS = int(os.environ.get("TUG_MONKEY", "500"))
SEED = int(os.environ.get("TUG_MONKEY_SEED", bpy.app.version[1]))
NAME = "Tube"
MODES = ("EDIT", "SCULPT", "WEIGHT_PAINT")
LAST_FRAME = 12

Steps = Iterator[float | None]


def test_a_monkey_breaks_nothing(ui: Window) -> Steps:
    animate(bound_rig(NAME), LAST_FRAME)
    yield from ui.frame_all()
    ui.undo_base()
    with tempfile.TemporaryDirectory() as folder:
        monkey = Monkey(ui, Path(folder, "monkey.blend"))
        for number in range(ACTIONS):
            try:
                yield from monkey.act()
                ui.console.check()
                monkey.check()
            except Exception as error:
                raise AssertionError(f"action {number} after {monkey.done[-12:]}") from error


test_a_monkey_breaks_nothing.seconds = 60 + 5 * ACTIONS


class Monkey:
    """Does one thing after the other. `done` names them, the last one last."""

    def __init__(self, ui: Window, file: Path) -> None:
        self.ui, self.file = ui, file
        self.random = random.Random(SEED)
        self.done: list[str] = []
        # How often, relative to the others.
        self.actions: dict[Callable[[], Steps], int] = {
            self.drag: 6,
            self.grab: 4,
            self.undo: 6,
            self.redo: 4,
            self.change_mode: 2,
            self.jump: 3,
            self.key_handles: 1,
            self.set_option: 2,
            self.rename_key: 1,
            self.rename_objects: 1,
            self.delete_handle: 1,
            self.add_handle: 1,
            self.move_vertices: 1,
            self.delete_face: 1,
            self.save_and_load: 1,
            self.bind: 5,
        }

    @property
    def obj(self) -> bpy.types.Object | None:
        """The mesh, by whatever name; none before the scene was built, where undo may lead."""
        return next((o for o in bpy.context.scene.objects if o.type == "MESH"), None)

    def act(self) -> Steps:
        (action,) = self.random.choices([*self.actions], [*self.actions.values()])
        if self.obj is None:
            action = self.redo
        self.done.append(action.__name__)
        yield from action()

    def check(self) -> None:
        obj = self.obj
        if obj is None or not obj.tug.bound:
            return
        keys = obj.data.shape_keys
        if keys is None or obj.tug.result not in keys.key_blocks:
            return
        assert np.isfinite(key_of(obj.name)).all()
        waits = obj.mode != "OBJECT" or not obj.tug.live
        if waits or state.stale(obj, bpy.context.scene) or handlers.problem(obj):
            return
        try:
            asked = pose_asked(obj.name)
        except RigError:  # stale in a way that is not looked for until the next pose
            return
        np.testing.assert_array_equal(key_of(obj.name), asked)

    # What it does.

    def drag(self) -> Steps:
        yield from self.leave_mode()
        with self.ui.context():
            bpy.ops.wm.tool_set_by_id(name="tug.drag")
        yield from self.point_at_handle()
        before = shown(self.obj.name)
        self.ui.press("LEFTMOUSE")
        yield
        yield from self.ui.travel(*self.far(), steps=3)
        end = self.random.choice(("release", "release", "ESC", "RIGHTMOUSE"))
        if end != "release":
            self.ui.tap(end)
            yield
        self.ui.release("LEFTMOUSE")
        yield
        if end != "release":
            np.testing.assert_array_equal(shown(self.obj.name), before)
        with self.ui.context():
            bpy.ops.wm.tool_set_by_id(name="builtin.select_box")

    def grab(self) -> Steps:
        yield from self.leave_mode()
        yield from self.point_at_handle()
        self.ui.tap("LEFTMOUSE")
        yield
        self.ui.tap("G")
        yield
        yield from self.ui.travel(*self.far(), steps=3)
        self.ui.tap(self.random.choice(("RET", "RET", "ESC")))
        yield

    def undo(self) -> Steps:
        yield from self.ui.undo(self.random.randint(1, 3))

    def redo(self) -> Steps:
        yield from self.ui.redo(self.random.randint(1, 3))

    def change_mode(self) -> Steps:
        yield from self.leave_mode()
        self.set_mode(self.random.choice(MODES))
        yield

    def jump(self) -> Steps:
        bpy.context.scene.frame_set(self.random.randint(0, LAST_FRAME + 3))
        yield

    def key_handles(self) -> Steps:
        for handle in self.obj.tug.handles:
            if handle.empty:
                handle.empty.keyframe_insert("location")
        yield from self.pushed("Key handles")

    def set_option(self) -> Steps:
        options = self.obj.tug
        choices = {
            "selectivity": (0.0, 0.5, 2.0),
            "steadiness": (0.0, 0.1),
            "form": ("STEADY", "NO_ROTATIONS"),
            "live": (True, True, False),
            "group_count": (0, 4),
            "dictionary": ("HANDLES", "EIGENFUNCTIONS"),
        }
        name = self.random.choice([*choices])
        setattr(options, name, self.random.choice(choices[name]))
        yield from self.pushed(f"Set {name}")

    def rename_key(self) -> Steps:
        key = self.random.choice(self.obj.data.shape_keys.key_blocks)
        key.name = key.name[:-1] if key.name.endswith("!") else f"{key.name}!"
        yield from self.pushed("Rename key")

    def rename_objects(self) -> Steps:
        for obj in bpy.context.scene.objects:
            obj.name = obj.name[:-1] if obj.name.endswith("?") else f"{obj.name}?"
        yield from self.pushed("Rename objects")

    def delete_handle(self) -> Steps:
        yield from self.leave_mode()
        yield from self.point_at_handle()
        self.ui.tap("LEFTMOUSE")
        yield
        active = bpy.context.view_layer.objects.active
        if active is not None and active.type == "EMPTY" and active.select_get():
            with self.ui.context():
                bpy.ops.object.delete()
        yield

    def add_handle(self) -> Steps:
        yield from self.leave_mode()
        obj = self.obj
        if len(self.alive()) < 6:
            rig.add_handle(obj, self.random.randrange(len(obj.data.vertices)), "Handle")
        yield from self.pushed("Add handle")

    def move_vertices(self) -> Steps:
        yield from self.in_edit_mode(self.some_selected("VERT"), self.move_selected)

    def delete_face(self) -> Steps:
        if len(self.obj.data.polygons) > 100:
            yield from self.in_edit_mode(
                self.some_selected("FACE"), lambda: bpy.ops.mesh.delete(type="FACE")
            )

    def save_and_load(self) -> Steps:
        yield from self.leave_mode()
        bpy.ops.wm.save_as_mainfile(filepath=str(self.file))
        yield
        bpy.ops.wm.open_mainfile(filepath=str(self.file))
        yield 0.2
        yield from self.ui.frame_all()
        self.ui.undo_base()

    def bind(self) -> Steps:
        yield from self.leave_mode()
        self.activate()
        try:
            with self.ui.context():
                bpy.ops.tug.bind()
        except RuntimeError as error:  # what it reports, and what its poll says
            assert "Traceback" not in str(error), error
        yield

    # What these are made of.

    def point_at_handle(self) -> Steps:
        alive = self.alive()
        if alive:
            self.ui.point_at(self.random.choice(alive))
        yield

    def alive(self) -> list[bpy.types.Object]:
        scene = bpy.context.scene.objects
        empties = [handle.empty for handle in self.obj.tug.handles]
        return [empty for empty in empties if empty is not None and empty.name in scene]

    def far(self) -> tuple[int, int]:
        return self.random.randint(-60, 60), self.random.randint(-60, 60)

    def leave_mode(self) -> Steps:
        if self.obj.mode != "OBJECT":
            self.set_mode("OBJECT")
        yield

    def set_mode(self, mode: str) -> None:
        self.activate()
        with self.ui.context():
            bpy.ops.object.mode_set(mode=mode)

    def activate(self) -> None:
        self.obj.select_set(True)
        bpy.context.view_layer.objects.active = self.obj

    def in_edit_mode(self, *operations: Callable[[], object]) -> Steps:
        yield from self.leave_mode()
        self.set_mode("EDIT")
        yield
        for operation in operations:
            with self.ui.context():
                operation()
            yield
        self.set_mode("OBJECT")
        yield

    def some_selected(self, kind: str) -> Callable[[], object]:
        seed = self.random.randrange(1000)

        def select() -> None:
            bpy.ops.mesh.select_mode(type=kind)
            bpy.ops.mesh.select_all(action="DESELECT")
            bpy.ops.mesh.select_random(ratio=0.02, seed=seed)

        return select

    def move_selected(self) -> None:
        bpy.ops.transform.translate(value=(0.05, 0.0, 0.02))

    def pushed(self, name: str) -> Steps:
        """Scripts push no undo step of their own."""
        with self.ui.context():
            bpy.ops.ed.undo_push(message=name)
        yield
