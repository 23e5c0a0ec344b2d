# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scenes: meshes, example shapes, handles and motion, made by scripts from nothing."""
