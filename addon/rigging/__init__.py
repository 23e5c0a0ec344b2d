# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs: what an artist does with them, and what a scene tells of them."""
