# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel and the operators that need a window. An exception in a panel's draw is printed, which
fails a test."""

from __future__ import annotations

import time
from collections.abc import Iterator

import bmesh
import bpy
import numpy as np
from scenes import add_creature, shown
from window import Window

from addon.ui import panel

PATIENCE = 60.0  # seconds for a bind


def show_panel(ui: Window) -> Iterator[None]:
    """The sidebar with Tug's tab, all of its parts open."""
    for cls in reversed(panel.CLASSES):
        bpy.utils.unregister_class(cls)
    for cls in panel.CLASSES:
        cls.bl_options = set()
        bpy.utils.register_class(cls)
    ui.area.spaces.active.show_region_ui = True
    yield
    sidebar = next(region for region in ui.area.regions if region.type == "UI")
    sidebar.active_panel_category = "Tug"
    yield


def add_tube(count: int, name: str = "Tube") -> bpy.types.Object:
    """A tube of `count` rings of 100 vertices, with an example."""
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    height = np.linspace(0, 10, count)
    points = np.column_stack([np.tile(ring, (count, 1)), np.repeat(height, 100)])
    number = np.arange(count * 100).reshape(count, 100)
    corners = [number[:-1], np.roll(number[:-1], -1, 1), np.roll(number[1:], -1, 1), number[1:]]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], np.stack(corners, -1).reshape(-1, 4).tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    for key, factor in (("Basis", 1.0), ("Long", 1.5)):
        block = obj.shape_key_add(name=key, from_mix=False)
        block.value = 0.0
        block.points.foreach_set("co", (points * [1, 1, factor]).astype(np.float32).ravel())
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def wait_for(condition: object) -> Iterator[float]:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        yield 0.05


def binding(ui: Window) -> bool:
    return any(operator.bl_idname.startswith("TUG_OT") for operator in ui.window.modal_operators)


def test_the_panel_in_every_state(ui: Window) -> Iterator[None]:
    yield from show_panel(ui)
    bpy.ops.mesh.primitive_cube_add()
    yield
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    obj = add_tube(12)
    yield
    with ui.context():
        bpy.ops.tug.add_handles(count=4)
    yield
    with ui.context():
        bpy.ops.tug.bind()
    yield
    bpy.data.objects["Handle 2"].location.x += 1
    yield
    for _ in range(2):
        with ui.context():
            bpy.ops.tug.tick_example(key="Long")
        yield
    with ui.context():
        bpy.ops.tug.select_handles(index=1)
    yield
    obj.tug.handles[1].hold = "SOFT"
    yield
    obj.tug.active_handle = 2
    with ui.context():
        bpy.ops.tug.delete_handle()
    yield
    ui.picture("panel-stale")
    with ui.context():
        bpy.context.view_layer.objects.active = obj
        bpy.ops.tug.bind()
        bpy.ops.object.mode_set(mode="EDIT")
    yield
    with ui.context():
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.tug.bake(filepath=f"{bpy.app.tempdir}tube.pc2", first=1, last=2)
    yield
    with ui.context():
        bpy.ops.object.duplicate()
    yield
    ui.picture("panel-duplicate")


def test_the_menus(ui: Window) -> Iterator[None]:
    add_tube(12)
    for menu in ("TUG_MT_add_handles", "TUG_MT_tug"):
        with ui.context():
            bpy.ops.wm.call_menu(name=menu)
        yield 0.3
        ui.picture(f"panel-{menu}")
        ui.tap("ESC")
        yield


def test_the_search_finds_what_an_artist_looks_for(ui: Window) -> Iterator[None]:
    add_tube(40)
    yield from ui.frame_all()
    ui.move(*ui.pixels_of((0, 0, 0)))
    yield
    ui.tap("F3")
    yield 0.3
    ui.type("tug set up")
    yield 0.5
    ui.picture("panel-search")
    ui.tap("RET")
    yield from wait_for(lambda: bpy.data.objects["Tube"].tug.bound)


def test_a_bind_runs_beside_the_window_and_is_one_undo_step(ui: Window) -> Iterator[None]:
    yield from show_panel(ui)
    add_tube(200)
    ui.undo_base()
    with ui.context():
        bpy.ops.tug.set_up("INVOKE_DEFAULT")
    assert binding(ui)
    assert not bpy.data.objects["Tube"].tug.bound
    yield from wait_for(lambda: not binding(ui))
    assert bpy.data.objects["Tube"].tug.bound
    assert len(bpy.data.objects["Tube"].tug.handles) == 10
    before = shown("Tube")
    yield from ui.undo()
    assert not bpy.data.objects["Tube"].tug.bound
    assert len(bpy.data.objects["Tube"].tug.handles) == 0
    yield from ui.redo()
    assert bpy.data.objects["Tube"].tug.bound
    np.testing.assert_array_equal(shown("Tube"), before)


