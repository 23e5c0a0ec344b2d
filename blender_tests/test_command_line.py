# SPDX-License-Identifier: GPL-3.0-or-later
"""bake.py as a program: `blender -b ... --python bake.py --`, or a Python that has bpy."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from scans import add_markers, pose
from support import animate, bound_rig, read_pc2

import addon
from addon import bake, cli, native
from addon.fitting.fit import fit_frames

SCRIPT = Path(addon.__file__).parent / "bake.py"


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", [7]),
        ("1-4", [1, 2, 3, 4]),
        ("1,5,9", [1, 5, 9]),
        ("1-9x4", [1, 5, 9]),
        ("9, 1-3,2", [1, 2, 3, 9]),
        ("-2-1", [-2, -1, 0, 1]),
        ("-5--3", [-5, -4, -3]),
    ],
)
def test_frame_lists(text, frames):
    assert cli.parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "4-1", "1-9x0", "1..4", "1,,2", "1-4-7"])
def test_what_is_no_frame_list(text):
    with pytest.raises(ValueError, match="frame|empty"):
        cli.parse_frames(text)


@pytest.fixture
def scene(tmp_path):
    """A saved scene with a rig that moves from frame 1 to 12."""
    obj = bound_rig()
    animate(obj)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 2, 9
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def command(scene: Path, *arguments: object) -> list[str]:
    words = [str(argument) for argument in arguments]
    if not bpy.app.binary_path:
        return [sys.executable, str(SCRIPT), str(scene), *words]
    blender = [bpy.app.binary_path, "-b", "--factory-startup", str(scene)]
    return [*blender, "--python-exit-code", "1", "--python", str(SCRIPT), "--", *words]


def run(scene: Path, *arguments: object, code: int = 0) -> str:
    """What the program says."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    result = subprocess.run(
        command(scene, *arguments),
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        env=environment,
        timeout=120,
    )
    said = result.stdout + result.stderr
    assert result.returncode == code, said
    assert "Traceback" not in said
    return said


def test_the_program_bakes_what_the_function_bakes(scene, tmp_path):
    said = run(scene, "--frames", "3-7", "--output", tmp_path / "out.pc2")
    assert re.search(r"baked 5 frames, [\d.]+ s each, to .*out\.pc2", said)
    assert "bake 100% frame 7" in said
    bake.bake(bpy.data.objects["Tube"], 3, 7, tmp_path / "here.pc2")
    assert (tmp_path / "out.pc2").read_bytes() == (tmp_path / "here.pc2").read_bytes()


def test_the_program_smooths(scene, tmp_path):
    run(scene, "--frames", "3-5", "--smoothing", "1.5", "--output", tmp_path / "out.pc2")
    bake.bake(bpy.data.objects["Tube"], 3, 5, tmp_path / "here.pc2", smoothing=1.5)
    bake.bake(bpy.data.objects["Tube"], 3, 5, tmp_path / "plain.pc2")
    baked = (tmp_path / "out.pc2").read_bytes()
    assert baked == (tmp_path / "here.pc2").read_bytes()
    assert baked != (tmp_path / "plain.pc2").read_bytes()


def test_handles_out_of_sight_are_baked_by_a_program_that_opened_the_file_without_tug(tmp_path):
    obj = bound_rig()
    animate(obj)
    layers = bpy.context.view_layer.layer_collection.children
    layers[obj.tug.collection.name].exclude = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bake.bake(obj, 3, 7, tmp_path / "here.pc2")
    run(tmp_path / "scene.blend", "--frames", "3-7", "--output", tmp_path / "out.pc2")
    assert (tmp_path / "out.pc2").read_bytes() == (tmp_path / "here.pc2").read_bytes()
    frames = read_pc2(tmp_path / "out.pc2")[1]
    assert np.abs(frames[4] - frames[0]).max() > 0.1


def test_without_frames_the_scene_says_which(scene, tmp_path):
    run(scene, "--output", tmp_path / "cache")
    first, frames = read_pc2(tmp_path / "cache" / "Tube.pc2")
    assert (first, len(frames)) == (2, 8)


