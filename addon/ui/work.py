# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds and fits that run beside the window, in threads of their own."""

from __future__ import annotations

import threading
from typing import Protocol

from bpy.types import Object

from ..native import Progress

# By identity of the object.
_running: dict[int, Work] = {}
# Cancelled, and about to end.
_abandoned: list[Work] = []


class CancelledError(Exception):
    """Nobody waits for the work any more."""


class Job(Protocol):
    """Work for one object: its name and session_uid, and what takes the time, on any thread."""

    name: str
    identity: int

    def build(self, progress: Progress | None = None) -> None: ...


class Work(threading.Thread):
    """Builds a job; `stage` and `fraction` say how far it is, `problem` what ended it."""

    def __init__(self, job: Job) -> None:
        super().__init__(name="Tug", daemon=True)
        self.job, self.stage, self.fraction = job, "", 0.0
        self.problem: Exception | None = None
        self._cancelled = threading.Event()

    def start(self) -> None:
        _running[self.job.identity] = self
        super().start()

    def run(self) -> None:
        try:
            self.job.build(self._progress)
        except Exception as error:  # raised again on the main thread
            self.problem = error

    def end(self) -> None:
        """Wait for it, and forget it."""
        self.join()
        _running.pop(self.job.identity, None)

    def abandon(self) -> None:
        """Forget it now; it ends by itself when it next tells how far it is."""
        self._cancelled.set()
        _running.pop(self.job.identity, None)
        _abandoned[:] = [work for work in _abandoned if work.is_alive()] + [self]

    def _progress(self, stage: str, fraction: float) -> None:
        self.stage, self.fraction = stage, fraction
        if self._cancelled.is_set():
            raise CancelledError


def running(obj: Object) -> Work | None:
    return _running.get(obj.session_uid)


def cancel_all() -> None:
    """And wait: what they run may be taken away."""
    for work in list(_running.values()):
        work.abandon()
    for work in _abandoned:
        work.join()
