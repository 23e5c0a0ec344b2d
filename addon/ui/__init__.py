# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees of Tug: panels, operators, menus, tools. Each module registers its own."""

from __future__ import annotations

from . import bind_operators, drag_operator, drag_tool, overlay_colours

MODULES = (bind_operators, drag_operator, overlay_colours, drag_tool)


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
