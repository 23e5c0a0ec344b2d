# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes: exact, the same in pieces, and all or nothing."""

import errno
import resource
import signal

import bpy
import numpy as np
import pytest
from support import (
    LENGTH,
    add_rig,
    animate,
    assert_close,
    bound_rig,
    depsgraph,
    evaluated,
    expected,
    key,
    pull_to,
    read_pc2,
    state,
    tube,
)

from addon import bake
from addon.rigging import rig, shape_keys
from addon.rigging.inputs import RigError


@pytest.fixture
def obj():
    obj = bound_rig()
    animate(obj)
    bpy.context.scene.frame_set(4)
    return obj


def add_swelling_rig(last_frame):
    """A bound rig on which a key that is no example comes in from frame 1 on."""
    obj = add_rig()
    shape = obj.tug.shapes.add()
    shape.name, shape.use = "Swell", False
    rig.bind(obj)
    swell = key(obj, "Swell")
    for frame, value in ((1, 0.0), (last_frame, 0.9)):
        swell.value = value
        swell.keyframe_insert("value", frame=frame)
    return obj


def test_the_modifier_shows_what_the_solver_found_at_every_frame(obj, tmp_path):
    poses = {}
    for frame in range(1, 13):
        bpy.context.scene.frame_set(frame)
        poses[frame] = expected(obj).astype(np.float32)
    bake.bake(obj, 1, 12, tmp_path / "tube.pc2")
    key(obj, "Tug").value = 0.0  # so that only the modifier can be what is seen
    for frame, pose in poses.items():
        bpy.context.scene.frame_set(frame)
        np.testing.assert_array_equal(evaluated(obj), pose)


def test_the_first_and_last_frame_stay_before_and_after(obj, tmp_path):
    bake.bake(obj, 3, 9, tmp_path / "tube.pc2")
    _, frames = read_pc2(tmp_path / "tube.pc2")
    for frame, index in ((1, 0), (3, 0), (9, -1), (12, -1)):
        bpy.context.scene.frame_set(frame)
        np.testing.assert_array_equal(evaluated(obj), frames[index])


def test_a_part_equals_the_same_frames_of_the_whole(obj, tmp_path):
    bake.bake(obj, 1, 12, tmp_path / "whole.pc2")
    bake.bake(obj, 5, 8, tmp_path / "part.pc2")
    first, part = read_pc2(tmp_path / "part.pc2")
    _, whole = read_pc2(tmp_path / "whole.pc2")
    assert first == 5
    np.testing.assert_array_equal(part, whole[4:8])


def jump(obj):
    """Handles on Unbend up to frame 6 and on Bend from frame 7 on."""
    for frame, name in ((1, "Unbend"), (6, "Unbend"), (7, "Bend"), (12, "Bend")):
        pull_to(obj, name)
        for handle in obj.tug.handles:
            handle.empty.keyframe_insert("location", frame=frame)


def test_a_smooth_part_equals_the_same_frames_of_the_whole(obj, tmp_path):
    bake.bake(obj, 1, 12, tmp_path / "whole.pc2", smoothing=1.5)
    bake.bake(obj, 1, 12, tmp_path / "plain.pc2")
    _, whole = read_pc2(tmp_path / "whole.pc2")
    _, plain = read_pc2(tmp_path / "plain.pc2")
    assert np.abs(whole - plain).max() > 1e-4
    for first, last in ((1, 1), (2, 7), (8, 12)):
        bake.bake(obj, first, last, tmp_path / "part.pc2", smoothing=1.5)
        start, part = read_pc2(tmp_path / "part.pc2")
        assert start == first
        np.testing.assert_array_equal(part, whole[first - 1 : last])


def test_smoothing_softens_a_jump_and_keeps_the_handles(obj, tmp_path):
    jump(obj)
    bake.bake(obj, 1, 12, tmp_path / "smooth.pc2", smoothing=2)
    bake.bake(obj, 1, 12, tmp_path / "plain.pc2")
    _, smooth = read_pc2(tmp_path / "smooth.pc2")
    _, plain = read_pc2(tmp_path / "plain.pc2")
    handles = [handle.vertex for handle in obj.tug.handles]
    assert_close(smooth[:, handles], plain[:, handles])
    steps = [np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2)) for frames in (smooth, plain)]
    assert steps[0][5] < steps[1][5]
    assert steps[0][4] > 10 * steps[1][4]  # some of it has moved to the frames before


