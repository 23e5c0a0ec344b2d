# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes and binds a sample scene: `blender -b --python build.py -- NAME -o FILE.blend`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from sample_scenes import chameleon, creature, face, snake, squares  # noqa: E402
from sample_scenes.blend_scene import suzanne  # noqa: E402
from sample_scenes.sample import Sample  # noqa: E402
from sample_scenes.script import arguments, registered, report, save_scene  # noqa: E402

SAMPLES: dict[str, Callable[[], Sample]] = {
    "squares": squares.sample,
    "snake": snake.sample,
    "chameleon": chameleon.sample,
    "creature": creature.sample,
    "face": lambda: face.sample(*suzanne()),
}


def main() -> None:
    parser = argparse.ArgumentParser(prog="build.py", description=__doc__)
    parser.add_argument("name", choices=SAMPLES)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE.blend")
    options = parser.parse_args(arguments())
    with registered():
        _, summary = save_scene(SAMPLES[options.name](), options.output)
        report(summary)


if __name__ == "__main__":
    main()
