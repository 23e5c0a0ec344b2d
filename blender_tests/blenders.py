# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blenders that Tug is tested in: how each runs a Python script, and where it comes from.

Whatever is fetched goes to the cache once, under a temporary name until it is complete.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tug"
CHECKOUT = Path(__file__).resolve().parent.parent
OLDEST = (4, 2)
SCREEN = "1024x768"  # pixels of a display with a Blender in it


class UnavailableError(Exception):
    """A Blender that cannot be had here, with the reason."""


class Blender(Protocol):
    """`name` is for people; `provide` fetches what is missing or raises UnavailableError."""

    @property
    def name(self) -> str: ...

    def provide(self) -> None: ...

    def command(self, script: Path, *arguments: str) -> list[str]:
        """The command that runs `script`; it exits non-zero where the script raises.

        The script finds its arguments by `arguments()`.
        """
        ...


class Program(Blender, Protocol):
    """A Blender that is a program, not a Python module: `program()` starts it, followed by its own
    options."""

    def program(self) -> list[str]: ...


def arguments(argv: list[str]) -> list[str]:
    """What `Blender.command` was given, from the sys.argv of the script."""
    return argv[argv.index("--") + 1 :] if "--" in argv else argv[1:]


def background(script: Path, arguments: tuple[str, ...]) -> list[str]:
    # The exit code holds only for what stands after it.
    options = ["--background", "--factory-startup", "-noaudio", "--python-exit-code", "1"]
    return [*options, "--python", str(script), "--", *arguments]


@dataclass(frozen=True)
class Installed:
    """A Blender of this machine."""

    executable: str

    @property
    def name(self) -> str:
        return f"Blender at {self.executable}"

    def provide(self) -> None:
        pass

    def program(self) -> list[str]:
        return [self.executable]

    def command(self, script: Path, *arguments: str) -> list[str]:
        return [*self.program(), *background(script, arguments)]


@dataclass(frozen=True)
class Wheel:
    """Blender as a Python module, in a virtual environment of its own."""

    version: str
    numpy: str  # the one that Blender itself ships

    @property
    def name(self) -> str:
        return f"Blender {self.version} (bpy)"

    @property
    def folder(self) -> Path:
        return CACHE / f"bpy-{self.version}"

    def provide(self) -> None:
        if not self.folder.exists():
            make_in_cache(self.folder, self._install)

    def _install(self, folder: Path) -> None:
        make_environment(
            folder, find_python(), f"bpy=={self.version}", f"numpy=={self.numpy}", "pytest==9.2.0"
        )

    def command(self, script: Path, *arguments: str) -> list[str]:
        return [str(self.folder / "bin" / "python"), str(script), *arguments]


@dataclass(frozen=True)
class Root:
    """Blender as a Debian suite packages it, unpacked with all it needs into a folder.

    It sees the checkout and the test data, both read-only, and may write to build/.
    """

    suite: str
    version: tuple[int, int]

    @property
    def name(self) -> str:
        return f"Blender {dotted(self.version)} (Debian {self.suite})"

    @property
    def folder(self) -> Path:
        return CACHE / f"debian-{self.suite}"

    def provide(self) -> None:
        for tool in ("mmdebstrap", "bwrap"):
            if shutil.which(tool) is None:
                raise UnavailableError(f"there is no {tool}")
        if not os.path.lexists(self.folder / "usr/bin/xvfb-run"):
            shutil.rmtree(self.folder, ignore_errors=True)  # one without what windows need
            make_in_cache(self.folder, self._unpack)
        found = version_of(*self._sandbox(), "blender")
        if found != self.version:
            raise UnavailableError(f"it has Blender {dotted(found)}")

    def _unpack(self, folder: Path) -> None:
        packages = (
            "blender,python3-numpy,python3-pytest,python3-cattr,python3-requests,python3-zstandard,"
            "libegl1,libgl1-mesa-dri,xvfb,xauth,xdotool,imagemagick"
        )
        archive = folder / "root.tar"
        run(
            [
                "mmdebstrap",
                "--variant=apt",
                "--aptopt=Acquire::Languages none",
                "--aptopt=Acquire::Check-Valid-Until false",  # a mirror may lag behind
                f"--include={packages}",
                self.suite,
                str(archive),
                *debian_mirror(),
            ]
        )
        run(["tar", "--exclude=./dev/*", "-C", str(folder), "-xf", str(archive)])
        archive.unlink()
        for downloaded in ("var/cache/apt/archives", "var/lib/apt/lists"):
            shutil.rmtree(folder / downloaded)

    def _sandbox(self) -> list[str]:
        build = CHECKOUT / "build"
        build.mkdir(exist_ok=True)
        command = ["bwrap", "--unshare-all", "--die-with-parent"]
        for part in ("usr", "etc"):
            command += ["--ro-bind", str(self.folder / part), f"/{part}"]
        for link in ("bin", "sbin", "lib", "lib64"):
            command += ["--symlink", f"usr/{link}", f"/{link}"]
        command += ["--proc", "/proc", "--dev", "/dev", "--tmpfs", "/tmp", "--tmpfs", "/run"]
        for seen in (CHECKOUT, data_folder()):
            command += ["--ro-bind-try", str(seen), str(seen)]
        command += ["--bind", str(build), str(build), "--chdir", str(CHECKOUT)]
        variables = {
            "HOME": "/tmp",
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "MESA_SHADER_CACHE_DIR": str(build / f"shaders-{self.suite}"),  # saves 10 s
        }
        for name, value in variables.items():
            command += ["--setenv", name, value]
        return command

    def program(self) -> list[str]:
        return [*self._sandbox(), "blender"]

    def command(self, script: Path, *arguments: str) -> list[str]:
        return [*self.program(), *background(script, arguments)]

    def in_window(self, script: Path, *arguments: str) -> list[str]:
        """The command that runs `script` in a window, of Blender as it comes."""
        display = ["xvfb-run", "-a", "-s", f"-screen 0 {SCREEN}x24 +extension GLX +render -noreset"]
        options = ["--factory-startup", "-noaudio", "--python-exit-code", "1"]
        script_last = ["--python", str(script), "--", *arguments]
        return [*self._sandbox(), *display, "blender", *options, *script_last]

    def window_command(self, extension: Path, script: Path, *arguments: str) -> list[str]:
        """The command that installs the zip of an extension and runs `script` in a window."""
        start = CHECKOUT / "blender_tests" / "window" / "start.sh"
        return [*self._sandbox(), str(start), str(extension), SCREEN, str(script), *arguments]