@pytest.mark.parametrize("form", ["AVERAGE", "MINIMAL", "CLOSEST"])
def test_a_smooth_bake_keeps_the_size_that_was_found(obj, tmp_path, form):
    obj.tug.form, obj.tug.follow_size = form, True
    for handle in obj.tug.handles:
        handle.empty.animation_data_clear()
        handle.empty.location = 1.4 * key(obj, "Bend").points[handle.vertex].co
    bake.bake(obj, 1, 2, tmp_path / "plain.pc2")
    bake.bake(obj, 1, 2, tmp_path / "smooth.pc2", smoothing=1)
    plain, smooth = (read_pc2(tmp_path / f"{name}.pc2")[1] for name in ("plain", "smooth"))
    np.testing.assert_allclose(smooth, plain, atol=2e-6 * LENGTH)


def test_smoothing_shows_what_is_added_on_top_of_its_own_frame(tmp_path):
    obj = add_swelling_rig(last_frame=2)
    swell = key(obj, "Swell")
    bake.bake(obj, 1, 2, tmp_path / "tube.pc2", smoothing=1)
    _, frames = read_pc2(tmp_path / "tube.pc2")
    added = shape_keys.coordinates(swell) - shape_keys.coordinates(key(obj, "Basis"))
    assert_close(frames[1] - frames[0], 0.9 * added)


@pytest.mark.parametrize("smoothing", [-1, np.nan, np.inf])
def test_smoothing_that_cannot_be_is_an_error(obj, tmp_path, smoothing):
    with pytest.raises(RigError, match="smoothing is .* it must be 0 or more"):
        bake.bake(obj, 1, 2, tmp_path / "tube.pc2", smoothing=smoothing)
    assert not list(tmp_path.iterdir())


def test_a_bake_in_a_new_session_is_the_same(obj, tmp_path):
    bake.bake(obj, 1, 12, tmp_path / "here.pc2")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "rig.blend"))
    bake.bake(bpy.data.objects["Tube"], 1, 12, tmp_path / "there.pc2")
    assert (tmp_path / "here.pc2").read_bytes() == (tmp_path / "there.pc2").read_bytes()


def test_keys_that_add_on_top_are_baked(tmp_path):
    obj = add_swelling_rig(last_frame=10)
    bake.bake(obj, 1, 10, tmp_path / "tube.pc2")
    _, frames = read_pc2(tmp_path / "tube.pc2")
    obj.modifiers["Tug Bake"].show_viewport = False
    for frame in (1, 5, 10):
        bpy.context.scene.frame_set(frame)
        assert_close(frames[frame - 1], evaluated(obj))
    assert np.abs(frames[9] - frames[0]).max() > 0.3


def test_a_bake_leaves_the_frame_and_the_pose_as_they_were(obj, tmp_path):
    before = evaluated(obj)
    bake.bake(obj, 1, 12, tmp_path / "tube.pc2")
    assert bpy.context.scene.frame_current == 4
    assert_close(evaluated(obj), before)
    assert_close(expected(obj), before)


def test_the_modifier_comes_first_and_only_once(obj, tmp_path):
    obj.modifiers.new("Subdivision", "SUBSURF")
    for path in ("one.pc2", "two.pc2"):
        bake.bake(obj, 1, 3, tmp_path / path)
    assert [modifier.name for modifier in obj.modifiers] == ["Tug Bake", "Subdivision"]
    assert obj.modifiers[0].filepath.endswith("two.pc2")
    assert len(evaluated(obj)) > len(tube()[0])


def test_the_path_is_relative_to_a_saved_file(obj, tmp_path):
    with pytest.raises(RigError, match="save it first"):
        bake.bake(obj, 1, 3, "//cache/tube.pc2")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    path = bake.bake(obj, 1, 3, "//cache/tube.pc2")
    assert path == tmp_path / "cache" / "tube.pc2"
    assert path.exists()
    assert obj.modifiers["Tug Bake"].filepath == "//cache/tube.pc2"


def test_several_rigs_are_baked_in_one_pass(tmp_path):
    rigs = [bound_rig("First", "first "), bound_rig("Second", "second ")]
    for obj in rigs:
        animate(obj)
    bake.bake_rigs({obj: tmp_path / f"{obj.name}.pc2" for obj in rigs}, 1, 6)
    first, second = (read_pc2(tmp_path / f"{obj.name}.pc2")[1] for obj in rigs)
    np.testing.assert_array_equal(first, second)
    assert np.abs(first[5] - first[0]).max() > 0.1


