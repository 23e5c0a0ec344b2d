# SPDX-License-Identifier: GPL-3.0-or-later
"""Enabling and disabling the add-on."""

import subprocess
import sys
from pathlib import Path

import bpy
import pytest
from support import add_rig, bound_rig

import addon
from addon import handlers, native
from addon.rigging import live, rig

MANIFEST = Path(addon.__file__).parent / "blender_manifest.toml"


@pytest.fixture
def unregistered():
    addon.unregister()
    yield
    if not hasattr(bpy.types.Object, "tug"):
        addon.register()


def installed() -> dict[str, int]:
    """How often each of our handlers is in Blender's lists."""
    return {
        name: getattr(bpy.app.handlers, name).count(function)
        for name, function in handlers.HANDLERS
    }


def test_registering_is_undone_by_unregistering(unregistered):
    assert not hasattr(bpy.types.Object, "tug")
    assert set(installed().values()) == {0}
    for _ in range(2):
        addon.register()
        assert set(installed().values()) == {1}
        addon.unregister()
        assert set(installed().values()) == {0}


def test_a_rig_outlives_disabling_the_add_on():
    obj = bound_rig()
    addon.unregister()
    bpy.context.scene.frame_set(2)
    addon.register()
    assert obj.tug.bound
    rig.solve(obj, bpy.context.evaluated_depsgraph_get())


def test_the_settings_start_as_those_of_the_library():
    options = native.tug_solver_options()
    native.library().tug_default_solver_options(options)
    obj = bpy.data.objects.new("Any", None)
    assert live.solver_options(obj) == {
        "form": options.form,
        "lambda_": getattr(options, "lambda"),
        "prior": options.prior,
        "single_blend": options.single_blend,
        "squared": options.squared,
        "scale": options.scale,
    }


def test_without_the_library_the_add_on_registers_and_a_bind_says_what_is_missing(monkeypatch):
    native.library.cache_clear()
    monkeypatch.setenv("TUG_LIBRARY", "/nowhere/libtug.so")
    try:
        addon.unregister()
        addon.register()
        obj = add_rig()
        with pytest.raises(native.LibraryError, match="/nowhere/libtug.so"):
            rig.bind(obj)
        assert not obj.tug.bound
        assert [block.name for block in obj.data.shape_keys.key_blocks][-1] == "Swell"
    finally:
        native.library.cache_clear()


def test_the_manifest_passes_blenders_own_check():
    if not bpy.app.binary_path:
        pytest.skip("not run: a bpy module has no --command")
    command = [bpy.app.binary_path, "--command", "extension", "validate", MANIFEST.parent]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_the_manifest_keeps_the_rules_of_the_platform():
    tomllib = pytest.importorskip("tomllib")
    manifest = tomllib.loads(MANIFEST.read_text())
    assert manifest["id"] == "tug"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    texts = [manifest["tagline"], *manifest["permissions"].values()]
    assert all(len(text) <= 64 and text[-1].isalnum() for text in texts)


def test_the_package_imports_without_blender():
    code = "import sys; sys.modules['bpy'] = None; import addon.solver"
    python = sys.executable if not bpy.app.binary_path else sys.exec_prefix + "/bin/python3"
    if not Path(python).exists():
        pytest.skip("not run: there is no plain Python beside this Blender")
    subprocess.run([python, "-c", code], check=True, cwd=Path(addon.__file__).parents[1])


def test_blender_as_a_module_ends_well_after_files_were_opened():
    if bpy.app.binary_path:
        pytest.skip("not run: this Blender is no module")
    code = """
import bpy, addon
addon.register()
for _ in range(3):
    bpy.ops.wm.read_factory_settings(use_empty=True)
"""
    root = Path(addon.__file__).parents[1]
    subprocess.run([sys.executable, "-c", code], check=True, cwd=root, timeout=60)
