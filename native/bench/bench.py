#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what Tug claims, beside its peers, and write it to build/bench.json.

bench.py [--only name,...] [--quick] [--out FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

# NumPy reads it once, when it is loaded. The library has one thread anyway.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from data import MissingDataError, default_folder  # noqa: E402
from library import CHECKOUT, native  # noqa: E402
from rows_blend import blend_rows  # noqa: E402
from rows_blender import BLENDER_ROWS, blender_rows  # noqa: E402
from rows_completion import completion_rows  # noqa: E402
from rows_dictionaries import dictionary_rows  # noqa: E402
from rows_eigenfunctions import eigenfunction_rows  # noqa: E402
from rows_examples import table_1_rows, table_2_rows  # noqa: E402
from rows_few_points import correspondence_rows, scale_rows  # noqa: E402
from rows_pose import certificate_rows, leave_one_out_rows, pose_rows  # noqa: E402
from rows_registration import nearest_rows, other_rows_rows  # noqa: E402
from rows_time import (  # noqa: E402
    frame_rows,
    growth_rows,
    kernel_rows,
    many_handles_rows,
    position_rows,
    single_shape_rows,
)
from rows_weights import reference_rows, weights_rows  # noqa: E402
from rows_window import window_bind_rows  # noqa: E402
from suite import Row, Suite, not_run  # noqa: E402

# Names of rows, in the order in which they are measured, by what measures them. The certificate is
# of all solves before it.
PARTS = (
    (("frame",), lambda suite, wanted: frame_rows(suite)),
    (("blend_vs_ecos_reduced", "blend_vs_ecos_full"), blend_rows),
    (("single_shape_step",), lambda suite, wanted: single_shape_rows(suite)),
    (("positions_25k",), lambda suite, wanted: position_rows(suite, "positions_25k", 25_000)),
    (("positions_100k",), lambda suite, wanted: position_rows(suite, "positions_100k", 100_000)),
    (("dense_kernels",), lambda suite, wanted: kernel_rows()),
    (("handles_100_shapes_20",), lambda suite, wanted: many_handles_rows(suite)),
    (("nearest_25k",), lambda suite, wanted: nearest_rows(suite)),
    (("other_rows",), lambda suite, wanted: other_rows_rows(suite)),
    (("table_1",), lambda suite, wanted: table_1_rows(suite)),
    (("table_2",), lambda suite, wanted: table_2_rows(suite)),
    (("growth",), lambda suite, wanted: growth_rows(suite)),
    (("weights_20k",), lambda suite, wanted: weights_rows(suite, "weights_20k", 20_000, 3)),
    (("weights_20k",), lambda suite, wanted: reference_rows("weights_20k")),
    (("weights_100k",), lambda suite, wanted: weights_rows(suite, "weights_100k", 100_000, 1)),
    (
        ("eigenfunctions_25k",),
        lambda suite, wanted: eigenfunction_rows(suite, "eigenfunctions_25k", 25_000),
    ),
    (tuple(BLENDER_ROWS), blender_rows),
    (("window_bind_100k",), lambda suite, wanted: window_bind_rows()),
    (("history", "continuity", "unconverged", "recognition"), pose_rows),
    (("leave_one_out",), lambda suite, wanted: leave_one_out_rows(suite)),
    (("dictionaries",), lambda suite, wanted: dictionary_rows(suite)),
    (("completion",), lambda suite, wanted: completion_rows(suite)),
    (("scale",), lambda suite, wanted: scale_rows(suite)),
    (("correspondence",), lambda suite, wanted: correspondence_rows(suite)),
    (("certificate",), lambda suite, wanted: certificate_rows(suite)),
)
NAMES = list(dict.fromkeys(name for names, _ in PARTS for name in names))


def measure(suite: Suite, wanted: set[str]) -> Iterator[Row]:
    """The rows of these names. Those that need the data say so where it is missing."""
    yield Row("machine", machine(), "", os.cpu_count())
    for names, part in PARTS:
        if not wanted & set(names):
            continue
        try:
            yield from part(suite, wanted)
        except MissingDataError as missing:
            yield from (not_run(name, str(missing)) for name in names if name in wanted)


def machine() -> str:
    """Processor and compiler flags."""
    text = Path("/proc/cpuinfo").read_text() if sys.platform == "linux" else ""
    model = re.search(r"^model name\s*: (.*)$", text, re.MULTILINE)
    cache = CHECKOUT / "build" / "release" / "CMakeCache.txt"
    flags = re.search(r"^CMAKE_C_FLAGS_RELEASE:\w+=(.*)$", cache.read_text(), re.MULTILINE)
    return f"{model[1] if model else platform.processor()}, {flags[1] if flags else 'own flags'}"


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help=f"comma-separated, of {', '.join(NAMES)}")
    parser.add_argument("--quick", action="store_true", help="smaller meshes, fewer sets and paths")
    parser.add_argument("--out", type=Path, default=CHECKOUT / "build" / "bench.json")
    given = parser.parse_args()
    given.only = given.only.split(",") if given.only else NAMES
    if unknown := set(given.only) - set(NAMES):
        parser.error(f"no row {', '.join(sorted(unknown))}; there are: {', '.join(NAMES)}")
    return given


def main() -> None:
    given = parse_arguments()
    rows, start = [], time.monotonic()
    for row in measure(Suite(default_folder(), given.quick), set(given.only)):
        rows.append(row)
        print(f"[{time.monotonic() - start:5.0f} s] {row}", flush=True)
        given.out.parent.mkdir(parents=True, exist_ok=True)
        given.out.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except native.LibraryError as error:
        sys.exit(f"bench.py: {error}")
