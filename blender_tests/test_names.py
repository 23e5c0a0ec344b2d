# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects, shape keys and handles are renamed."""

import bpy
import pytest
from support import (
    add_key,
    add_rig,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    expected,
    key,
    tube,
)

from addon import handlers
from addon.rigging import inputs, names, rig
from addon.rigging.inputs import RigError


def move():
    bpy.data.objects["Tip"].location.x += 0.2
    bpy.context.view_layer.update()


def check(obj):
    move()
    assert handlers.problem(obj) == ""
    assert_close(evaluated(obj), expected(obj))


def test_an_object():
    obj = bound_rig()
    obj.name = "Worm"
    check(obj)


def test_a_shape_key():
    obj = bound_rig()
    key(obj, "Bend").name = "Bow"
    check(obj)
    assert inputs.bound_examples(obj) == ["Basis", "Bow", "Unbend", "Swell"]
    rig.unbind(obj)
    assert not key(obj, "Bow").mute


def test_several_shape_keys_the_first_and_the_result_among_them():
    obj = bound_rig()
    for name in ("Basis", "Swell", "Tug"):
        key(obj, name).name = f"My {name}"
    check(obj)
    assert inputs.bound_examples(obj) == ["My Basis", "Bend", "Unbend", "My Swell"]
    assert obj.tug.result == "My Tug"
    rig.bind(obj)
    assert "Tug" not in obj.data.shape_keys.key_blocks


def test_a_shape_key_after_another_was_added():
    obj = bound_rig()
    add_key(obj, "Blink", tube()[0])
    move()
    key(obj, "Bend").name = "Bow"
    check(obj)
    assert "Blink" not in inputs.bound_examples(obj)


def test_a_shape_key_that_was_left_out_stays_so():
    obj = add_rig()
    inputs.tick(obj, "Swell", use=False)
    rig.bind(obj)
    key(obj, "Swell").name = "Balloon"
    check(obj)
    assert "Balloon" not in inputs.ticked(obj)


def test_a_shape_key_whose_place_another_took_counts_as_deleted():
    obj = bound_rig()
    obj.shape_key_remove(key(obj, "Swell"))
    key(obj, "Bend").name = "Bow"
    names.follow(obj)
    with pytest.raises(RigError, match='"Bend" was deleted or renamed'):
        rig.solve(obj, depsgraph())


def test_a_handle_takes_its_painted_weights_along():
    obj = bound_rig(dictionary="HANDLES")
    bpy.data.objects["Middle"].name = "Belly"
    check(obj)
    assert "Belly" in obj.vertex_groups
    assert "Belly" in obj.tug.handles
