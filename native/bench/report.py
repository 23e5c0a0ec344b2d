#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""report.py [BENCH.json] [--out FILE]: write docs/measurements.md from what bench.py wrote."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
BENCH = CHECKOUT / "build" / "bench.json"
MEASUREMENTS = CHECKOUT / "docs" / "measurements.md"

DEFAULT, AMRAP = "steady_lbo", "amrap"  # as in methods.py, which needs more than Python's own

# What is to be reached: a row's name, the end of its metric, "at most" or "at least", the bound.
TARGETS = (
    ("history", "all sets", "<=", 1e-5),
    ("continuity", "all sets", "<=", 0.1),
    ("unconverged", "all sets", "<=", 0),
    ("recognition", "all sets", "<=", 1e-4),
    ("certificate", "gap of (A 20)", "<=", 1e-8),
    ("certificate", "objective rose", "<=", 0),
    ("frame", "largest of the medians", "<=", 3),
    ("blend_vs_ecos_reduced", "the least", ">=", 20),
    ("blend_vs_ecos_full", "the least", ">=", 1000),
    ("single_shape_step", "local and global step", "<=", 4),
    ("weights_20k", "weights", "<=", 3),
    ("weights_20k", "PIQP's weights, small mesh", "<=", 1e-3),
    ("weights_20k", "duality gap", "<=", 1e-6),
    ("weights_100k", "weights", "<=", 25),
    ("weights_100k", "duality gap", "<=", 1e-6),
    ("positions_25k", "solved pose", "<=", 0.5),
    ("positions_100k", "solved pose", "<=", 3),
    ("handles_100_shapes_20", "cold", "<=", 33),
    ("window_bind_100k", "longest silence", "<=", 0.1),
    ("window_bind_100k", "from Esc to the end", "<=", 0.3),
    ("table_1", "a round, times faster than published, the least", ">=", 20),
    ("table_1", "a run, times faster than published, the least", ">=", 10),
    ("table_2", "that come no nearer with all examples than with one", "<=", 0),
    ("table_2", "from one example to all, grows by at most", "<=", 2),
    ("leave_one_out", "mean error, lion", "<=", 0.0166),
    ("leave_one_out", "mean error, cat", "<=", 0.0153),
    ("leave_one_out", "mean error, horse", "<=", 0.0111),
    ("leave_one_out", "mean error, tosca-dog", "<=", 0.0117),
    ("leave_one_out", "mean error, cactus", "<=", 0.0028),
    ("leave_one_out", "the default pair better than every peer", ">=", 7),
    ("dictionaries", "above the lowest, largest over the sets", "<=", 0.05),
    ("dictionaries", "the default pair is the lowest", ">=", 0.5),
    *(
        ("scale", f"an example's alpha, 6 points of {case} examples", "<=", 0.01)
        for case in ("tosca-dog 1.5 times as large as 4", "hand 0.7 times as large as 7")
    ),
    ("correspondence", "steady form, all other poses", ">=", 11),
    *(
        ("completion", f"{what}: least {gain}", ">=", 0)
        for what in ("completed", "registered")
        for gain in (
            "rise from fewer to more examples",
            "lead of 1 example over Der et al. 2006",
            "lead of 8 examples over Der et al. 2006",
        )
    ),
)

INTRODUCTION = """\
# Measurements

Written by `make measurements` from one run of `make bench`; do not edit. How each figure is
defined is in [native/bench/README.md](../native/bench/README.md). Lengths are in parts of the
diagonal of a set's first pose. The meshes are not part of the project.
"""

LEFT_OUT_NOTE = """\
Methods are ranked on the sets in italics. `steady_lbo` is the default pair, the steady energy on
eigenfunctions. All others have the weights of the handles: `amrap`, the steady energy, `paper`,
`no_rotations`, `no_costs` (lambda = 0) and `trust_region` are forms of Tug; `linear_shape_space` is
`no_costs` without its prior, a choice that was made after seeing results and favours Tug.

"""

