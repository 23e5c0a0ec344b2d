# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs follow their handles, and are solved only where something asks for another pose."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import (
    HANDLES,
    add_rig,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    expected,
    in_mode,
    key,
    pull_between,
    pull_to,
)

from addon import handlers
from addon.rigging import live, rig

AWAY = Vector((0.3, -0.2, 0.4))


@pytest.fixture
def solves(monkeypatch):
    """Names of the objects that were solved."""
    found = []
    solve = rig.solve
    monkeypatch.setattr(
        rig, "solve", lambda obj, *given: found.append(obj.name) or solve(obj, *given)
    )
    return found


def move(name="Tip", by=AWAY):
    bpy.data.objects[name].location += by
    bpy.context.view_layer.update()


def test_the_mesh_follows_a_handle(solves):
    obj = bound_rig()
    rest = evaluated(obj)[HANDLES["Tip"]]
    move()
    assert solves == ["Tube"]
    np.testing.assert_allclose(evaluated(obj)[HANDLES["Tip"]], rest + AWAY, atol=1e-5)
    assert_close(evaluated(obj), expected(obj))
    assert live.known(obj).last.info.converged


@pytest.mark.parametrize("how", ["parent", "constraint", "hidden"])
def test_the_mesh_follows_a_handle_that_something_else_moves(how):
    obj = bound_rig()
    tip = bpy.data.objects["Tip"]
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    if how == "constraint":
        goal.location = tip.location
        tip.constraints.new("COPY_LOCATION").target = goal
    else:
        tip.parent = goal
    if how == "hidden":
        tip.hide_viewport = True
    bpy.context.view_layer.update()
    rest = evaluated(obj)[HANDLES["Tip"]]
    move("Goal")
    np.testing.assert_allclose(evaluated(obj)[HANDLES["Tip"]], rest + AWAY, atol=1e-5)


def test_nothing_is_solved_for_what_moves_elsewhere(solves):
    obj, other = bound_rig("First", "first "), bound_rig("Second", "second ")
    move("first Tip")
    assert solves == ["First"]
    obj.select_set(True)
    bpy.data.objects["second Tip"].select_set(True)
    other.show_wire = True
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(5)
    assert solves == ["First"]


def test_a_rig_that_is_not_live_waits():
    obj = bound_rig()
    obj.tug.live = False
    before = evaluated(obj)
    move()
    bpy.context.scene.frame_set(3)
    np.testing.assert_array_equal(evaluated(obj), before)
    obj.tug.live = True
    bpy.context.view_layer.update()
    assert_close(evaluated(obj), expected(obj))


def test_a_setting_shows_at_once():
    obj = bound_rig()
    pull_between(obj)
    before = evaluated(obj)
    obj.tug.squared = True
    bpy.context.view_layer.update()
    assert np.abs(evaluated(obj) - before).max() > 1e-3
    assert_close(evaluated(obj), expected(obj))


def test_a_moved_object_is_posed_anew_as_handles_stay_behind():
    obj = bound_rig()
    obj.location += AWAY
    bpy.context.view_layer.update()
    assert_close(evaluated(obj), expected(obj))
    np.testing.assert_allclose(evaluated(obj)[0], [0.5, 0, 0] - np.array(AWAY), atol=1e-5)


def test_a_linked_duplicate_that_is_moved_keeps_its_shape():
    obj = bound_rig()
    move()
    before = evaluated(obj)
    copy = obj.copy()
    bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    copy.location += AWAY
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(evaluated(obj), before)
    np.testing.assert_array_equal(evaluated(copy), before)
    move("Middle")
    assert_close(evaluated(obj), expected(obj))
    np.testing.assert_array_equal(evaluated(copy), evaluated(obj))


def test_an_example_that_was_sculpted_shows_when_sculpting_ends():
    obj = bound_rig()
    pull_to(obj, "Swell")
    before = evaluated(obj)
    with in_mode(obj, "SCULPT"):
        key(obj, "Swell").points[50].co.x += 0.3
        bpy.context.view_layer.update()
        np.testing.assert_array_equal(evaluated(obj), before)
    bpy.context.view_layer.update()
    assert np.abs(evaluated(obj) - before).max() > 0.1


def test_neither_undo_nor_redo_solves(solves):
    obj = bound_rig()
    bpy.ops.ed.undo_push(message="bound")
    rest = evaluated(obj)
    move()
    moved = evaluated(obj)
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(evaluated(bpy.data.objects["Tube"]), rest)
    bpy.ops.ed.redo()
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(evaluated(bpy.data.objects["Tube"]), moved)
    assert solves == ["Tube"]


def test_a_loaded_file_shows_its_pose_without_a_solver(tmp_path):
    obj = bound_rig()
    move()
    before = evaluated(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    obj = bpy.data.objects["Tube"]
    np.testing.assert_array_equal(evaluated(obj), before)
    bpy.context.scene.frame_set(2)
    assert live.known(obj) is None
    move(by=-AWAY)
    assert_close(evaluated(obj), expected(obj))


def test_a_pose_from_elsewhere_stays_until_a_handle_moves():
    obj = bound_rig()
    swollen = rig.positions(obj, depsgraph()) + [0, 0.1, 0]
    rig.show(obj, swollen, depsgraph())
    obj.show_wire = True
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(7)
    assert_close(evaluated(obj), swollen)
    move()
    assert_close(evaluated(obj), expected(obj))


def test_a_stale_rig_says_so_and_keeps_its_mesh(capsys):
    obj = bound_rig()
    before = evaluated(obj)
    rig.add_handle(obj, 40, "Fourth")
    move()
    assert 'its handle "Fourth" is new' in handlers.problem(obj)
    assert capsys.readouterr().out.count("is new") == 1
    np.testing.assert_array_equal(evaluated(obj), before)
    rig.bind(obj)
    move()
    assert handlers.problem(obj) == ""


def test_a_rig_that_is_not_bound_is_left_alone(solves):
    obj = add_rig()
    move()
    assert solves == []
    assert handlers.problem(obj) == ""
