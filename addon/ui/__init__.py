# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees of Tug: panels, operators, menus, tools. Each module registers its own."""

from __future__ import annotations

from . import (
    bake_operators,
    bind_operators,
    click_operator,
    drag_operator,
    drag_tool,
    example_operators,
    fit_operators,
    handle_operators,
    lists,
    menus,
    overlay_colours,
    panel,
    pose_operators,
    sample_operator,
)

MODULES = (
    bind_operators,
    handle_operators,
    click_operator,
    example_operators,
    pose_operators,
    bake_operators,
    fit_operators,
    sample_operator,
    drag_operator,
    overlay_colours,
    drag_tool,
    lists,
    panel,
    menus,
)


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
