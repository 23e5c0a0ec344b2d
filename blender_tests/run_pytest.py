# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender: pytest with the arguments given, and its exit code."""

import sys
from pathlib import Path

# The checkout may be read-only.
sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

import pytest  # noqa: E402
from blenders import arguments  # noqa: E402

sys.exit(pytest.main(["-p", "no:cacheprovider", *arguments(sys.argv)]))
