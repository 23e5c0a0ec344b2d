# SPDX-License-Identifier: GPL-3.0-or-later
"""The ctypes declarations against tug.h, and the search for the library."""

from __future__ import annotations

import ctypes
import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from addon import native

ROOT = Path(__file__).resolve().parents[3]
INCLUDE = ROOT / "native" / "include"
HEADER = re.sub(r"/\*.*?\*/", "", (INCLUDE / "tug.h").read_text(), flags=re.DOTALL)
PROTOTYPES = re.findall(r"^TUG_API (\w[\w *]*?)\b(tug_\w+)\(([^;]*?)\);", HEADER, re.MULTILINE)
STRUCTS = {
    name: struct
    for name, struct in vars(native).items()
    if name.startswith("tug_") and getattr(struct, "_fields_", None)
}
GRID = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def compiled(source: str, target: Path, *flags: str) -> Path:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("not run: there is no C compiler")
    file = target.with_suffix(".c")
    file.write_text(source)
    subprocess.run([compiler, f"-I{INCLUDE}", *flags, "-o", target, file], check=True)
    return target


def fresh_native(folder: Path):
    """native.py as if it lay in `folder`, with nothing loaded yet."""
    copy = shutil.copy(native.__file__, folder)
    spec = importlib.util.spec_from_file_location("fresh_native", copy)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_function_is_bound_in_the_order_of_the_header():
    assert list(native.FUNCTIONS) == [name for _, name, _ in PROTOTYPES]


def test_every_binding_has_the_parameters_of_the_header():
    counts = {name: len(types) - 1 for name, types in native.FUNCTIONS.items()}
    in_header = {n: 0 if text == "void" else text.count(",") + 1 for _, n, text in PROTOTYPES}
    assert counts == in_header


def test_every_status_is_checked():
    returning = {name for result, name, _ in PROTOTYPES if result == "tug_status "}
    assert returning == {n for n, types in native.FUNCTIONS.items() if types[0] is native.Status}


def test_the_constants_are_those_of_the_header():
    assert f"#define TUG_ABI {native.ABI}\n" in HEADER
    errors = dict(re.findall(r"TUG_(ERROR_\w+) = (\d+)", HEADER))
    assert errors == {name: str(getattr(native, name)) for name in errors}


def test_every_struct_is_declared():
    in_header = set(re.findall(r"^} (tug_\w+);", HEADER, flags=re.MULTILINE))
    assert set(STRUCTS) == in_header - {"tug_status", "tug_form"}


def test_the_structs_are_laid_out_as_in_c(tmp_path):
    lines = [
        f'printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), '
        f"sizeof((({name} *)0)->{field}));"
        for name, struct in STRUCTS.items()
        for field, _ in struct._fields_
    ]
    lines += [f'printf("{name} %zu\\n", sizeof({name}));' for name in STRUCTS]
    source = "#include <stdio.h>\n#include <tug.h>\nint main(void) {\n%s\nreturn 0; }\n"
    program = compiled(source % "\n".join(lines), tmp_path / "layout")
    in_c = subprocess.run([program], check=True, capture_output=True, text=True).stdout.split("\n")
    ours = []
    for name, struct in STRUCTS.items():
        for field, _ in struct._fields_:
            place = getattr(struct, field)
            ours.append(f"{name}.{field} {place.offset} {place.size}")
    ours += [f"{name} {ctypes.sizeof(struct)}" for name, struct in STRUCTS.items()]
    assert in_c[:-1] == ours


def test_the_library_says_its_version_and_abi():
    assert native.library().tug_abi() == native.ABI
    assert re.fullmatch(rb"\d+\.\d+\.\d+", native.library().tug_version())


@pytest.mark.parametrize(
    "vertices",
    [GRID.astype(np.float32), GRID[::2], np.asfortranarray(GRID), GRID.ravel(), GRID.tolist()],
    ids=["float32", "strided", "Fortran order", "one dimension", "list"],
)
def test_an_array_of_another_kind_is_refused(vertices):
    out = ctypes.POINTER(native.tug_mesh)()
    with pytest.raises(ctypes.ArgumentError):
        native.library().tug_create_mesh(vertices, 4, 2, FACES, 2, ctypes.byref(out))


def test_an_error_carries_its_code_and_the_words_of_the_library():
    out = ctypes.POINTER(native.tug_mesh)()
    with pytest.raises(native.TugError, match="tug_create_mesh") as caught:
        native.library().tug_create_mesh(GRID, 3, 2, FACES, 2, ctypes.byref(out))
    assert caught.value.code == native.ERROR_ARGUMENT
    assert not out


def test_a_library_named_by_the_environment_comes_first(monkeypatch):
    monkeypatch.setenv("TUG_LIBRARY", "/somewhere/else.so")
    assert native.candidates() == [Path("/somewhere/else.so")]


def test_a_wheel_comes_before_the_package_and_the_build_tree(tmp_path, monkeypatch):
    monkeypatch.delenv("TUG_LIBRARY", raising=False)
    (tmp_path / "wheels" / "tug_native").mkdir(parents=True)
    (tmp_path / "wheels" / "tug_native" / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path / "wheels")
    (tmp_path / "addon").mkdir()
    folders = [
        str(place.parent.relative_to(tmp_path))
        for place in fresh_native(tmp_path / "addon").candidates()
    ]
    assert folders == [
        "wheels/tug_native",
        "addon/lib",
        "build/release",
        "build/debug",
    ]


def test_a_missing_library_is_an_error_with_every_path_tried(tmp_path, monkeypatch):
    monkeypatch.delenv("TUG_LIBRARY", raising=False)
    fresh = fresh_native(tmp_path)
    with pytest.raises(fresh.LibraryError, match="not found") as caught:
        fresh.library()
    assert all(str(place) in str(caught.value) for place in fresh.candidates())


def test_a_library_of_another_abi_is_refused(tmp_path, monkeypatch):
    source = "#include <tug.h>\nint32_t tug_abi(void) { return TUG_ABI + 1; }\n"
    library = compiled(source, tmp_path / "other.so", "-shared", "-fPIC")
    monkeypatch.setenv("TUG_LIBRARY", str(library))
    fresh = fresh_native(tmp_path)
    with pytest.raises(fresh.LibraryError, match=f"ABI {native.ABI + 1}.*needs {native.ABI}"):
        fresh.library()


def test_a_file_that_is_no_library_is_refused(tmp_path, monkeypatch):
    library = tmp_path / "libtug.so"
    library.write_text("not a library")
    monkeypatch.setenv("TUG_LIBRARY", str(library))
    fresh = fresh_native(tmp_path)
    with pytest.raises(fresh.LibraryError, match=re.escape(str(library))):
        fresh.library()


def test_a_library_of_something_else_is_refused(tmp_path, monkeypatch):
    library = compiled("int answer = 42;\n", tmp_path / "other.so", "-shared", "-fPIC")
    monkeypatch.setenv("TUG_LIBRARY", str(library))
    fresh = fresh_native(tmp_path)
    with pytest.raises(fresh.LibraryError, match="tug_abi"):
        fresh.library()


def test_importing_the_package_loads_neither_blender_nor_the_library():
    code = (
        "import sys, addon, addon.solver; "
        "assert 'bpy' not in sys.modules; assert not addon.native.library.cache_info().currsize"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)
