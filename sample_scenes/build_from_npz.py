# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes and binds a scene from a file of poses:
`blender -b --python build_from_npz.py -- FILE.npz -o FILE.blend --shapes 6 --handles 7`.

The file holds `verts` (poses, #V, 2 or 3), `faces` (#F, 3) or `quads` (#F, 4), and `names`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from addon.geometry import Mesh  # noqa: E402
from sample_scenes.sample import BASIS, LAST_FRAME, Sample, Waypoint  # noqa: E402
from sample_scenes.script import arguments, registered, report, save_scene  # noqa: E402


def sample_of(path: Path, shapes: int, handles: int, y_up: bool) -> Sample:
    """The first `shapes` poses as examples, visited one after the other."""
    data = np.load(path)
    poses = data["verts"][:shapes].astype(float)
    if poses.shape[2] == 2:
        poses = np.pad(poses, ((0, 0), (0, 0), (0, 1)))
    names = [BASIS, *(str(name) for name in data["names"][1:shapes])]
    frames = np.linspace(1, LAST_FRAME, len(names) + 1).round().astype(int)
    sample = Sample(
        name=path.stem,
        faces=data["faces" if "faces" in data else "quads"].tolist(),
        shapes=dict(zip(names, poses, strict=True)),
        handles={},
        motion=[Waypoint(int(f), n) for f, n in zip(frames, [*names, BASIS], strict=True)],
        y_up=y_up,
    )
    with Mesh(poses[0], sample.triangles()) as mesh:
        spread = mesh.spread(handles).tolist()
    named = {f"Handle {number}": vertex for number, vertex in enumerate(spread, start=1)}
    return replace(sample, handles=named)


def main() -> None:
    parser = argparse.ArgumentParser(prog="build_from_npz.py", description=__doc__)
    parser.add_argument("file", type=Path, metavar="FILE.npz")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE.blend")
    parser.add_argument("--shapes", type=int, required=True, help="the first so many poses")
    parser.add_argument("--handles", type=int, required=True, help="how many, spread from vertex 0")
    parser.add_argument("--y-up", action="store_true", help="stand the object up")
    options = parser.parse_args(arguments())
    with registered():
        sample = sample_of(options.file, options.shapes, options.handles, options.y_up)
        _, summary = save_scene(sample, options.output)
        report(summary)


if __name__ == "__main__":
    main()