def test_two_rigs_are_not_baked_to_one_file(tmp_path):
    rigs = [bound_rig("First", "first "), bound_rig("Second", "second ")]
    with pytest.raises(RigError, match="two rigs would be baked to the same file"):
        bake.bake_rigs(dict.fromkeys(rigs, tmp_path / "tube.pc2"), 1, 6)
    assert not list(tmp_path.iterdir())


def test_progress_goes_from_frame_to_frame(obj, tmp_path):
    seen = []
    bake.bake(obj, 1, 4, tmp_path / "tube.pc2", lambda *step: seen.append(step))
    assert seen == [("frame 1", 0.25), ("frame 2", 0.5), ("frame 3", 0.75), ("frame 4", 1.0)]


def test_weights_painted_since_are_baked(obj, tmp_path):
    obj.tug.dictionary = "HANDLES"
    rig.bind(obj)
    bake.bake(obj, 6, 6, tmp_path / "before.pc2")
    obj.vertex_groups["Middle"].add(range(60, 100), 0.1, "REPLACE")
    bake.bake(obj, 6, 6, tmp_path / "after.pc2")
    assert (tmp_path / "before.pc2").read_bytes() != (tmp_path / "after.pc2").read_bytes()
    rig.bind(obj)
    bpy.context.scene.frame_set(6)
    pose = rig.positions(obj, depsgraph()).astype(np.float32)
    np.testing.assert_array_equal(read_pc2(tmp_path / "after.pc2")[1][0], pose)


# All or nothing --------------------------------------------------------------------------------


def stop_at_frame_three(stage, fraction):
    if stage == "frame 3":
        raise KeyboardInterrupt


@pytest.mark.parametrize("older", [None, b"older"])
def test_a_cancelled_bake_leaves_nothing_behind(obj, tmp_path, older):
    path = tmp_path / "tube.pc2"
    if older:
        path.write_bytes(older)
    before = state(obj)
    with pytest.raises(KeyboardInterrupt):
        bake.bake(obj, 1, 12, path, stop_at_frame_three)
    assert state(obj) == before
    assert [file.read_bytes() for file in tmp_path.iterdir()] == ([older] if older else [])


@pytest.fixture
def small_disk():
    """No file may grow beyond 4 kB: two frames of the tube."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    signal.signal(signal.SIGXFSZ, ignored or signal.SIG_DFL)


def test_a_full_disk_is_told_with_what_is_needed(obj, tmp_path, small_disk):
    before = state(obj)
    with pytest.raises(RigError, match=r"no space left to bake to .*tube.pc2: 0\.1 MB"):
        bake.bake(obj, 1, 48, tmp_path / "tube.pc2")
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


def test_a_disk_that_is_full_only_at_the_end_is_told_too(obj, tmp_path, monkeypatch):
    def full(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    before = state(obj)
    with pytest.raises(RigError, match="no space left"):
        bake.bake(obj, 1, 3, tmp_path / "tube.pc2")
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_told(obj, tmp_path):
    (tmp_path / "file").touch()
    before = state(obj)
    with pytest.raises(RigError, match="cannot bake to .*choose a folder you may write to"):
        bake.bake(obj, 1, 3, tmp_path / "file" / "tube.pc2")
    assert state(obj) == before


def test_a_folder_without_permission_is_told(obj, tmp_path, monkeypatch):
    def refused(*_arguments, **_options):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", refused)  # a real one would not stop root
    before = state(obj)
    with pytest.raises(RigError, match="Permission denied; choose a folder you may write to"):
        bake.bake(obj, 1, 3, tmp_path / "tube.pc2")
    assert state(obj) == before


def test_a_stale_rig_is_not_baked(obj, tmp_path):
    bpy.data.objects.remove(bpy.data.objects["Tip"])
    before = state(obj)
    with pytest.raises(RigError, match='"Tip" was deleted'):
        bake.bake(obj, 1, 3, tmp_path / "tube.pc2")
    assert state(obj) == before
    assert not list(tmp_path.iterdir())


def test_an_empty_range_is_an_error(obj, tmp_path):
    with pytest.raises(RigError, match="nothing to bake from frame 5 to 4"):
        bake.bake(obj, 5, 4, tmp_path / "tube.pc2")
