# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses of many frames, in files that modifiers show."""
