# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures use of the project, importable from a script in any folder."""

import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "native" / "bench")]

from baselines import METHODS  # noqa: E402
from completion import (  # noqa: E402
    DISTANCES,
    ON_BONES,
    OURS,
    PEER,
    Experiment,
    Outcome,
    bodies,
    fit,
)
from continuity import farthest  # noqa: E402
from library import (  # noqa: E402
    Dictionary,
    Form,
    Functions,
    Mesh,
    Model,
    Rows,
    Solver,
    make_functions,
)

from sample_scenes import chameleon, creature, snake, squares  # noqa: E402
from sample_scenes.sample import Sample  # noqa: E402

__all__ = [
    "DISTANCES",
    "METHODS",
    "Dictionary",
    "Experiment",
    "ON_BONES",
    "OURS",
    "PEER",
    "Form",
    "Functions",
    "Mesh",
    "Model",
    "Outcome",
    "Rows",
    "Sample",
    "Solver",
    "bodies",
    "chameleon",
    "creature",
    "farthest",
    "fit",
    "make_functions",
    "snake",
    "squares",
]
