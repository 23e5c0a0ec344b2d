# SPDX-License-Identifier: GPL-3.0-or-later
"""sample.py FILE.npz: write the creature of the sample scenes, which the installed add-on opens.

Arrays: faces #F by 4, colors #V by 3, names of the shapes (Basis first), shapes #S by #V by 3,
handle_names, handle_vertices.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from sample_scenes import creature  # noqa: E402


def main() -> None:
    sample = creature.sample()
    np.savez_compressed(
        sys.argv[1],
        faces=np.array(sample.faces, np.int32),
        colors=sample.colors.astype(np.float32),
        names=list(sample.shapes),
        shapes=np.stack(list(sample.shapes.values())).astype(np.float32),
        handle_names=list(sample.handles),
        handle_vertices=np.array(list(sample.handles.values()), np.int32),
    )


if __name__ == "__main__":
    main()
