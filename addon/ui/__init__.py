# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees of Tug: panels, operators, menus, tools."""

from __future__ import annotations

import bpy

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
    work,
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
    lists,
    panel,
    menus,
)

# Those with more to register than classes.
OTHERS = (overlay_colours, drag_tool, menus)

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    [cls for module in MODULES for cls in module.CLASSES]
)


def register() -> None:
    _register_classes()
    for module in OTHERS:
        module.register()


def unregister() -> None:
    work.cancel_all()
    for module in reversed(OTHERS):
        module.unregister()
    _unregister_classes()
