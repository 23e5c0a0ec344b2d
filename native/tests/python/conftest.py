# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes `addon` importable: these tests run in a plain Python, from any folder."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))