def test_a_bind_is_cancelled_by_esc(ui: Window) -> Iterator[None]:
    yield from show_panel(ui)
    add_tube(1000)
    with ui.context():
        bpy.ops.tug.set_up("INVOKE_DEFAULT")
    yield 0.3
    ui.picture("panel-binding")
    assert binding(ui)
    ui.tap("ESC")
    yield from wait_for(lambda: not binding(ui))
    obj = bpy.data.objects["Tube"]
    assert not obj.tug.bound
    assert len(obj.tug.handles) == 0
    assert [block.name for block in obj.data.shape_keys.key_blocks] == ["Basis", "Long"]
    assert not any(o.type == "EMPTY" for o in bpy.data.objects)


def test_an_object_that_is_edited_while_it_is_bound_is_not_bound(ui: Window) -> Iterator[None]:
    obj = add_tube(300)
    with ui.context():
        bpy.ops.tug.add_handles(count=4)
        bpy.ops.tug.bind("INVOKE_DEFAULT")
        bpy.ops.object.mode_set(mode="EDIT")
        mesh = bmesh.from_edit_mesh(obj.data)
        mesh.verts.ensure_lookup_table()
        bmesh.ops.delete(mesh, geom=[mesh.verts[500]], context="VERTS")
        bmesh.update_edit_mesh(obj.data)
        bpy.ops.object.mode_set(mode="OBJECT")
    yield from wait_for(lambda: not binding(ui))
    assert not obj.tug.bound


def test_an_object_that_is_deleted_while_it_is_bound(ui: Window) -> Iterator[None]:
    obj = add_tube(300)
    with ui.context():
        bpy.ops.tug.add_handles(count=4)
        bpy.ops.tug.bind("INVOKE_DEFAULT")
    bpy.data.objects.remove(obj)
    yield from wait_for(lambda: not binding(ui))


def test_handles_are_added_by_clicks(ui: Window) -> Iterator[None]:
    obj = add_creature(bound=False)
    yield from ui.frame_all()
    ui.undo_base()
    count = len(obj.tug.handles)
    with ui.context():
        bpy.ops.tug.click_handles("INVOKE_DEFAULT")
    yield
    for name in ("Back", "Chest"):
        ui.point_at(bpy.data.objects[name])
        ui.move(ui.pointer[0] + 25, ui.pointer[1] - 10)
        yield
        ui.tap("LEFTMOUSE")
        yield
    ui.tap("RET")
    yield
    obj = bpy.context.view_layer.objects["Creature"]
    assert len(obj.tug.handles) == count + 2
    ui.picture("panel-clicks")
    yield from ui.undo()
    assert len(bpy.data.objects["Creature"].tug.handles) == count + 1
    ui.move(ui.pointer[0], ui.region.y + 5)
    with ui.context():
        bpy.ops.tug.click_handles("INVOKE_DEFAULT")
    yield
    ui.tap("LEFTMOUSE")  # beside the mesh
    yield
    ui.tap("ESC")
    yield
    assert len(bpy.data.objects["Creature"].tug.handles) == count + 1


def test_a_new_name_of_a_shape_key_is_taken_over_at_once(ui: Window) -> Iterator[None]:
    obj = add_tube(12)
    with ui.context():
        bpy.ops.tug.set_up(count=3)
    yield
    obj.data.shape_keys.key_blocks["Long"].name = "Longer"
    yield
    assert obj.tug.examples == '["Basis", "Longer"]'


def test_a_pose_is_chosen_by_name_and_saved_as_an_example(ui: Window) -> Iterator[None]:
    add_tube(40)
    with ui.context():
        bpy.ops.tug.set_up(count=3)
    yield from ui.frame_all()
    rest = shown("Tube")
    with ui.context():
        bpy.ops.tug.pose_from_key("INVOKE_DEFAULT")
    yield 0.3
    ui.type("long")
    yield 0.3
    ui.tap("RET")
    yield 0.2
    assert np.ptp(shown("Tube")[:, 2]) > 1.4 * np.ptp(rest[:, 2])
    bpy.data.objects["Handle 1"].location.x += 3
    yield
    with ui.context():
        bpy.ops.tug.save_pose("INVOKE_DEFAULT")
    yield 0.3
    ui.tap("RET")
    yield from wait_for(lambda: "Pose" in bpy.data.objects["Tube"].tug.examples)
    yield from wait_for(lambda: not binding(ui))
    ui.picture("panel-pose")


def test_the_sample_is_opened_bound_and_pulled(ui: Window) -> Iterator[None]:
    yield from show_panel(ui)
    with ui.context():
        bpy.ops.tug.open_sample("INVOKE_DEFAULT")
    yield 0.2
    with ui.context():
        bpy.ops.tug.bind("INVOKE_DEFAULT")
    yield from wait_for(lambda: not binding(ui))
    rest = shown("Fox")
    ui.point_at(bpy.data.objects["Head"])
    yield
    yield from ui.drag(-40, 60)
    assert np.abs(shown("Fox") - rest).max() > 0.1
    ui.picture("panel-fox")
