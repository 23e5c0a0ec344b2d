#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""test.py [WORD]: run every test, or those with WORD in their name, and tell how each went.

The report of each step goes to build/results; it is shown where the step fails.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
RESULTS = CHECKOUT / "build" / "results"
SECONDS_ALLOWED = "1800"
PROVIDING = threading.Lock()  # two steps may need the same Blender

sys.path.insert(0, str(CHECKOUT / "blender_tests"))
from blenders import (  # noqa: E402
    TESTED,
    Blender,
    Root,
    UnavailableError,
    packaging_blender,
    provide_tools,
)

LIBRARY = CHECKOUT / "build" / "release" / "libtug.so"


@dataclass(frozen=True)
class Step:
    """Commands run one after the other until one fails."""

    name: str
    commands: Callable[[Path], list[list[str]]]  # from where the JUnit report should go
    required: bool = True  # whether it is a failure that it cannot be run


@dataclass(frozen=True)
class Outcome:
    name: str
    passed: int = 0
    failed: int = 0
    skipped: dict[str, int] = field(default_factory=dict)  # reason to number
    not_run: str = ""  # the reason

    def __str__(self) -> str:
        if self.not_run:
            return f"not run: {self.name}: {self.not_run}"
        return f"{self.name}: {self.passed} passed, {self.failed} failed"


def compiled_tests(preset: str) -> Callable[[Path], list[list[str]]]:
    def commands(report: Path) -> list[list[str]]:
        test = ["ctest", "--preset", preset, "--output-junit", str(report)]
        return [*build(preset), test]

    return commands


def threaded_tests(report: Path) -> list[list[str]]:
    """Those with threads of their own: nothing else can race, and the sanitizer is slow."""
    test = ["ctest", "--preset", "tsan", "-R", "^threads$", "--output-junit", str(report)]
    return [*build("tsan", "--target", "test_threads"), test]


def build(preset: str, *options: str) -> list[list[str]]:
    return [["cmake", "--preset", preset], ["cmake", "--build", "--preset", preset, *options]]


def c_style(_report: Path) -> list[list[str]]:
    sources = [str(p) for p in sorted((CHECKOUT / "native").rglob("*.[ch]"))]
    return [["clang-format-14", "--dry-run", "-Werror", *sources]]


def python_style(_report: Path) -> list[list[str]]:
    ruff = str(Path(provide_tools()).with_name("ruff"))
    return [
        [ruff, "check", "--no-cache", str(CHECKOUT)],
        [ruff, "format", "--no-cache", "--check", str(CHECKOUT)],
    ]


def python_tests(report: Path) -> list[list[str]]:
    tests = str(CHECKOUT / "native" / "tests" / "python")
    return [[provide_tools(), "-m", "pytest", "-q", "-rs", f"--junitxml={report}", tests]]


def blender_tests(blender: Blender) -> Callable[[Path], list[list[str]]]:
    def commands(report: Path) -> list[list[str]]:
        provide(blender)
        folder = CHECKOUT / "blender_tests"
        options = ("-q", "-rs", f"--junitxml={report}", str(folder))
        return [blender.command(folder / "run_pytest.py", *options)]

    return commands


def packaging(_report: Path) -> list[list[str]]:
    provide(packaging_blender())
    return [[sys.executable, str(CHECKOUT / "packaging" / "package.py")]]


def window_tests(root: Root) -> Callable[[Path], list[list[str]]]:
    """Of the extension as it was packaged, not of the sources."""

    def commands(report: Path) -> list[list[str]]:
        provide(root)
        extension = next((CHECKOUT / "build" / "package").glob("*.zip"), None)
        if extension is None:
            raise UnavailableError("the extension is not packaged")
        runner = CHECKOUT / "blender_tests" / "window" / "run.py"
        return [root.window_command(extension, runner, str(report))]

    return commands


def provide(blender: Blender) -> None:
    with PROVIDING:
        blender.provide()
    if isinstance(blender, Root) and b"libcholmod.so" in LIBRARY.read_bytes():
        raise UnavailableError("libtug was linked to this system's CHOLMOD, which it lacks")


STEPS = (
    Step("C style", c_style),
    Step("Python style", python_style),
    Step("C, debug", compiled_tests("debug")),
    Step("C, address and undefined behaviour sanitizers", compiled_tests("asan")),
    Step("C, thread sanitizer", threaded_tests),
    Step("C, release", compiled_tests("release")),
    Step("Python without Blender", python_tests),
    Step("Package, for windows", packaging, required=False),
)
BLENDER_STEPS = (
    *(Step(f"{b.name}, window", window_tests(b), False) for b in TESTED if isinstance(b, Root)),
    *(Step(b.name, blender_tests(b), required=False) for b in TESTED),
)


def take(step: Step) -> Outcome:
    """Run a step and print how it went."""
    print(f"... {step.name}", flush=True)
    label = re.sub(r"\W+", "-", step.name).strip("-").lower()
    report, log = RESULTS / f"{label}.xml", RESULTS / f"{label}.log"
    report.unlink(missing_ok=True)
    start = time.monotonic()
    try:
        code = run(step.commands(report), log)
        outcome = read_report(step.name, report, code)
    except UnavailableError as reason:
        outcome = Outcome(step.name, failed=int(step.required), not_run=str(reason))
        log.write_text("")
    shown = log.read_text(errors="replace") if outcome.failed else ""
    print(f"{shown}{outcome} ({time.monotonic() - start:.0f} s)", flush=True)
    return outcome


def run(commands: list[list[str]], log: Path) -> int:
    """The first exit code that is not zero; what the commands say goes to `log`."""
    environment = {
        "TUG_LIBRARY": str(LIBRARY),
        **os.environ,
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    with log.open("w") as output:
        for command in commands:
            code = subprocess.run(
                ["timeout", SECONDS_ALLOWED, *command],
                cwd=CHECKOUT,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            ).returncode
            if code != 0:
                output.write(f"exit code {code} from {' '.join(command)}\n")
                return code
    return 0


def read_report(name: str, report: Path, code: int) -> Outcome:
    """A step without a report is one test; one that fails without a failed test is one failure."""
    if not report.exists():
        return Outcome(name, passed=int(code == 0), failed=int(code != 0))
    cases = list(ElementTree.parse(report).iter("testcase"))
    failed = sum(1 for c in cases if c.find("failure") is not None or c.find("error") is not None)
    skipped: dict[str, int] = {}
    for case in cases:
        if (skip := case.find("skipped")) is not None:
            reason = skip.get("message", "")
            skipped[reason] = skipped.get(reason, 0) + 1
    passed = len(cases) - failed - sum(skipped.values())
    return Outcome(name, passed, max(failed, int(code != 0)), skipped)


def summarise(outcomes: list[Outcome]) -> None:
    print("\nSummary")
    for outcome in outcomes:
        print(outcome)
        for reason, count in outcome.skipped.items():
            print(f"    {count} skipped: {reason}")
    passed = sum(o.passed for o in outcomes)
    failed = sum(o.failed for o in outcomes)
    skipped = sum(sum(o.skipped.values()) for o in outcomes)
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    sys.exit(failed > 0)


def main() -> None:
    word = sys.argv[1] if len(sys.argv) > 1 else ""
    RESULTS.mkdir(parents=True, exist_ok=True)
    outcomes = [take(step) for step in STEPS if word in step.name]
    with ThreadPoolExecutor(max_workers=2) as pool:
        outcomes += pool.map(take, [step for step in BLENDER_STEPS if word in step.name])
    summarise(outcomes)


if __name__ == "__main__":
    main()
