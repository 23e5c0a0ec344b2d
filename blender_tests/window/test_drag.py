# SPDX-License-Identifier: GPL-3.0-or-later
"""The drag tool: a handle is pulled by the mouse, and everything can be taken back."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from scenes import add_creature, key_of, shown
from window import Window

from addon.rigging import live, rig, shape_keys

BODY, HANDLE = "Creature", "Tail"


def with_tool(ui: Window) -> Iterator[None]:
    """The creature, and the tool."""
    add_creature()
    yield from ui.frame_all()
    with ui.context():
        bpy.ops.wm.tool_set_by_id(name="tug.drag")
    yield
    ui.undo_base()


def at_handle(ui: Window) -> Iterator[None]:
    ui.point_at(bpy.data.objects[HANDLE])
    yield


def pull(ui: Window, dx: float, dy: float) -> Iterator[None]:
    """Press on the handle and move, without letting go."""
    yield from at_handle(ui)
    ui.press("LEFTMOUSE")
    yield
    yield from ui.travel(dx, dy)


def let_go(ui: Window) -> Iterator[None]:
    ui.release("LEFTMOUSE")
    yield


def place() -> np.ndarray:
    return np.array(bpy.data.objects[HANDLE].location)


def state() -> dict[str, object]:
    """All that a drag may change."""
    handles = [handle.empty for handle in bpy.data.objects[BODY].tug.handles]
    return {
        "key": key_of(BODY).tobytes(),
        "shown": shown(BODY).tobytes(),
        "places": [tuple(empty.location) for empty in handles],
        "selected": [empty.select_get() for empty in handles],
        "posed": bpy.data.objects[BODY].tug.get(live.POSED),
        "dragging": dragging(),
    }


def dragging() -> bool:
    window = bpy.context.window_manager.windows[0]
    return any(operator.bl_idname == "TUG_OT_drag" for operator in window.modal_operators)


@contextmanager
def told() -> Iterator[list[str | None]]:
    """The texts that go to the status bar."""
    texts, original = [], bpy.types.WorkSpace.status_text_set

    def record(workspace: bpy.types.WorkSpace, text: str | None) -> None:
        texts.append(text)
        original(workspace, text)

    bpy.types.WorkSpace.status_text_set = record
    try:
        yield texts
    finally:
        bpy.types.WorkSpace.status_text_set = original


def test_a_drag_is_one_step_of_undo(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    states = [state()]
    for dx, dy in ((60, 40), (-30, 70)):
        yield from at_handle(ui)
        yield from ui.drag(dx, dy)
        states.append(state())
        assert states[-1]["key"] != states[-2]["key"]
    for before in (states[1], states[0]):
        yield from ui.undo()
        assert state() == before
    for after in (states[1], states[2]):
        yield from ui.redo()
        assert state() == after


def test_escape_and_the_right_button_restore_everything(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    for button in ("ESC", "RIGHTMOUSE"):
        before = state()
        yield from pull(ui, 60, 40)
        assert state() != before
        ui.tap(button)
        yield
        assert state() == before
        ui.release("LEFTMOUSE")
        yield
    # No step was pushed: undo goes back behind the first drag of all.
    first = state()
    yield from at_handle(ui)
    yield from ui.drag(50, 0)
    yield from pull(ui, 60, 40)
    ui.tap("ESC")
    yield
    yield from ui.undo()
    assert state() == first


def test_escape_brings_back_a_handle_that_undo_left_on_its_curves(ui: Window) -> Iterator[None]:
    """Blender then shows it where its curves have it, whatever its location says."""
    yield from with_tool(ui)
    bpy.data.objects[HANDLE].keyframe_insert("location")
    ui.undo_base()
    yield from pull(ui, 60, 40)
    yield from let_go(ui)
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)  # what was not keyed is lost
    with ui.context():
        bpy.ops.ed.undo_push(message="Frame")
    yield
    yield from ui.undo()
    yield 0.1
    before = key_of(BODY).tobytes(), shown(BODY).tobytes()
    yield from pull(ui, 30, -50)
    at = ui.pixels_of(bpy.data.objects[HANDLE].matrix_world.translation)
    assert np.abs(np.subtract(at, ui.pointer)).max() < 1.5
    ui.tap("ESC")
    yield
    yield from let_go(ui)
    assert (key_of(BODY).tobytes(), shown(BODY).tobytes()) == before


def test_escape_brings_back_a_pose_that_no_solve_gives(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    obj = bpy.data.objects[BODY]
    result = obj.data.shape_keys.key_blocks[obj.tug.result]
    shape_keys.write(obj.data, result, key_of(BODY) + np.float32(0.125))
    yield
    before = state()
    yield from pull(ui, 60, 40)
    ui.tap("ESC")
    yield
    assert state() == before


def test_the_handle_stays_under_the_mouse(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    yield from at_handle(ui)
    yield from ui.drag(70, 30)
    at = ui.pixels_of(bpy.data.objects[HANDLE].matrix_world.translation)
    assert np.abs(np.subtract(at, ui.pointer)).max() < 1.5


def test_keys_keep_a_drag_to_an_axis_or_a_plane(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    start = place()
    for number, axis in enumerate("XYZ"):
        yield from pull(ui, 60, 40)
        ui.tap(axis)
        yield
        assert [abs(change) > 1e-4 for change in place() - start] == [i == number for i in range(3)]
        ui.tap(axis, shift=True)
        yield
        assert [abs(change) > 1e-4 for change in place() - start] == [i != number for i in range(3)]
        ui.tap("ESC")
        yield


def test_shift_makes_a_drag_precise(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    start = place()
    yield from pull(ui, 60, 0)
    whole = np.linalg.norm(place() - start)
    ui.modifiers["shift"] = True
    yield from ui.travel(60, 0)
    del ui.modifiers["shift"]
    assert abs(np.linalg.norm(place() - start) / whole - 1.1) < 0.02
    ui.tap("ESC")
    yield


def test_a_press_beside_the_handles_is_passed_on(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    before = state()
    bpy.data.objects[BODY].select_set(True)
    low = ui.region
    ui.move(low.x + low.width * 0.5, low.y + low.height * 0.9)
    yield
    ui.tap("LEFTMOUSE")
    yield
    assert not bpy.data.objects[BODY].select_get()  # Blender's own: a click on nothing deselects
    assert state() == before


def test_a_click_on_a_handle_selects_it_and_moves_nothing(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    before = state()
    yield from at_handle(ui)
    ui.press("LEFTMOUSE")
    yield
    yield from ui.travel(1, 1, 1)
    yield from let_go(ui)
    assert bpy.data.objects[HANDLE].select_get()
    now = state()
    assert [now[what] for what in ("key", "places", "posed")] == [
        before[what] for what in ("key", "places", "posed")
    ]


def test_positions_between_two_frames_are_ignored(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    yield from pull(ui, 40, 0)
    before = state()
    x, y = ui.pointer
    ui.pointer = (x + 50, y)
    ui.event("INBETWEEN_MOUSEMOVE", "NOTHING")
    yield
    assert state() == before
    ui.tap("ESC")
    yield


def test_an_error_while_dragging_restores_and_reports(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    before = state()
    yield from pull(ui, 40, 0)
    follow = rig.follow

    def fail(*_: object) -> None:
        raise ZeroDivisionError("on purpose")

    rig.follow = fail
    try:
        bpy.data.objects[BODY].tug.live = False
        ui.move(ui.pointer[0] + 30, ui.pointer[1])
        yield
        bpy.data.objects[BODY].tug.live = True
    finally:
        rig.follow = follow
    assert state() == before
    yield from let_go(ui)
    assert "ZeroDivisionError: on purpose" in ui_reports()


def ui_reports() -> str:
    """What Blender's Info editor lists."""
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[-1]
    kind = area.type
    area.type = "INFO"
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.info.select_all(action="SELECT")
        bpy.ops.info.report_copy()
    area.type = kind
    return bpy.context.window_manager.clipboard


