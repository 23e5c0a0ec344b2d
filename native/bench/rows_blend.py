# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on (A 20): the library against ECOS, SCS and Clarabel, reduced and full."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from cone_solvers import PEERS, TOLERANCE, Optimum, solve_by_peer, solve_by_tug
from conic import Assembly, Instance
from continuity import draw_paths
from methods import AMRAP, make
from rigs import Rig
from suite import TABLE, Row, Suite, compare

TIMES = (0.3, 0.7)  # of the frames along the first path whose (A 20) is taken
REPEATS = 200
PEER_REPEATS = {"reduced": 9, "full": 1}  # milliseconds, and parts of a second or seconds


def instances(suite: Suite, name: str) -> list[Instance]:
    """Of AMRAP's Table 1, from the rotations and costs of converged solves."""
    shapes, handle_count = TABLE[name]
    poses = suite.load(name).first(shapes)
    handles = poses.spread_handles(handle_count)
    method = make(AMRAP, Rig(poses.shapes, poses.triangles, handles))
    assembly = Assembly(poses, handles, method.functions)
    path = next(draw_paths(poses, handles, 1))
    made = []
    for time in TIMES:
        method.solve(path.at(time))
        made.append(assembly.instance(method.solver, path.at(time)))
    suite.tally.add(method.tally, f"blend_vs_ecos, {name}")
    method.close()
    return made


def blend_rows(suite: Suite, wanted: set[str]) -> Iterator[Row]:
    """Times of each solver on each model; then the least ratio to ECOS; then the accuracies."""
    ratios: dict[str, list[float]] = {}
    for name in suite.chosen(TABLE):
        made = instances(suite, name)
        own = [solve_by_tug(instance, REPEATS) for instance in made]
        for form, repeats in PEER_REPEATS.items():
            row_name = f"blend_vs_ecos_{form}"
            for peer in PEERS if row_name in wanted else ():
                theirs = [solve_by_peer(peer, getattr(one, form), repeats) for one in made]
                row = time_row(row_name, name, made, own, peer, theirs)
                yield row
                yield accuracy_row(row_name, name, made, own, peer, theirs)
                if peer == "ECOS":
                    ratios.setdefault(row_name, []).append(row.ratio)
    for row_name, found in ratios.items():
        sizes = {"models": len(found)}
        yield Row(row_name, "ECOS's time over ours, the least", "x", min(found), sizes=sizes)


def size_of(made: list[Instance], form: str) -> int:
    return len(getattr(made[0], form).cost)


def time_row(
    row_name: str,
    model: str,
    made: list[Instance],
    own: list[Optimum],
    peer: str,
    theirs: list[Optimum],
) -> Row:
    milliseconds, peer_milliseconds = (
        1e3 * float(np.median([one.seconds for one in found])) for found in (own, theirs)
    )
    sizes = {
        "model": model,
        "unknowns": size_of(made, "reduced"),
        "peer_unknowns": size_of(made, row_name.rpartition("_")[2]),
        "instances": len(made),
        "tolerance": TOLERANCE,
        "peer_converged": all(one.converged for one in theirs),
    }
    converged = all(one.converged for one in own)
    metric = f"one (A 20), {model}"
    return compare(
        *(row_name, metric, "ms", milliseconds, peer, peer_milliseconds, converged, sizes)
    )


def accuracy_row(
    row_name: str,
    model: str,
    made: list[Instance],
    own: list[Optimum],
    peer: str,
    theirs: list[Optimum],
) -> Row:
    """How far each is above the lower of the two objectives, relative."""
    excess = np.zeros(2)
    for mine, other in zip(own, theirs, strict=True):
        objectives = np.array([mine.objective, other.objective])
        excess = np.maximum(excess, objectives / objectives.min() - 1.0)
    metric = f"objective above the lower one, {model}"
    sizes = {"model": model, "instances": len(made), "tolerance": TOLERANCE}
    sizes["peer_converged"] = all(one.converged for one in theirs)
    converged = all(one.converged for one in own)
    own_excess, peer_excess = excess.tolist()
    return Row(
        *(row_name, metric, "relative", own_excess, peer, peer_excess, None, converged, sizes)
    )