def test_the_scene_is_saved_only_when_asked(scene, tmp_path):
    before = scene.read_bytes()
    run(scene, "--frames", "1-3", "--output", tmp_path / "out.pc2")
    assert scene.read_bytes() == before
    run(scene, "--frames", "1-3", "--output", tmp_path / "out.pc2", "--save")
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    assert bpy.data.objects["Tube"].modifiers["Tug Bake"].filepath == "//out.pc2"


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("--frames", "1,5", "--output", "a.pc2"), 1, "no gaps: bake all frames from 1 to 5"),
        (("--frames", "5-1", "--output", "a.pc2"), 2, "the range '5-1' is empty"),
        (("--object", "Cube", "--output", "a.pc2"), 1, '"Cube" is no bound rig; there are: Tube'),
        ((), 2, "--output"),
    ],
)
def test_mistakes_are_told(scene, arguments, code, text):
    assert text in run(scene, *arguments, code=code)


def test_a_scene_without_a_rig_is_told(tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty.blend"))
    said = run(tmp_path / "empty.blend", "--output", tmp_path / "out.pc2", code=1)
    assert "the scene has no bound rig" in said


def test_a_missing_library_is_told(scene, tmp_path, monkeypatch):
    monkeypatch.setenv("TUG_LIBRARY", "/nowhere/libtug.so")
    said = run(scene, "--output", tmp_path / "out.pc2", code=1)
    assert "/nowhere/libtug.so" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_cancels_and_leaves_nothing(scene, tmp_path, number):
    folder = tmp_path / "cache"
    process = subprocess.Popen(
        command(scene, "--frames", "1-1000000", "--output", folder / "out.pc2"),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    for line in process.stdout:
        if "frame 1" in line:
            break
    process.send_signal(number)
    said = process.communicate(timeout=60)[0]
    assert process.returncode == 130, said
    assert "cancelled: nothing was written" in said
    assert not list(folder.iterdir())


def test_the_library_is_the_one_of_these_tests():
    assert native.library().tug_abi() == native.ABI


# blender --command tug --------------------------------------------------------------------------


def test_the_command_bakes_and_fits(scene, tmp_path, capsys):
    bake.bake(bpy.data.objects["Tube"], 3, 4, tmp_path / "here.pc2")
    arguments = [str(scene), "--frames", "3-4", "--output", str(tmp_path / "out.pc2")]
    assert cli.command(["bake", *arguments]) == 0
    assert (tmp_path / "out.pc2").read_bytes() == (tmp_path / "here.pc2").read_bytes()
    obj = bpy.data.objects["Tube"]
    markers = add_markers(obj, pose())
    fit_frames(obj, markers, 3, 4, tmp_path / "here.pc2")
    path = ["--frames", "3-4", "--output", str(tmp_path / "fit.pc2")]
    assert cli.command(["fit", *path, "--target", markers.name]) == 0
    assert "fitted 2 frames" in capsys.readouterr().out
    fitted = (tmp_path / "fit.pc2").read_bytes()
    assert fitted == (tmp_path / "here.pc2").read_bytes()
    obj.tug.fit_markers = markers
    assert cli.command(["fit", *path]) == 0
    assert (tmp_path / "fit.pc2").read_bytes() == fitted


def test_what_the_command_cannot_fit_is_told(scene, tmp_path, capsys):
    path = ["--output", str(tmp_path / "fit.pc2")]
    assert cli.command(["fit", *path]) == 1
    assert 'no target was chosen for "Tube"' in capsys.readouterr().err
    assert cli.command(["fit", *path, "--target", "Nobody"]) == 1
    assert 'no object or collection "Nobody"' in capsys.readouterr().err
    bound_rig("Other", "other ")
    assert cli.command(["fit", *path, "--target", "Tip"]) == 1
    assert "there are 2 rigs: name the one to fit with --object" in capsys.readouterr().err
    assert cli.command(["fit", *path, "--object", "Other", "--target", "Tip"]) == 1
    assert '"Tip" is neither a mesh nor a point cloud' in capsys.readouterr().err
    assert not (tmp_path / "fit.pc2").exists()


def test_blender_knows_the_command(scene, tmp_path):
    if not bpy.app.binary_path:
        pytest.skip("not run: a bpy module has no --command")
    script = tmp_path / "register.py"
    checkout = str(SCRIPT.parents[1])
    script.write_text(
        f"import sys; sys.path.insert(0, {checkout!r})\nimport addon\naddon.register()\n"
    )
    words = ["--command", "tug", "bake", str(scene), "--frames", "3-4", "--output"]
    blender = [bpy.app.binary_path, "-b", "--factory-startup", "--python", str(script)]
    result = subprocess.run(
        [*blender, *words, str(tmp_path / "out.pc2")], capture_output=True, text=True, timeout=120
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert (tmp_path / "out.pc2").exists()
