# SPDX-License-Identifier: GPL-3.0-or-later
"""The row on what goes best together: dictionaries, every energy on every dictionary, with pinned
and with soft rows, and the ablations of FBT's Figure 8."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from methods import ABLATIONS, DEFAULT, PAIRS
from quality import HeldOut
from rows_pose import hold_out
from suite import LARGE, Row, Suite

NAME = "dictionaries"
FIRST = ("lion", "cat", "horse", "tosca-dog", "cactus")  # those that the targets are about


def dictionary_rows(suite: Suite) -> Iterator[Row]:
    """Mean errors on poses left out on every set in space; then, of each set, by how much the
    default pair is above the lowest, and on how many it is the lowest."""
    names = [*suite.chosen(FIRST), *(name for name in suite.sets() if name not in (*FIRST, *LARGE))]
    names = [name for name in names if suite.load(name).shapes.shape[2] == 3]
    jobs = [(suite.folder, name, [*PAIRS, *ABLATIONS]) for name in names]
    above = {}
    for name, (found, tally) in zip(names, suite.map(hold_out, jobs), strict=True):
        suite.tally.add(tally, f"{NAME}, {name}")
        rows = {method: error_row(name, method, found) for method in (*PAIRS, *ABLATIONS)}
        yield from rows.values()
        lowest = min(rows[method].value for method in PAIRS)
        above[name] = rows[DEFAULT].value / lowest - 1
    metric = "the default pair above the lowest, largest over the sets"
    yield Row(NAME, metric, "", max(above.values()), sizes={"sets": above})
    part = float(np.mean([excess == 0 for excess in above.values()]))
    yield Row(NAME, "part of the sets on which the default pair is the lowest", "", part)


def error_row(name: str, method: str, found: list[HeldOut]) -> Row:
    own = [one for one in found if one.method == method]
    sizes = {"set": name, "method": method, "poses": len(own)}
    sizes["unconverged"] = sum(not one.converged for one in own)
    mean = float(np.mean([one.mean for one in own]))
    return Row(NAME, f"mean error, {method}, {name}", "diagonals", mean, sizes=sizes)
