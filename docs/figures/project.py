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
    Body,
    Dictionary,
    Features,
    Form,
    Functions,
    Mesh,
    Model,
    Registration,
    Rows,
    RowStart,
    Scan,
    Settings,
    Solver,
    compute_eigenfunctions,
    find_correspondence,
    find_rotations,
    make_functions,
    register,
)

from addon.interpolation import interpolate  # noqa: E402
from addon.smoothing import Solution  # noqa: E402
from addon.solver import fit_dictionary  # noqa: E402
from sample_scenes import chameleon, creature, snake, squares  # noqa: E402
from sample_scenes.sample import BASIS, Sample  # noqa: E402

__all__ = [
    "BASIS",
    "Body",
    "DISTANCES",
    "Dictionary",
    "Experiment",
    "Features",
    "Form",
    "Functions",
    "METHODS",
    "Mesh",
    "Model",
    "ON_BONES",
    "OURS",
    "Outcome",
    "PEER",
    "Registration",
    "RowStart",
    "Rows",
    "Sample",
    "Scan",
    "Settings",
    "Solution",
    "Solver",
    "bodies",
    "chameleon",
    "compute_eigenfunctions",
    "creature",
    "farthest",
    "find_correspondence",
    "find_rotations",
    "fit",
    "fit_dictionary",
    "interpolate",
    "make_functions",
    "register",
    "snake",
    "squares",
]
