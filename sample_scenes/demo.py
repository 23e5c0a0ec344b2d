# SPDX-License-Identifier: GPL-3.0-or-later
"""The demonstration: makes the creature's scene, binds it, bakes it and shows what came out.

`blender -b --python demo.py -- [-o FOLDER]`, or the same by a Python that has the bpy module.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import bpy  # noqa: E402

from addon import bake, terminal  # noqa: E402
from sample_scenes import creature  # noqa: E402
from sample_scenes.contact_sheet import baked_sheet  # noqa: E402
from sample_scenes.script import arguments, registered, report, save_scene  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(prog="demo.py", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "build" / "demo")
    folder = parser.parse_args(arguments()).output.resolve()
    with registered():
        run(folder)


def run(folder: Path) -> None:
    """Leaves creature.blend, creature.pc2 and creature.png in `folder` and reports on stdout."""
    scene_file, cache, sheet = (folder / f"creature.{kind}" for kind in ("blend", "pc2", "png"))
    sample = creature.sample()
    obj, summary = save_scene(sample, scene_file)
    seconds = bake_all(obj, cache)
    bpy.ops.wm.save_mainfile()
    baked_sheet(obj, sheet, sample.view)
    report(summary)
    print(f"frame     {seconds:.4f} s")
    print(f"scene     {scene_file}\nbake      {cache}\npicture   {sheet}")


def bake_all(obj: bpy.types.Object, path: Path) -> float:
    """Bakes the scene's frames; gives the seconds per frame."""
    scene = bpy.context.scene
    bar = terminal.Bar("bake")
    started = time.perf_counter()
    try:
        bake.bake(obj, scene.frame_start, scene.frame_end, path, bar)
    finally:
        bar.close()
    return (time.perf_counter() - started) / (scene.frame_end - scene.frame_start + 1)


if __name__ == "__main__":
    main()
