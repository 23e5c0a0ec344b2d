# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting the examples of a rig to a target in the scene."""
