# SPDX-License-Identifier: GPL-3.0-or-later
"""Tug: pose a mesh by pulling handles, drawing on its shape keys.

Importing this package needs no Blender, so that `solver` serves plain Python; `register` does.
"""

from __future__ import annotations

import atexit
from collections.abc import Sequence

_command: object = None  # what undoes the registration of `blender --command tug`


def register() -> None:
    """Make Tug known to Blender. The library is not needed for it."""
    global _command
    import bpy

    from . import handlers, properties, ui
    from .rigging import names

    properties.register()
    handlers.register()
    names.register()
    ui.register()
    _command = bpy.utils.register_cli_command("tug", _run)
    # As a module in Python, Blender crashes or hangs at exit over what is still registered.
    if not bpy.app.binary_path:
        atexit.register(unregister)


def unregister() -> None:
    import bpy

    from . import handlers, properties, ui
    from .rigging import live, names

    atexit.unregister(unregister)
    bpy.utils.unregister_cli_command(_command)
    ui.unregister()
    names.unregister()
    handlers.unregister()
    properties.unregister()
    live.forget_all()


def _run(arguments: Sequence[str]) -> int:
    from . import cli

    return cli.command(arguments)
