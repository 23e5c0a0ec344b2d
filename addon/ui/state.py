# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be done with the active object now, and if not, why: for polls and the panel."""

from __future__ import annotations

import bpy
from bpy.types import Context, Object, Operator

from .. import inputs, live
from ..inputs import RigError


def find(identity: int) -> Object | None:
    """The object of a session_uid, which survives renaming and undo."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == identity), None)


def is_mesh(cls: type[Operator], context: Context) -> bool:
    if context.object is None or context.object.type != "MESH":
        cls.poll_message_set("Select a mesh first")
        return False
    return True


def can_bind(cls: type[Operator], context: Context) -> bool:
    if not is_mesh(cls, context):
        return False
    try:
        inputs.check_object(context.object)
        if len(context.object.tug.handles) < 2:
            raise RigError("Add at least two handles first")
    except RigError as error:
        cls.poll_message_set(str(error))
        return False
    return True


def is_bound(cls: type[Operator], context: Context) -> bool:
    if not is_mesh(cls, context):
        return False
    if not context.object.tug.bound:
        cls.poll_message_set("Bind the mesh to its handles first")
        return False
    return True


def stale(obj: Object, scene: bpy.types.Scene) -> str:
    """Why a bound rig has to be bound again, or an empty string."""
    try:
        live.check(obj, scene)
    except RigError as error:
        return str(error)
    return ""