def is_keyed() -> bool:
    animation = bpy.data.objects[HANDLE].animation_data
    return animation is not None and animation.action is not None


def test_auto_keying_keys_the_handle_in_the_same_step(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    bpy.context.preferences.edit.use_keyframe_insert_available = True
    ui.undo_base()
    yield from at_handle(ui)
    yield from ui.drag(40, 20)
    assert not is_keyed()
    bpy.context.preferences.edit.use_keyframe_insert_available = False
    yield from at_handle(ui)
    yield from ui.drag(40, 20)
    moved = place()
    assert is_keyed()
    bpy.context.scene.frame_set(1)
    assert np.array_equal(place(), moved)
    yield from ui.undo()
    assert not is_keyed()
    assert not np.array_equal(place(), moved)


def test_auto_keying_follows_the_keying_set(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    settings, sets = bpy.context.scene.tool_settings, bpy.context.scene.keying_sets_all
    bpy.context.preferences.edit.use_keyframe_insert_available = False
    settings.use_keyframe_insert_auto = settings.use_keyframe_insert_keyingset = True
    sets.active = next(one for one in sets if one.bl_idname == "LocRotScale")
    yield from at_handle(ui)
    yield from ui.drag(40, 20)
    empty = bpy.data.objects[HANDLE]
    bpy.context.scene.frame_set(5)
    empty.scale = (3, 3, 3)
    bpy.context.scene.frame_set(1)
    assert tuple(empty.scale) == (1, 1, 1)  # it is keyed


def test_the_status_bar_tells_how_far_and_how_long(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    with told() as texts:
        yield from pull(ui, 60, 40)
        ui.tap("Z")
        yield
        last = texts[-1].split("    ")
        ui.tap("ESC")
        yield
    assert last[0] == HANDLE
    assert last[1].endswith("along Z")
    assert last[2].endswith(" ms") and last[3] == "converged"
    assert texts[-1] is None


def test_a_rig_that_is_stale_says_so(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    obj = bpy.data.objects[BODY]
    obj.shape_key_remove(obj.data.shape_keys.key_blocks[1])
    before = place()
    yield from at_handle(ui)
    yield from ui.drag(40, 20)
    assert np.array_equal(place(), before)
    assert "bind it again" in ui_reports()


def test_what_is_drawn_is_seen(ui: Window) -> Iterator[None]:
    """The ring of a handle under the mouse, and the bars beside one that is dragged."""
    yield from with_tool(ui)
    yield from at_handle(ui)
    yield from ui.travel(1, 0, 1)
    x, y = ui.pointer
    yield 0.2
    hovered = around(ui.picture("drag-hover"), x, y)
    ui.move(ui.region.x + 200, ui.region.y + 60)
    yield 0.2
    away = around(ui.picture("drag-away"), x, y)
    assert (hovered != away).any(axis=2).sum() > 100
    yield from pull(ui, -60, 40)
    yield 0.2
    x, y = ui.pointer
    bars = around(ui.picture("drag-bars"), x + 60, y)
    assert len(np.unique(bars.reshape(-1, 3), axis=0)) > 50
    yield from let_go(ui)
    yield 0.2
    ui.move(ui.region.x + 200, ui.region.y + 60)
    yield 0.2
    gone = around(ui.picture("drag-done"), x + 60, y)
    assert (bars != gone).any(axis=2).sum() > 500


def around(path: Path, x: float, y: float, reach: int = 50) -> np.ndarray:
    """A piece of a picture, rows by columns by 3."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    left, low = int(x) - reach, int(y) - reach
    return pixels.reshape(height, width, 4)[low : low + 2 * reach, left : left + 2 * reach, :3]


def test_colours_are_drawn_and_kept_only_when_asked(ui: Window) -> Iterator[None]:
    yield from with_tool(ui)
    yield from at_handle(ui)
    yield from ui.drag(-60, 40)
    attributes = len(bpy.data.objects[BODY].data.color_attributes)
    middle = ui.pixels_of(shown(BODY).mean(axis=0))
    pictures = []
    for wanted in ("NONE", "EXAMPLES", "PARTS"):
        bpy.context.window_manager.tug_colours = wanted
        yield 0.3
        pictures.append(around(ui.picture(f"colours-{wanted.lower()}"), *middle))
    assert (pictures[0] != pictures[2]).any(axis=2).mean() > 0.3
    assert (pictures[1] != pictures[2]).any(axis=2).mean() > 0.3
    assert len(bpy.data.objects[BODY].data.color_attributes) == attributes
