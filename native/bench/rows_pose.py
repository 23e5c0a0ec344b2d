# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on what the poses are worth: history, continuity, unconverged, recognition, leave_one_out,
certificate."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from continuity import Trace, draw_paths, follow
from data import load
from methods import AMRAP, DEFAULT, FORMS, NO_PEERS, ONE_SHAPE, Tally, make, peers
from quality import (
    HeldOut,
    Recognised,
    drag_dependence,
    leave_one_out,
    recognise,
    tally_of,
)
from rigs import Rig
from suite import ACCURACY_SETS, HANDLES, LARGE, PEER_SETS, Row, Suite, compare, not_run

POSES = 12  # of a set in leave-one-out
CONTINUITY_PEERS = ("paper", "fast", "mesh_ik", "energy_interpolation")


@dataclass
class Examined:
    """One set with all its examples, by one method of Tug."""

    name: str
    method: str
    examples: int
    drags: float
    recognised: list[Recognised]
    traces: list[Trace] = field(default_factory=list)
    tally: Tally = field(default_factory=Tally)


def examine(folder: Path, name: str, method_name: str, path_count: int) -> Examined:
    """In a process of its own: drags, recognition, and paths where there are enough examples."""
    poses = load(folder, name)
    handles = poses.spread_handles(HANDLES)
    fresh = functools.partial(make, method_name, Rig(poses.shapes, poses.triangles, handles))
    tally = Tally()
    drags = drag_dependence(poses, handles, fresh, tally)
    method = fresh()
    recognised = recognise(poses, handles, method)
    result = Examined(name, method_name, len(poses.shapes), drags, recognised, tally=tally)
    if len(poses.shapes) >= 4:
        paths = draw_paths(poses, handles, path_count)
        result.traces = [follow(method, path) for path in paths]
    tally.add(tally_of(method))
    method.close()
    return result


def trace_peer(folder: Path, name: str, method_name: str, path_count: int) -> list[Trace]:
    """In a process of its own: the first paths of a set by one method."""
    poses = load(folder, name)
    handles = poses.spread_handles(HANDLES)
    method = make(method_name, Rig(poses.shapes, poses.triangles, handles))
    traces = [follow(method, path) for path in draw_paths(poses, handles, path_count)]
    method.close()
    return traces


def hold_out(folder: Path, name: str, methods: list[str]) -> tuple[list[HeldOut], Tally]:
    """In a process of its own: each pose of a set from all its others."""
    poses, tally = load(folder, name).first(POSES), Tally()
    handles = poses.spread_handles(HANDLES)
    return leave_one_out(poses, handles, methods, tally), tally


def pose_rows(suite: Suite, wanted: set[str]) -> Iterator[Row]:
    """history, recognition, continuity, unconverged, on every set: of the default pair, then of
    its energy on the handles' functions."""
    by_method: dict[str, list[Examined]] = {DEFAULT: [], AMRAP: []}
    jobs = [(suite.folder, set_, name, suite.paths) for name in by_method for set_ in suite.sets()]
    for one in suite.map(examine, jobs):
        suite.tally.add(one.tally, f"{label([one])}, all examples")
        by_method[one.method].append(one)
        yield from rows_of([one], wanted)
    for examined in by_method.values():
        yield from rows_of(examined, wanted)
    if "continuity" in wanted:
        yield from peer_path_rows(suite, by_method[DEFAULT])


def rows_of(examined: list[Examined], wanted: set[str]) -> Iterator[Row]:
    rows = [history_row(examined), recognition_row(examined), *path_rows(examined)]
    yield from (row for row in rows if row.name in wanted)


def sizes_of(examined: list[Examined]) -> dict:
    """What a row is about: one set, or all of them."""
    sizes = {"method": examined[0].method, "handles": HANDLES}
    if len(examined) == 1:
        return sizes | {"set": examined[0].name, "examples": examined[0].examples}
    return sizes | {"sets": len(examined)}


def label(examined: list[Examined]) -> str:
    """What it is about, of whom: nobody's name stands for the default pair."""
    of = examined[0].name if len(examined) == 1 else "all sets"
    return of if examined[0].method == DEFAULT else f"{of}, {examined[0].method}"


def history_row(examined: list[Examined]) -> Row:
    worst = max(one.drags for one in examined)
    metric = f"largest vertex difference after 20 drags, {label(examined)}"
    return Row("history", metric, "diagonals", worst, sizes=sizes_of(examined))


def recognition_row(examined: list[Examined]) -> Row:
    """The worst example, and beside it the model's own error and the blend of that example."""
    found = [one for set_ in examined for one in set_.recognised]
    metric = f"largest vertex error of an example from its handles, {label(examined)}"
    if not found:
        return not_run("recognition", f"no example of {label(examined)} can be told from others")
    worst = max(found, key=lambda one: one.error)
    sizes = sizes_of(examined) | {
        "counted": len(found),
        "projection_error": worst.projection,
        "blend_of_worst": worst.blend,
        "least_blend": min(one.blend for one in found),
    }
    return Row("recognition", metric, "diagonals", worst.error, sizes=sizes)


