# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators say why they cannot be used, and Blender finds all of them."""

import re
from pathlib import Path

import bpy
import numpy as np
import pytest
from support import add_rig, add_tube, bound_rig, evaluated, state, tube

import addon
from addon import sample
from addon.properties import TUG_PG_handle, TUG_PG_rig
from addon.ui import menus, panel
from addon.ui import state as ui_state


def activate(obj):
    bpy.context.view_layer.objects.active = obj
    if obj is not None:
        obj.select_set(True)
    return obj


def operators():
    return [name for name in dir(bpy.ops.tug) if not name.startswith("_")]


def reason(name):
    """Why an operator is disabled."""
    with pytest.raises(RuntimeError) as caught:
        getattr(bpy.ops.tug, name)()
    return str(caught.value).strip()


def test_every_operator_is_explained_to_artists():
    for name in operators():
        rna = getattr(bpy.ops.tug, name).get_rna_type()
        assert rna.name and rna.name[0].isupper()
        assert len(rna.description) > 20, name
        assert not rna.description.endswith("."), name
        for prop in rna.properties:
            if not prop.is_hidden and prop.identifier != "rna_type":
                assert prop.name, f"{name}.{prop.identifier}"


def test_every_operator_is_in_the_menu_where_the_search_looks():
    source = Path(menus.__file__).read_text()
    missing = [name for name in operators() if f'"tug.{name}"' not in source]
    assert missing == ["tick_example"]  # stands for a box in a list


def test_every_button_is_in_the_reference():
    text = (Path(addon.__file__).parent.parent / "docs" / "reference.md").read_text()
    labels = [getattr(bpy.ops.tug, name).get_rna_type().name for name in operators()]
    drawn = Path(panel.__file__).read_text()
    properties = [
        prop.name
        for group in (TUG_PG_rig, TUG_PG_handle)
        for prop in group.bl_rna.properties
        if not prop.is_hidden and f'"{prop.identifier}"' in drawn
    ]
    assert len(properties) > 15
    assert [name for name in labels + properties if name not in text] == []


def test_every_operator_on_a_mesh_asks_for_one():
    activate(None)
    for name in set(operators()) - {"open_sample", "drag", "store_colours"}:
        assert "Select a mesh, or one of its handles" in reason(name), name


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("bind", "Add shape keys first"),
        ("set_up", "Add shape keys first"),
        ("add_handles", "Add shape keys first"),
        ("select_handles", "Add handles first"),
        ("unbind", "Bind the mesh to its handles first"),
        ("bake", "Bind the mesh to its handles first"),
        ("remove_bake", "Bake first"),
    ],
)
def test_a_plain_mesh(name, wanted):
    bpy.ops.mesh.primitive_cube_add()
    assert wanted in reason(name)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("bind", "Leave Edit Mode first"),
        ("add_handles", "Leave Edit Mode first"),
        ("save_pose", "Leave Edit Mode first"),
    ],
)
def test_edit_mode(name, wanted):
    activate(bound_rig())
    bpy.ops.object.mode_set(mode="EDIT")
    assert wanted in reason(name)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "Enter Edit Mode and select vertices first" in reason("put_handle")


def test_what_is_not_there_yet():
    activate(add_tube())
    assert "Add at least two handles first" in reason("bind")
    assert "Add an Armature modifier first" in reason("add_handles_on_bones")
    activate(add_rig("Other", "other "))
    assert "Copy a pose first" in reason("paste_pose")


def test_a_stale_rig_says_what_changed():
    obj = activate(bound_rig())
    obj.shape_key_remove(obj.data.shape_keys.key_blocks["Bend"])
    assert 'its shape key "Bend" was deleted or renamed: bind it again' in reason("save_pose")
    assert '"Bend" was deleted or renamed' in ui_state.stale(obj, bpy.context.scene)
    bpy.ops.tug.bind()
    assert ui_state.stale(obj, bpy.context.scene) == ""


def test_changes_that_wait_for_a_bind_are_told():
    obj = activate(bound_rig())
    assert ui_state.pending(obj) == ""
    bpy.ops.tug.tick_example(key="Swell")
    assert "Other examples are ticked" in ui_state.pending(obj)
    bpy.ops.tug.bind()
    obj.tug.handles["Middle"].vertex = 95
    assert "Middle" in ui_state.pending(obj)


def test_set_up_adds_handles_and_binds():
    obj = activate(add_tube())
    bpy.ops.tug.set_up(count=4)
    assert obj.tug.bound
    assert len(obj.tug.handles) == 4
    assert re.fullmatch(r"[\d.]+ ms, settled, gap \S+", ui_state.last_solve(obj))


def test_set_up_that_fails_leaves_nothing_behind():
    vertices, _ = tube()
    obj = activate(add_tube())
    block = obj.data.shape_keys.key_blocks["Bend"]
    block.points[5].co.x = float("nan")
    before = state(obj)
    with pytest.raises(RuntimeError, match="points that are nowhere"):
        bpy.ops.tug.set_up()
    assert re.sub("NaN", "0", state(obj)) == re.sub("NaN", "0", before)
    assert len(obj.tug.handles) == 0


def test_unbind_shows_the_keys_again():
    obj = activate(bound_rig())
    bpy.ops.tug.unbind()
    assert not obj.tug.bound
    np.testing.assert_allclose(evaluated(obj), tube()[0], atol=1e-6)


def test_undo_of_operators():
    activate(add_tube())
    bpy.ops.ed.undo_push(message="tube")
    bpy.ops.tug.set_up(count=3)
    bpy.ops.ed.undo_push(message="set up")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert not obj.tug.bound
    assert len(obj.tug.handles) == 0
    bpy.ops.ed.redo()
    assert bpy.data.objects["Tube"].tug.bound


# The sample ------------------------------------------------------------------------------------


@pytest.fixture
def file(tmp_path):
    """A small sample: the tube."""
    vertices, quads = tube()
    np.savez_compressed(
        tmp_path / "sample.npz",
        faces=np.array(quads, np.int32),
        colors=np.ones((len(vertices), 3), np.float32),
        names=np.array(["Basis", "Long"]),
        shapes=np.stack([vertices, vertices * [1, 1, 1.5]]).astype(np.float32),
        handle_names=np.array(["Foot", "Head"]),
        handle_vertices=np.array([0, 155], np.int32),
    )
    return tmp_path / "sample.npz"


def test_the_sample_comes_in_a_scene_of_its_own_ready_to_bind(file):
    obj = sample.add_scene(file)
    assert [scene.name for scene in obj.users_scene] == ["Tug Sample"]
    assert [handle.title for handle in obj.tug.handles] == ["Foot", "Head"]
    assert all(h.empty.users_scene == obj.users_scene for h in obj.tug.handles)
    assert [block.name for block in obj.data.shape_keys.key_blocks] == ["Basis", "Long"]
    assert obj.data.shape_keys.key_blocks["Long"].value == 0


def test_without_its_file_the_sample_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(sample, "FILE", tmp_path / "none.npz")
    with pytest.raises(RuntimeError, match="was not installed from its zip"):
        bpy.ops.tug.open_sample()
    assert len(bpy.data.scenes) == 1
