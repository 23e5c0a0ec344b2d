# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress bar, and cancelling from the keyboard or by a signal."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from addon import terminal

ROOT = Path(__file__).resolve().parents[3]
WAITING = """
import time
from addon import terminal
try:
    with terminal.cancelling() as check:
        print("ready", flush=True)
        for _ in range(500):
            check()
            time.sleep(0.01)
    print("finished")
except KeyboardInterrupt:
    print("cancelled")
"""


class Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


def waiting(stdin, code=WAITING) -> subprocess.Popen:
    """A process that waits to be cancelled, and is known to do so."""
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=stdin,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        start_new_session=True,
    )
    assert process.stdout.readline() == "ready\n"
    return process


def test_a_bar_is_drawn_over_itself():
    screen = Screen()
    bar = terminal.Bar("bake", screen)
    bar("frame 1", 0.5)
    bar("frame 2", 1.0)
    bar.close()
    first, second, third = screen.getvalue().split("\r")
    assert not first
    assert second.startswith("bake [###############...............]  50% frame 1")
    assert third.startswith("bake [##############################] 100% frame 2")
    assert third.endswith("\n")


def test_a_bar_is_not_drawn_more_often_than_eyes_see():
    screen = Screen()
    bar = terminal.Bar("bake", screen)
    for step in range(1000):
        bar("frame", step / 1000)
    assert screen.getvalue().count("\r") < 10


def test_a_log_gets_few_whole_lines():
    log = io.StringIO()
    bar = terminal.Bar("bake", log)
    for step in range(1001):
        bar("frame", step / 1000)
    bar.close()
    assert log.getvalue() == "bake   0% frame\nbake 100% frame\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_cancels(number):
    process = waiting(subprocess.DEVNULL)
    process.send_signal(number)
    assert process.communicate(timeout=10)[0] == "cancelled\n"


@pytest.mark.skipif(sys.platform == "win32", reason="not run: there are no pseudo-terminals")
def test_escape_cancels_but_an_arrow_key_does_not():
    import pty

    ours, theirs = pty.openpty()
    take_terminal = "import fcntl, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0)"
    process = waiting(theirs, take_terminal + WAITING)
    os.write(ours, b"\x1b[A")
    time.sleep(0.2)
    assert process.poll() is None
    os.write(ours, b"\x1b")
    assert process.communicate(timeout=10)[0] == "cancelled\n"
    os.close(ours)
    os.close(theirs)


def test_signals_are_as_before_afterwards():
    before = signal.getsignal(signal.SIGTERM)
    with terminal.cancelling():
        assert signal.getsignal(signal.SIGTERM) is not before
    assert signal.getsignal(signal.SIGTERM) is before
