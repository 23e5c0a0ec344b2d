# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting a body, what a model and its dictionary span, to a scan of the same kind of thing. Knows
NumPy, not Blender."""