DICTIONARIES_NOTE = """\
Means over poses left out. A method is an energy, a dictionary, and `soft` where rows are springs
ten times as stiff as the surface; `fbt` and what lacks a part of it are the ablations of its
Figure 8. The lowest pair of each set is bold. Unconverged: the most poses of a set that did not
come to rest; `closest` and `fbt` stop after ten rounds by design.

"""

WITHIN = (0.01, 0.02, 0.05)  # distances at which the report shows the curves

COMPLETION_NOTE = """\
FBT's Figure 7. How many per cent of the surface, and of the matches, are within a distance of the
truth; distances are in parts of the root of the area. Seconds are of one processor.

"""


PUBLISHED_NOTE = """\
The published times are of 2017: MATLAB and C++ on an i7 of 3.0 GHz. A run is ten rounds with their
cold start and the positions of the pose.

"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench", nargs="?", type=Path, default=BENCH)
    parser.add_argument("--out", type=Path, default=MEASUREMENTS)
    given = parser.parse_args()
    if not given.bench.is_file():
        sys.exit(f"report.py: there is no {given.bench}: run `make bench` first")
    rows = json.loads(given.bench.read_text())
    given.out.write_text("\n".join(filter(None, [INTRODUCTION, *sections(rows)])))


def sections(rows: list[dict]) -> Iterable[str]:
    """The parts of the text, each ending with a line feed."""
    machine = next((row for row in rows if row["name"] == "machine"), None)
    if machine:
        yield f"Machine: {machine['metric']}, {machine['value']} processors.\n"
    yield section("Targets", targets(rows))
    yield section("Error on poses left out, mean", left_out(rows), LEFT_OUT_NOTE)
    yield section(f"Error on poses left out, {DEFAULT}", own_errors(rows))
    yield section("Every energy on every dictionary", dictionaries(rows), DICTIONARIES_NOTE)
    for method in (DEFAULT, AMRAP):
        yield section(f"Every set, with all its examples, {method}", sets(rows, method))
    yield section("Jumps a path, beside others on the same paths", jumps(rows))
    yield section("FBT's Table 1: times of its forms", published_times(rows), PUBLISHED_NOTE)
    yield section("FBT's Table 2: distortion by examples, %", by_examples(rows, "%"))
    yield section("FBT's Table 2: times by examples, ms", by_examples(rows, "ms"))
    yield section("Times and sizes beside peers", timed(rows))
    yield section("Growth: exponents", growth(rows))
    yield section("Growth: times", growth_times(rows))
    yield section("Completion and registration", completion(rows), COMPLETION_NOTE)
    yield section("From few points", few_points(rows))
    missing = [[row["name"], row["metric"]] for row in rows if row["value"] is None]
    yield section("Not run", table(["name", "reason"], missing))


def section(title: str, body: str, note: str = "") -> str:
    """Empty where there is no body."""
    return f"## {title}\n\n{note}{body}" if body else ""


def table(head: list[str], lines: list[list]) -> str:
    """Markdown; empty where there are no lines."""
    if not lines:
        return ""
    all_lines = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(map(show, line)) + " |" for line in all_lines) + "\n"


def show(value: object) -> str:
    """A cell."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "**no**"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def of(rows: list[dict], name: str) -> list[dict]:
    """Rows of a name that have a value."""
    return [row for row in rows if row["name"] == name and row["value"] is not None]


def targets(rows: list[dict]) -> str:
    lines = []
    for name, metric, sense, bound in TARGETS:
        row = next((row for row in of(rows, name) if row["metric"].endswith(metric)), None)
        if row is None:
            lines.append([f"`{name}`", metric, None, f"{sense} {bound}", "not run"])
            continue
        met = row["value"] <= bound if sense == "<=" else row["value"] >= bound
        value = f"{show(row['value'])} {row['unit']}".strip()
        lines.append([f"`{name}`", row["metric"], value, f"{sense} {bound}", met])
    return table(["name", "what", "measured", "target", "met"], lines)


