# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python face of libtug, importable from a script in any folder."""

import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(CHECKOUT))

from addon import native  # noqa: E402
from addon.dictionaries import Dictionary, Functions, make_functions  # noqa: E402
from addon.geometry import Mesh, Points, Rows  # noqa: E402
from addon.registration.body import Body  # noqa: E402
from addon.registration.correspondence import find_correspondence  # noqa: E402
from addon.registration.features import Features  # noqa: E402
from addon.registration.nonrigid import Registration, Settings, register  # noqa: E402
from addon.registration.scan import Scan  # noqa: E402
from addon.solver import (  # noqa: E402
    Form,
    Model,
    SolveInfo,
    Solver,
    fit_dictionary,
    minimise_blend,
)
from addon.starts import RowStart, find_rotations  # noqa: E402
from addon.weights import (  # noqa: E402
    EigenfunctionsInfo,
    WeightsInfo,
    cluster_by_eigenfunctions,
    cluster_triangles,
    compute_eigenfunctions,
    compute_weights,
    find_skeleton,
)

__all__ = [
    "CHECKOUT",
    "Body",
    "Dictionary",
    "EigenfunctionsInfo",
    "Features",
    "Form",
    "Functions",
    "Mesh",
    "Model",
    "Points",
    "Registration",
    "RowStart",
    "Rows",
    "Scan",
    "Settings",
    "SolveInfo",
    "Solver",
    "WeightsInfo",
    "cluster_by_eigenfunctions",
    "cluster_triangles",
    "compute_eigenfunctions",
    "compute_weights",
    "find_correspondence",
    "find_rotations",
    "find_skeleton",
    "fit_dictionary",
    "make_functions",
    "minimise_blend",
    "native",
    "register",
]
