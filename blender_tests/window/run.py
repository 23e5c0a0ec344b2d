# SPDX-License-Identifier: GPL-3.0-or-later
"""run.py REPORT [WORD]: runs the tests of this folder, or those with WORD in their name, in a
window of a Blender in which the extension is installed. The JUnit report goes to REPORT, pictures
beside it.

A test is a generator function `test_*(ui)` in a file `test_*.py`. Each `yield` lets Blender handle
the events that were queued and draw; a yielded number waits that many seconds more. Every test
starts in Blender's own start-up file without its objects, and fails if an exception is printed: one
in a handler or in a modal operator goes no further.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import shutil
import sys
import time
import traceback
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
CHECKOUT = FOLDER.parent.parent
# The checkout may be read-only.
sys.dont_write_bytecode = True
sys.path[:0] = [str(FOLDER), str(FOLDER.parent), str(CHECKOUT)]

import bpy  # noqa: E402
from blenders import arguments  # noqa: E402
from console import Console  # noqa: E402
from window import Window  # noqa: E402

Test = Callable[[Window], Iterator[float | None]]
SECONDS_ALLOWED = 120.0  # for a test without `seconds`; noticed between its steps only
EMPTY_ROUNDS = 1  # of the timer after each step, for handlers to run before a test looks


def main() -> None:
    report, word = Path(arguments(sys.argv)[0]), "".join(arguments(sys.argv)[1:])
    set_preferences()
    use_installed("bl_ext.user_default.tug")
    console = Console(report.with_suffix(".console"))
    session = Session(tests(word), Report(report), console)
    bpy.app.timers.register(session.step, first_interval=0.3, persistent=True)


def use_installed(name: str) -> None:
    """Let `addon` and its modules mean the installed extension, here and in the sample scenes."""
    installed = importlib.import_module(name)
    modules = pkgutil.walk_packages(installed.__path__, f"{name}.")
    for found in (name, *(module.name for module in modules)):
        sys.modules["addon" + found.removeprefix(name)] = importlib.import_module(found)


def tests(word: str) -> list[tuple[str, Test]]:
    found = []
    for file in sorted(FOLDER.glob("test_*.py")):
        for name, member in vars(importlib.import_module(file.stem)).items():
            if name.startswith("test_") and word in f"{file.stem}.{name}":
                found.append((f"{file.stem}.{name}", member))
    return found


def set_preferences() -> None:
    """No splash, prompts, auto-saves or animated views; anti-aliasing would draw the window eight
    times for every event. The sidebar stands beside what is framed, not over it."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.smooth_view = 0
    preferences.view.use_save_prompt = False
    preferences.filepaths.use_auto_save_temporary_files = False
    preferences.system.viewport_aa = "OFF"
    preferences.system.use_region_overlap = False


class Session:
    """Steps one test after the other from a timer of Blender."""

    def __init__(self, tests: list[tuple[str, Test]], report: Report, console: Console) -> None:
        self.waiting = tests
        self.report, self.console = report, console
        self.steps = self.play()
        self.rounds_left = 0

    def step(self) -> float:
        if self.rounds_left > 0:
            self.rounds_left -= 1
            return 0.0
        self.rounds_left = EMPTY_ROUNDS
        return next(self.steps) or 0.0

    def play(self) -> Iterator[float | None]:
        for name, test in self.waiting:
            self.report.start(name)
            self.console.mark()
            ui = None
            try:
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                yield 0.1
                ui = Window(self.report.path.parent, self.console)
                yield from limited(test(ui), getattr(test, "seconds", SECONDS_ALLOWED))
                self.console.check()
            except BaseException:  # a timer would print it and stop
                self.report.fail(traceback.format_exc())
                if ui is not None:
                    ui.picture(f"{self.report.path.stem}-{name}")
            self.report.finish()
        self.console.close()
        shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
        # Blender would write a quit.blend and exit with 0.
        os._exit(self.report.failed)


def limited(steps: Iterator[float | None], seconds: float) -> Iterator[float | None]:
    start = time.monotonic()
    for wait in steps:
        if time.monotonic() - start > seconds:
            raise TimeoutError(f"not done after {seconds:.0f} s")
        yield wait


class Report:
    """JUnit's XML, written before and after every test: a test that Blender does not survive is an
    error in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.suite = ElementTree.Element("testsuite", name="window")
        self.failed = False

    def start(self, name: str) -> None:
        print(f"{name} ...", flush=True)
        self.started = time.monotonic()
        file, _, function = name.partition(".")
        self.case = ElementTree.SubElement(self.suite, "testcase", classname=file, name=function)
        crash = ElementTree.SubElement(self.case, "error", message="Blender ended")
        self.write()
        self.case.remove(crash)

    def fail(self, text: str) -> None:
        self.failed = True
        print(text, flush=True)
        ElementTree.SubElement(self.case, "failure").text = text

    def finish(self) -> None:
        seconds = time.monotonic() - self.started
        self.case.set("time", f"{seconds:.1f}")
        print(f"{seconds:.1f} s", flush=True)
        self.write()

    def write(self) -> None:
        ElementTree.ElementTree(self.suite).write(self.path)


if __name__ == "__main__":
    main()
