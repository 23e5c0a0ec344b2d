# SPDX-License-Identifier: GPL-3.0-or-later
"""make.py [NAME...]: draw the figures, or those of these names, into this folder: NAME.png, and the
numbers behind it in NAME.json.

A figure is a module here with measure(), numbers(measured) and draw(measured, path). It imports
`drawing` inside draw alone, so that numbers can be had without Matplotlib.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
FIGURES = (
    *(f"amrap_{number}" for number in (1, 2, 4, 5, 6, 7, 8)),
    "forms",
    *(f"fbt_{number}" for number in range(2, 9)),
)
DIGITS = 4


def main() -> None:
    names = sys.argv[1:] or FIGURES
    if unknown := sorted(set(names) - set(FIGURES)):
        sys.exit(f"make.py: there is no figure {unknown[0]}; there are {', '.join(FIGURES)}")
    for name in names:
        started = time.perf_counter()
        figure = importlib.import_module(name)
        measured = figure.measure()
        table = json.dumps(rounded(figure.numbers(measured)), indent=2)
        (HERE / f"{name}.json").write_text(table + "\n")
        figure.draw(measured, HERE / f"{name}.png")
        print(f"{name}: {time.perf_counter() - started:.1f} s", flush=True)


def rounded(value: object) -> object:
    """Every number to a few significant digits, so that a run elsewhere prints the same."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item) for item in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


if __name__ == "__main__":
    main()
