# SPDX-License-Identifier: GPL-3.0-or-later
"""A terminal for long work: one progress bar, and ESC or Ctrl-C to cancel."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

BAR_WIDTH = 30
BAR_PERIOD = 0.1  # seconds between two pictures of the bar
LINE_PERIOD = 5.0  # seconds between two lines where the output is no terminal
ESCAPE = "\x1b"


class Bar:
    """A progress callback that draws on `stream`: a bar in a terminal, now and then a line else."""

    def __init__(self, title: str, stream: object = None) -> None:
        self._title, self._stream = title, stream or sys.stderr
        self._live = self._stream.isatty()
        self._due = 0.0

    def __call__(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        if now < self._due and fraction < 1:
            return
        self._due = now + (BAR_PERIOD if self._live else LINE_PERIOD)
        if self._live:
            full = round(fraction * BAR_WIDTH)
            bar = "#" * full + "." * (BAR_WIDTH - full)
            self._stream.write(f"\r{self._title} [{bar}] {fraction:4.0%} {stage}\x1b[K")
        else:
            self._stream.write(f"{self._title} {fraction:4.0%} {stage}\n")
        self._stream.flush()

    def close(self) -> None:
        if self._live:
            self._stream.write("\n")


@contextmanager
def cancelling() -> Iterator[Callable[[], None]]:
    """Gives a function to call often: it raises KeyboardInterrupt after ESC, Ctrl-C or a `kill`.

    A signal does not raise by itself: it might do so within a handler that Blender calls, which
    swallows exceptions.
    """
    signalled = []

    def note(number: int, _frame: object) -> None:
        signalled.append(number)

    previous = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        with _keyboard() as pressed:

            def check() -> None:
                if signalled or pressed() == ESCAPE:  # arrow keys start with it too
                    raise KeyboardInterrupt

            yield check
    finally:
        for number, handler in previous.items():
            # None: a handler that is not Python's, and that Python cannot put back.
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


@contextmanager
def _keyboard() -> Iterator[Callable[[], str]]:
    """Gives a function that returns the keys pressed so far, without waiting or echo."""
    if not (sys.stdin and sys.stdin.isatty()):
        yield str
    elif sys.platform == "win32":
        import msvcrt

        yield lambda: msvcrt.getwch() if msvcrt.kbhit() else ""
    else:
        import select
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        if os.tcgetpgrp(descriptor) != os.getpgrp():  # in the background: touching it would stop us
            yield str
            return

        def pressed() -> str:
            ready, _, _ = select.select([descriptor], [], [], 0)
            return os.read(descriptor, 64).decode(errors="ignore") if ready else ""

        before = termios.tcgetattr(descriptor)
        tty.setcbreak(descriptor)
        try:
            yield pressed
        finally:
            termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
