# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters that are linked from another file, as they are and as library overrides."""

import bpy
import numpy as np
import pytest
from support import (
    HANDLES,
    add_tube,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    read_pc2,
)

from addon import bake, handlers
from addon.rigging import rig
from addon.rigging.inputs import RigError
from addon.ui import state


@pytest.fixture
def library(tmp_path):
    """A file with a bound character in a collection."""
    obj = add_tube()
    collection = bpy.data.collections.new("Character")
    scene = bpy.context.scene.collection
    scene.children.link(collection)
    scene.objects.unlink(obj)
    collection.objects.link(obj)
    for name, vertex in HANDLES.items():
        rig.add_handle(obj, vertex, name)
    rig.bind(obj)
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, linked):
        linked.collections = ["Character"]
    return bpy.data.collections["Character"]


@pytest.fixture
def linked(library):
    bpy.context.scene.collection.children.link(library)
    obj = next(obj for obj in library.all_objects if obj.type == "MESH")
    bpy.context.view_layer.objects.active = obj
    return obj


@pytest.fixture
def overridden(library):
    override = library.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    obj = next(obj for obj in override.all_objects if obj.type == "MESH")
    bpy.context.view_layer.objects.active = obj
    return obj


def move_tip(obj):
    obj.tug.handles["Tip"].empty.location.z += 0.5
    bpy.context.view_layer.update()


@pytest.mark.parametrize("kind", ["linked", "overridden"])
def test_binding_says_why_it_cannot_be(kind, request):
    obj = request.getfixturevalue(kind)
    wanted = '"Tube" is linked from another file: make it and its mesh local first'
    with pytest.raises(RigError, match=wanted):
        rig.bind(obj)
    with pytest.raises(RigError, match=wanted):
        rig.add_handle(obj, 40, "Fourth")
    with pytest.raises(RuntimeError, match="Linked from another file: make the object"):
        bpy.ops.tug.bind()


def test_an_overridden_character_has_handles_of_its_own_and_is_baked(overridden, tmp_path):
    assert state.stale(overridden, bpy.context.scene) == ""
    assert all(handle.empty.library is None for handle in overridden.tug.handles)
    before = evaluated(overridden)
    move_tip(overridden)
    assert handlers.problem(overridden) == ""
    np.testing.assert_array_equal(evaluated(overridden), before)
    bake.bake(overridden, 1, 2, tmp_path / "tube.pc2")
    _, frames = read_pc2(tmp_path / "tube.pc2")
    assert_close(frames[0], rig.positions(overridden, depsgraph()))
    assert_close(evaluated(overridden), frames[0])
    assert evaluated(overridden)[HANDLES["Tip"], 2] - before[HANDLES["Tip"], 2] > 0.4


def test_a_linked_character_is_not_baked_but_told_how(linked, tmp_path):
    with pytest.raises(RigError, match="make a library override of it first"):
        bake.bake(linked, 1, 2, tmp_path / "tube.pc2")
    assert not (tmp_path / "tube.pc2").exists()


def test_a_character_that_is_made_local_is_bound(linked):
    bpy.ops.object.make_local(type="ALL")
    obj = next(obj for obj in bpy.context.scene.objects if obj.type == "MESH")
    assert obj.library is None and obj.data.library is None
    rig.bind(obj)
    move_tip(obj)
    assert_close(evaluated(obj), rig.positions(obj, depsgraph()))


def test_an_appended_character_goes_on(tmp_path):
    bound_rig()
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=False) as (_, appended):
        appended.objects = ["Tube"]
    obj = bpy.data.objects["Tube"]
    bpy.context.scene.collection.objects.link(obj)
    for handle in obj.tug.handles:
        bpy.context.scene.collection.objects.link(handle.empty)
    bpy.context.view_layer.update()
    assert state.stale(obj, bpy.context.scene) == ""
    move_tip(obj)
    assert_close(evaluated(obj), rig.positions(obj, depsgraph()))