TESTED: tuple[Blender, ...] = (
    Wheel("4.2.23", numpy="1.26.4"),
    Root("trixie", (4, 3)),
    Wheel("4.5.15", numpy="1.26.4"),
    Wheel("5.0.1", numpy="1.26.4"),
    Root("sid", (5, 2)),
)


def demo_blender() -> Blender:
    """$BLENDER, else a `blender` on PATH that is new enough, else the newest wheel."""
    return installed() or [blender for blender in TESTED if isinstance(blender, Wheel)][-1]


def packaging_blender() -> Program:
    """$BLENDER, else a `blender` on PATH that is new enough, else the newest of Debian's."""
    return installed() or [blender for blender in TESTED if isinstance(blender, Root)][-1]


def installed() -> Installed | None:
    if executable := os.environ.get("BLENDER"):
        return Installed(executable)
    executable = shutil.which("blender")
    if executable and version_of(executable) >= OLDEST:
        return Installed(executable)
    return None


def version_of(*command: str) -> tuple[int, int]:
    found = re.search(r"Blender (\d+)\.(\d+)", run([*command, "--version"]))
    if found is None:
        raise UnavailableError(f"{command[-1]} does not tell its version")
    return int(found[1]), int(found[2])


def dotted(version: tuple[int, int]) -> str:
    return ".".join(map(str, version))


def data_folder() -> Path:
    """Meshes for further tests; may be absent."""
    return Path(os.environ.get("TUG_DATA") or CHECKOUT.parent / "shared" / "data").resolve()


def make_in_cache(folder: Path, fill: Callable[[Path], object]) -> None:
    """`fill` an empty folder in the cache, which becomes `folder` when it is complete."""
    CACHE.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f"{folder.name}.", dir=CACHE))
    try:
        fill(temporary)
        temporary.chmod(0o755)
        temporary.rename(folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def make_environment(folder: Path, python: str, *requirements: str) -> None:
    """A virtual environment. It may be renamed: call `bin/python -m pip`, never `bin/pip`."""
    run([python, "-m", "venv", str(folder)])
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "--quiet", "--no-compile"]
    run([*pip, "--disable-pip-version-check", *requirements])


def provide_environment(name: str, requirements: Path) -> str:
    """The Python of a virtual environment in the cache that has what the file `requirements` lists;
    made where it is missing, and anew where the file has changed."""
    folder = CACHE / f"{name}-{hashlib.sha256(requirements.read_bytes()).hexdigest()[:12]}"
    if not folder.exists():
        make_in_cache(
            folder, lambda empty: make_environment(empty, find_python(), "-r", str(requirements))
        )
    return str(folder / "bin" / "python")


def provide_tools() -> str:
    """The Python with ruff and what the Python tests import."""
    return provide_environment(
        "tools", CHECKOUT / "native" / "tests" / "python" / "requirements.txt"
    )


def find_python() -> str:
    python = shutil.which("python3.11", path=f"/usr/bin:{os.environ['PATH']}")
    if python is None:
        raise UnavailableError("there is no Python 3.11, the only one that bpy is built for")
    return python


def debian_mirror() -> list[str]:
    """The one this machine installs from; none, so that mmdebstrap takes its own, if not told."""
    folder = Path("/etc/apt")
    files = [folder / "sources.list", *sorted(folder.glob("sources.list.d/*"))]
    text = "\n".join(file.read_text() for file in files if file.exists())
    entry = r"^(?:URIs:|deb(?:\s+\[.*\])?)\s+(\S+/debian/?)(?:\s|$)"
    return re.findall(entry, text, re.MULTILINE)[:1]


def run(command: list[str]) -> str:
    """The output of a command; UnavailableError with the first error it named where it fails."""
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if result.returncode != 0:
        said = (result.stderr or result.stdout).strip().splitlines() or ["no message"]
        reason = next((line for line in said if line.startswith(("E: ", "ERROR: "))), said[-1])
        raise UnavailableError(f"{Path(command[0]).name}: {reason}")
    return result.stdout
