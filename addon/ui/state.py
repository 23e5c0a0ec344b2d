# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rig an artist works on, what can be done with it now, and if not, why."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.types import Context, Object

from .. import handlers
from ..caches import mesh_cache
from ..rigging import inputs, live
from ..rigging.inputs import RigError
from . import work

# Says what is missing of an object, or gives an empty string.
Requirement = Callable[[Object], str]


def find(identity: int) -> Object | None:
    """The object of a session_uid, which survives renaming and undo."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == identity), None)


def rig_of(context: Context) -> Object | None:
    """The active object, or the mesh that it is a handle of."""
    active = context.object
    if active is None or active.type == "MESH":
        return active
    if active.type != "EMPTY":
        return None
    return next((obj for obj in context.scene.objects if is_handle_of(active, obj)), None)


def is_handle_of(empty: Object, obj: Object) -> bool:
    return obj.type == "MESH" and any(handle.empty == empty for handle in obj.tug.handles)


def missing(context: Context, *requirements: Requirement) -> str:
    """What the artist has to do first, or an empty string."""
    obj = rig_of(context)
    if obj is None:
        return "Select a mesh, or one of its handles"
    return next((text for text in (needs(obj) for needs in requirements) if text), "")


def local(obj: Object) -> str:
    if obj.library or obj.data.library:
        return "Linked from another file: make the object and its mesh local first"
    return ""


def keys(obj: Object) -> str:
    if obj.data.shape_keys is None:
        return "Add shape keys first: Basis, and one for each pose to draw on"
    return ""


def out_of_edit_mode(obj: Object) -> str:
    return "Leave Edit Mode first" if obj.data.is_editmode else ""


def edit_mode(obj: Object) -> str:
    return "" if obj.data.is_editmode else "Enter Edit Mode and select vertices first"


def idle(obj: Object) -> str:
    return "It is being bound or fitted: wait, or press Esc" if work.running(obj) else ""


def handles(obj: Object) -> str:
    return "" if len(obj.tug.handles) else "Add handles first"


def two_handles(obj: Object) -> str:
    return "" if len(obj.tug.handles) > 1 else "Add at least two handles first"


def bound(obj: Object) -> str:
    return "" if obj.tug.bound else "Bind the mesh to its handles first"


def baked(obj: Object) -> str:
    return "" if mesh_cache.NAME in obj.modifiers else "Bake first"


def up_to_date(obj: Object) -> str:
    return stale(obj, bpy.context.scene)


def stale(obj: Object, scene: bpy.types.Scene) -> str:
    """Why a bound rig gives no poses, or an empty string."""
    try:
        live.check(obj, scene)
    except RigError as error:
        return str(error)
    return handlers.problem(obj)


def pending(obj: Object) -> str:
    """What the next bind will take over, or an empty string. Poses go on without it."""
    if obj.tug.bound and inputs.ticked(obj) != inputs.bound_examples(obj):
        return "Other examples are ticked: bind again to use them"
    moved = [h.name for h in obj.tug.handles if h.rest_vertex >= 0 and h.vertex != h.rest_vertex]
    if obj.tug.bound and moved:
        return f"Other vertices are held by {', '.join(moved)}: bind again for weights that fit"
    return ""


def last_solve(obj: Object) -> str:
    known = live.known(obj)
    if known is None or known.last is None:
        return ""
    info, milliseconds = known.last.info, 1000 * known.last.seconds
    settled = "settled" if info.converged else "not settled"
    return f"{milliseconds:.1f} ms, {settled}, gap {info.gap:.0g}"