def left_out(rows: list[dict]) -> str:
    """Sets by methods: mean errors on the same poses."""
    found = [row for row in of(rows, "leave_one_out") if row["peer"]]
    names = list(dict.fromkeys(row["sizes"]["set"] for row in found))
    methods = list(dict.fromkeys(row["peer"] for row in found))
    cell: dict[tuple[str, str], float] = {}
    for row in found:
        cell[row["sizes"]["set"], row["peer"]] = row["peer_value"]
        cell[row["sizes"]["set"], DEFAULT] = row["value"]
    ranked = {row["sizes"]["set"] for row in found if row["sizes"]["ranked"]}
    lines = []
    for name in names:
        values = [cell.get((name, method)) for method in [DEFAULT, *methods]]
        least = min(value for value in values if value is not None)
        title = f"*{name}*" if name in ranked else name
        lines.append([title, *(f"**{v:.3g}**" if v == least else f"{v:.3g}" for v in values)])
    return table(["set", DEFAULT, *methods], lines)


def own_errors(rows: list[dict]) -> str:
    lines = [
        [
            *(row["sizes"]["set"], row["sizes"]["poses"], row["value"]),
            *(row["sizes"][key] for key in ("largest_error", "fbt_mean", "fbt_largest")),
            row["converged"],
        ]
        for row in of(rows, "leave_one_out")
        if "fbt_mean" in row["sizes"]
    ]
    measures = ["mean", "largest", "FBT's, mean", "FBT's, largest"]
    return table(["set", "poses", *measures, "all converged"], lines)


def dictionaries(rows: list[dict]) -> str:
    """Methods by sets."""
    found = [row for row in of(rows, "dictionaries") if "method" in row["sizes"]]
    cell = {(row["sizes"]["set"], row["sizes"]["method"]): row for row in found}
    names, methods = (list(dict.fromkeys(key[i] for key in cell)) for i in (0, 1))
    pairs = [method for method in methods if not method.startswith("fbt")]
    least = [min(cell[name, method]["value"] for method in pairs) for name in names]
    lines = []
    for method in methods:
        own = [cell[name, method] for name in names]
        values = [f"{row['value']:.4f}" for row in own]
        shown = [
            f"**{value}**" if row["value"] == lowest else value
            for row, value, lowest in zip(own, values, least, strict=True)
        ]
        lines.append([f"`{method}`", *shown, max(row["sizes"]["unconverged"] for row in own)])
    return table(["method", *names, "unconverged"], lines)


def sets(rows: list[dict], method: str) -> str:
    names = ("history", "recognition", "continuity", "unconverged")
    own_rows = [row for row in rows if row["sizes"].get("method") == method]
    value = {(row["sizes"].get("set"), name): row for name in names for row in of(own_rows, name)}
    found = list(dict.fromkeys(row["sizes"].get("set") for row in of(own_rows, "history")))
    lines = []
    for name in filter(None, found):
        own = [value.get((name, what)) for what in names]
        recognised = own[1]["sizes"] if own[1] else {}
        steepest = own[2]["sizes"]["steepest_step"] if own[2] else None
        lines.append(
            [name, own[0]["sizes"]["examples"], *(row and row["value"] for row in own[:2])]
            + [recognised.get(key) for key in ("counted", "least_blend", "projection_error")]
            + [*(row and row["value"] for row in own[2:]), steepest]
        )
    head = ["set", "examples", "after drags", "recognition error", "counted", "least blend"]
    head += ["projection error", "jumps a path", "frames unconverged", "steepest step"]
    return table(head, lines)


def few_points(rows: list[dict]) -> str:
    """How large a pose is, and which foot is which."""
    lines = [
        [f"`{row['name']}`", row["metric"], f"{row['value']:.3g} {row['unit']}".strip()]
        for name in ("scale", "correspondence")
        for row in of(rows, name)
    ]
    return table(["name", "what", "value"], lines)


def completion(rows: list[dict]) -> str:
    """Methods by distances, for every collection."""
    lines = []
    for row in of(rows, "completion"):
        sizes = row["sizes"]
        if "method" not in sizes:
            continue
        parts = [
            f"{100 * part:.1f}"
            for what in ("completed", "registered")
            for part, distance in zip(sizes[what], sizes["distances"], strict=True)
            if round(distance, 6) in WITHIN
        ]
        lines.append(
            [*(sizes["collection"], sizes["experiments"], sizes["method"], row["value"]), *parts]
            + [sizes["start"], sizes["seconds"]]
        )
    head = ["collection", "experiments", "method", "mean distance"]
    head += [f"{what}, {within}" for what in ("surface", "matches") for within in WITHIN]
    return table([*head, "mean distance before", "s"], lines)


