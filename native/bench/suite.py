# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rows of the benchmark share: their form, the choice of work, the data, the processes."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from data import ExampleSet, load, set_names
from methods import Tally

PROCESSES = 2

# Sets on which methods are ranked: poses in space, made by artists, scanners or simulation. Where
# skinning made them (hand, makehuman-poses) methods that skin are favoured. LARGE is for speed.
ACCURACY_SETS = (
    "lion",
    "cat",
    "horse",
    "head",
    "cactus",
    "tosca-cat",
    "tosca-dog",
    "tosca-wolf",
    "tosca-centaur",
    "makehuman-face",
)
LARGE = ("large-head",)
# Where the peers' continuity is measured too: the five that bend most.
PEER_SETS = ("lion", "cat", "horse", "tosca-dog", "tosca-centaur")
# AMRAP's Table 1: shapes and handles. Its face is not in the data.
TABLE = {"lion": (6, 7), "horse": (3, 10), "cat": (6, 7), "head": (7, 6)}
HANDLES = 10


@dataclass(frozen=True)
class Row:
    """One line of bench.json. ratio: how many times better than the peer."""

    name: str
    metric: str
    unit: str
    value: float | None
    peer: str | None = None
    peer_value: float | None = None
    ratio: float | None = None
    converged: bool | None = None
    sizes: dict = field(default_factory=dict)

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.name}: {self.metric}"
        text = f"{self.name}: {self.metric}: {self.value:.4g} {self.unit}".rstrip()
        if self.peer_value is not None:
            text += f"; {self.peer}: {self.peer_value:.4g}"
        if self.ratio is not None:
            text += f" ({self.ratio:.3g} x)"
        return text + ("; NOT CONVERGED" if self.converged is False else "")


def not_run(name: str, reason: str) -> Row:
    """A row without a value."""
    return Row(name, f"not run: {reason}", "", None)


def compare(
    name: str,
    metric: str,
    unit: str,
    value: float,
    peer: str,
    peer_value: float,
    converged: bool | None,
    sizes: dict,
) -> Row:
    """A row whose value and peer's value are better the lower they are."""
    ratio = peer_value / value if value > 0 else None
    return Row(name, metric, unit, value, peer, peer_value, ratio, converged, sizes)


@dataclass
class Suite:
    """The work of one run. tally: of all solves so far."""

    folder: Path
    quick: bool
    tally: Tally = field(default_factory=Tally)

    @property
    def paths(self) -> int:
        """Of a set, for continuity."""
        return 2 if self.quick else 10

    @property
    def peer_paths(self) -> int:
        return 1 if self.quick else 2

    @property
    def size(self) -> float:
        """What a quick run makes of a number of vertices."""
        return 0.1 if self.quick else 1.0

    def sets(self) -> list[str]:
        """All of the folder, the largest files first; a quick run takes three."""
        names = set_names(self.folder)
        if self.quick:
            return [name for name in names if name in ("lion", "cat", "tosca-wolf")]
        return sorted(names, key=lambda name: -(self.folder / f"{name}.npz").stat().st_size)

    def chosen(self, names: Iterable[str]) -> list[str]:
        """Those that this run uses and the folder has."""
        used = set(self.sets())
        return [name for name in names if name in used]

    def load(self, name: str) -> ExampleSet:
        return load(self.folder, name)

    def map(self, function: Callable, jobs: Iterable[tuple]) -> Iterator:
        """The results of function(*job) in their order, from processes of their own."""
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(PROCESSES, mp_context=context) as pool:
            futures = [pool.submit(function, *job) for job in jobs]
            for future in futures:
                yield future.result()
