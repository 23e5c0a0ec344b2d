# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlays show: which examples and which parts, in colours and as bars."""

import bpy
import numpy as np
import pytest
from support import HANDLES, bound_rig, key, pull_to, solved

from addon.rigging import blends, live, shape_keys
from addon.ui import drawing
from addon.ui.overlay_colours import colours
from addon.ui.overlay_drag import LEAST, ROWS, weights_shown


def choose(wanted):
    bpy.context.window_manager.tug_colours = wanted


@pytest.fixture(autouse=True)
def no_colours():
    yield
    choose("NONE")


def store(obj):
    bpy.context.view_layer.objects.active = obj
    return bpy.ops.tug.store_colours()


def stored(obj, name):
    attribute = obj.data.color_attributes[name]
    flat = np.empty(4 * len(obj.data.vertices), np.float32)
    attribute.data.foreach_get("color", flat)
    return flat.reshape(-1, 4)


def test_around_a_handle_is_the_example_that_the_handles_are_pulled_to():
    obj = bound_rig()
    pull_to(obj, "Bend")
    solved(obj)
    for name in HANDLES:
        names, weights = blends.around(obj, bpy.data.objects[name])
        assert names == ["Basis", "Bend", "Unbend", "Swell"]
        assert weights.sum() == pytest.approx(1, abs=1e-6)
        assert weights[1] > 0.9


def test_before_the_first_pose_nothing_is_known():
    obj = bound_rig()
    other = bpy.data.objects["Tip"].copy()
    assert blends.around(obj, other)[0] == []
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = bound_rig()

    live.forget_all()
    assert blends.around(obj, bpy.data.objects["Tip"])[0] == []
    assert colours(obj, "EXAMPLES") is None
    assert colours(obj, "PARTS") is None


def test_colours_of_examples_are_their_mixture():
    obj = bound_rig()
    pull_to(obj, "Swell")
    solved(obj)
    palette = drawing.shape_colours(4)
    shown = colours(obj, "EXAMPLES")
    assert shown.shape == (len(obj.data.vertices), 3)
    assert np.abs(shown - palette[3]).max() < 0.1


def test_colours_of_parts_tell_them_apart():
    obj = bound_rig()
    shown = colours(obj, "PARTS")
    assert len(np.unique(shown.round(4), axis=0)) >= blends.group_count(obj) > 1
    assert (shown >= 0).all() and (shown <= 1).all()


def test_colours_are_kept_only_where_asked_for():
    obj = bound_rig()
    choose("PARTS")
    assert len(obj.data.color_attributes) == 0
    assert store(obj) == {"FINISHED"}
    np.testing.assert_allclose(stored(obj, "Tug Parts")[:, :3], colours(obj, "PARTS"), atol=1e-6)
    assert (stored(obj, "Tug Parts")[:, 3] == 1).all()
    choose("EXAMPLES")
    pull_to(obj, "Bend")
    store(obj)
    store(obj)  # again into the same
    assert {attribute.name for attribute in obj.data.color_attributes} == {
        "Tug Examples",
        "Tug Parts",
    }
    np.testing.assert_allclose(
        stored(obj, "Tug Examples")[:, :3], colours(obj, "EXAMPLES"), atol=1e-6
    )


def test_colours_are_kept_without_a_change_of_the_pose():
    obj = bound_rig()
    painted = shape_keys.coordinates(key(obj, "Tug")) + np.float32(0.1)
    shape_keys.write(obj.data, key(obj, "Tug"), painted)
    choose("EXAMPLES")
    store(obj)
    np.testing.assert_array_equal(shape_keys.coordinates(key(obj, "Tug")), painted)


def test_an_attribute_of_the_artist_is_left_alone():
    obj = bound_rig()
    obj.data.color_attributes.new("Tug Parts", "BYTE_COLOR", "CORNER")
    choose("PARTS")
    with pytest.raises(RuntimeError, match='"Tug Parts" of "Tube" is of another kind'):
        store(obj)
    assert obj.data.color_attributes["Tug Parts"].domain == "CORNER"


def test_the_largest_weights_are_shown_in_the_order_of_the_keys():
    names = [f"Key {number}" for number in range(20)]
    weights = np.zeros(20)
    weights[[3, 7, 12]] = 0.2, 0.5, 0.3 - LEAST / 2
    weights[15] = LEAST / 2
    rows = weights_shown(names, weights)
    assert [name for name, _, _ in rows] == ["Key 3", "Key 7", "Key 12"]
    assert len(weights_shown(names, np.full(20, 0.05))) == ROWS
    assert weights_shown([], np.zeros(0)) == []


@pytest.mark.parametrize("count", [1, 2, 7, 40])
def test_colours_of_shapes_differ(count):
    found = drawing.shape_colours(count)
    assert found.shape == (count, 3)
    assert len(np.unique(found.round(3), axis=0)) == count