def jumps(rows: list[dict]) -> str:
    lines = [
        [
            *(row["peer"], row["sizes"]["peer_uses_examples"], row["sizes"]["paths"]),
            *(row["value"], row["peer_value"], row["sizes"]["peer_unconverged"]),
            *(row["sizes"]["steepest_step"], row["sizes"]["peer_steepest_step"]),
        ]
        for row in of(rows, "continuity")
        if row["peer"]
    ]
    head = ["peer", "uses the examples", "paths", f"jumps, {DEFAULT}", "jumps, peer"]
    head += ["peer's frames unconverged", f"steepest step, {DEFAULT}", "steepest step, peer"]
    return table(head, lines)


def published_times(rows: list[dict]) -> str:
    """Sets and forms by what was timed."""
    found = [row for row in of(rows, "table_1") if row["peer"]]
    sizes = ("examples", "groups", "unknowns", "published_atoms")
    lines: dict[tuple[str, str], list] = {}
    for row in found:
        size = row["sizes"] | {"examples": row["sizes"]["shapes"]}
        start = [size["set"], size["form"], *(size[key] for key in sizes)]
        line = lines.setdefault((size["set"], size["form"]), start)
        line += [row["value"], row["peer_value"], row["ratio"]]
    head = ["set", "form", "examples", "groups", "atoms", "atoms published"]
    for what in ("round", "run"):
        head += [f"a {what}, ms", "published", "times faster"]
    return table(head, list(lines.values()))


def by_examples(rows: list[dict], unit: str) -> str:
    """What was measured by the number of examples."""
    found = [row for row in of(rows, "table_2") if row["unit"] == unit]
    most = max((len(row["sizes"]["by_examples"]) for row in found), default=0)
    lines = []
    for row in found:
        what = row["sizes"].get("dictionary") or row["metric"].rsplit(", ", 2)[0]
        values = row["sizes"]["by_examples"]
        lines.append([row["sizes"]["set"], what, *values, *[None] * (most - len(values))])
    return table(["set", "what", *map(str, range(1, most + 1))], lines)


def timed(rows: list[dict]) -> str:
    elsewhere = (
        "completion",
        "scale",
        "correspondence",
        "dictionaries",
        "leave_one_out",
        "continuity",
        "growth",
        "machine",
        "history",
        "recognition",
    )
    elsewhere += ("table_1", "table_2")
    lines = [
        [
            *(f"`{row['name']}`", row["metric"], row["value"], row["unit"], row["peer"]),
            *(row["peer_value"], row["ratio"], row["converged"]),
            row["sizes"].get("peer_converged"),
        ]
        for row in rows
        if row["value"] is not None
        and row["name"] not in (*elsewhere, "recognition", "unconverged")
    ]
    head = ["name", "what", "value", "unit", "peer", "peer's value", "ratio", "converged"]
    head += ["peer converged"]
    return table(head, lines)


def growth(rows: list[dict]) -> str:
    """What grows by what it grows in."""
    value = {grown(row): row["value"] for row in of(rows, "growth")}
    letters, things = (list(dict.fromkeys(key[i] for key in value)) for i in (1, 0))
    lines = [[thing, *(value.get((thing, letter)) for letter in letters)] for thing in things]
    return table(["exponent of", *(f"in {letter}" for letter in letters)], lines)


def growth_times(rows: list[dict]) -> str:
    """What the exponents are fitted to."""
    lines = []
    for row in of(rows, "growth"):
        fitted = zip(row["sizes"]["values"], row["sizes"]["seconds"], strict=True)
        lines.append([*grown(row), *(f"{x}: {1e3 * y:.3g}" for x, y in fitted), row["converged"]])
    return table(["time of", "in", *["size: ms"] * 4, "converged"], lines)


def grown(row: dict) -> tuple[str, str]:
    """What was timed, and the letter of what it was timed against."""
    _, _, what, _, letter = row["metric"].split()
    return what, letter


if __name__ == "__main__":
    main()
