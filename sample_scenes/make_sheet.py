# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the contact sheet of the first rig in a baked scene:
`blender -b --python make_sheet.py -- FILE.blend -o FILE.png --view 40 14`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import bpy  # noqa: E402

from sample_scenes.contact_sheet import baked_sheet  # noqa: E402
from sample_scenes.script import arguments, registered  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(prog="make_sheet.py", description=__doc__)
    parser.add_argument("scene", type=Path, metavar="FILE.blend")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE.png")
    parser.add_argument(
        "--view",
        type=float,
        nargs=2,
        default=(40, 14),
        metavar=("AZIMUTH", "ELEVATION"),
        help="of the camera in degrees; azimuth 0 looks along +Y",
    )
    options = parser.parse_args(arguments())
    with registered():
        bpy.ops.wm.open_mainfile(filepath=str(options.scene.resolve()))
        obj = next(obj for obj in bpy.context.scene.objects if obj.tug.bound)
        baked_sheet(obj, options.output, tuple(options.view))


if __name__ == "__main__":
    main()