def path_rows(examined: list[Examined]) -> list[Row]:
    traces = [trace for one in examined for trace in one.traces]
    if not traces:
        return []
    frames, missed = (sum(getattr(t, n) for t in traces) for n in ("frames", "unconverged"))
    sizes = sizes_of([one for one in examined if one.traces]) | {"paths": len(traces)}
    jumps = [trace.jumps for trace in traces]
    steepest = {"jumps": jumps, "steepest_step": max(trace.steepest for trace in traces)}
    mean, of = float(np.mean(jumps)), label(examined)
    return [
        Row("continuity", f"jumps a path, {of}", "", mean, sizes=sizes | steepest),
        Row("unconverged", f"frames, {of}", "", missed, sizes=sizes | {"frames": frames}),
    ]


def peer_path_rows(suite: Suite, examined: list[Examined]) -> Iterator[Row]:
    """Each peer on the first paths of some sets, and the default pair on the same."""
    names, count = suite.chosen(PEER_SETS), suite.peer_paths
    own = [t for one in examined if one.name in names for t in one.traces[:count]]
    there = [name for name in CONTINUITY_PEERS if name in (*FORMS, *peers())]
    results = suite.map(
        trace_peer, [(suite.folder, name, peer, count) for peer in there for name in names]
    )
    for peer in there:
        traces = [trace for _ in names for trace in next(results)]
        yield compare_paths(peer, names, own, traces)
    if not peers():
        yield not_run("continuity", NO_PEERS)


def compare_paths(peer: str, names: list[str], own: list[Trace], traces: list[Trace]) -> Row:
    sizes = {
        "sets": names,
        "paths": len(traces),
        "peer_uses_examples": peer not in ONE_SHAPE,
        "peer_steepest_step": max(trace.steepest for trace in traces),
        "peer_unconverged": sum(trace.unconverged for trace in traces),
        "steepest_step": max(trace.steepest for trace in own),
    }
    mine, theirs = (float(np.mean([trace.jumps for trace in t])) for t in (own, traces))
    metric = "jumps a path, the same paths"
    return compare("continuity", metric, "", mine, peer, theirs, None, sizes)


def leave_one_out_rows(suite: Suite) -> Iterator[Row]:
    """Every method on every set; and on how many of those that rank the default pair is better
    than all that are not Tug's."""
    ranked = suite.chosen(ACCURACY_SETS)
    names = ranked + [name for name in suite.sets() if name not in (*ranked, *LARGE)]
    others = [*FORMS, *peers()]
    better: dict[str, list[str]] = {}
    jobs = [(suite.folder, name, [DEFAULT, *others]) for name in names]
    for name, (found, tally) in zip(names, suite.map(hold_out, jobs), strict=True):
        suite.tally.add(tally, f"leave_one_out, {name}")
        own = mean_row(name, [one for one in found if one.method == DEFAULT])
        yield own
        rows = [method_row(name, own, found, method) for method in others]
        yield from rows
        if name in ranked:
            better[name] = [r.peer for r in rows if r.peer in peers() and r.peer_value <= own.value]
    if peers():
        metric = "sets, the default pair better than every peer"
        won = sum(not found for found in better.values())
        yield Row("leave_one_out", metric, "", won, sizes={"better_peers": better})
    else:
        yield not_run("leave_one_out", NO_PEERS)


def mean_row(name: str, found: list[HeldOut]) -> Row:
    sizes = {
        "set": name,
        "poses": len(found),
        "handles": HANDLES,
        "largest_error": max(one.largest for one in found),
        "fbt_mean": float(np.mean([one.fbt for one in found])),
        "fbt_largest": max(one.fbt for one in found),
    }
    mean = float(np.mean([one.mean for one in found]))
    converged = all(one.converged for one in found)
    metric = f"mean error, {name}"
    return Row("leave_one_out", metric, "diagonals", mean, converged=converged, sizes=sizes)


def method_row(name: str, own: Row, found: list[HeldOut], method: str) -> Row:
    theirs = [one for one in found if one.method == method]
    sizes = {
        "set": name,
        "ranked": name in ACCURACY_SETS,
        "poses": len(theirs),
        "peer_largest_error": max(one.largest for one in theirs),
        "peer_unconverged": sum(not one.converged for one in theirs),
    }
    error = float(np.mean([one.mean for one in theirs]))
    both = (f"mean error of each method, {name}", "diagonals", own.value, method, error)
    return compare("leave_one_out", *both, own.converged, sizes)


def certificate_rows(suite: Suite) -> Iterator[Row]:
    """Over every solve of Tug that this run has made so far."""
    tally = suite.tally
    if tally.solves == 0:
        yield not_run("certificate", "no row with solves was asked for")
        return
    sizes = {"solves": tally.solves, "unconverged": tally.unconverged, "largest": tally.where}
    yield Row("certificate", "largest relative gap of (A 20)", "", tally.gap, sizes=sizes)
    metric = "largest gap of (A 20) where the objective is zero"
    yield Row("certificate", metric, "diagonals", tally.gap_at_examples, sizes=sizes)
    yield Row("certificate", "solves whose objective rose", "", tally.rises, sizes=sizes)
