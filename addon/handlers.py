# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the rigs posed: while something moves their handles, and while frames change.

While a window renders, frames change on a thread of the render's, which writes to the same meshes
that the viewport shows. Then nothing is posed for the viewport; when it is over, it is again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import bpy
from bpy.app.handlers import persistent

from .caches import mesh_cache
from .native import LibraryError
from .rigging import inputs, live, names, rig
from .rigging.inputs import RigError

# The modes in which an artist changes what a rig was made from.
EDITING = {"EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT"}

# What went wrong with a rig when it was last posed, by session_uid. Each text is printed once.
_problems: dict[int, str] = {}
_paused = False
_rendering = False
_rendered = False  # the render is over, and the viewport still to be shown again

PERIOD = 0.1  # seconds between two looks of `_watch`


def problem(obj: bpy.types.Object) -> str:
    """Why the object was not posed when it last should have been, or an empty string."""
    return _problems.get(obj.session_uid, "")


def render_risk(scene: bpy.types.Scene) -> str:
    """What an artist should know before an animation with live rigs is rendered in a window, or an
    empty string."""
    if bpy.app.background or scene.render.use_lock_interface:
        return ""
    live_rigs = [
        obj.name
        for obj in scene.objects
        if obj.type == "MESH" and obj.tug.bound and not mesh_cache.shown(obj, "RENDER")
    ]
    if not live_rigs:
        return ""
    return (
        f"{', '.join(live_rigs)} would be posed while rendering: bake first, or turn on Lock "
        "Interface to keep the window from drawing meanwhile"
    )


@contextmanager
def paused() -> Iterator[None]:
    """Frames may change without poses being written: a bake reads them itself."""
    global _paused
    _paused = True
    try:
        yield
    finally:
        _paused = False


@persistent
def _pose_all(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """A frame came. What is rendered is posed in any case."""
    rendered = depsgraph.mode == "RENDER"
    _pose((obj for obj in scene.objects if rendered or obj.tug.live), depsgraph)


@persistent
def _pose_updated(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Something moved, was edited or set. A rig is updated with its handles: see `reach`."""
    updated = [update.id.original for update in depsgraph.updates]
    rigs = [obj for obj in updated if isinstance(obj, bpy.types.Object) and obj.tug.bound]
    for obj in rigs:
        if obj.mode in EDITING:
            live.invalidate(obj)
    meshes = {obj.data for obj in rigs if obj.tug.live and obj.mode not in EDITING}
    if meshes:  # not the object that was updated, but the first with its mesh is posed
        _pose((o for o in scene.objects if o.data in meshes and o.tug.live), depsgraph)


def _pose(objects: Iterable[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> None:
    if _paused or (_rendering and depsgraph.mode == "VIEWPORT"):
        return
    posed = set()  # a linked duplicate shows the pose of the object that comes first
    for obj in objects:
        if obj.type != "MESH" or not obj.tug.bound or obj.data in posed:
            continue
        if obj.data.is_editmode or inputs.is_linked(obj) or mesh_cache.shown(obj, depsgraph.mode):
            continue
        posed.add(obj.data)
        if depsgraph.mode != "RENDER":
            names.follow(obj)
        try:
            rig.follow(obj, depsgraph)
        except (RigError, LibraryError) as error:
            _report(obj, str(error))
        else:
            _problems.pop(obj.session_uid, None)


def _report(obj: bpy.types.Object, text: str) -> None:
    if _problems.get(obj.session_uid) != text:
        _problems[obj.session_uid] = text
        print(f"Tug: {text}")


@persistent
def _touch_all(*_: object) -> None:
    live.touch_all()
    # Before 4.3 an undo brings the key back but does not evaluate the mesh.
    if bpy.app.version < (4, 3):
        for obj in bpy.data.objects:
            if obj.type == "MESH" and obj.tug.bound:
                obj.data.update_tag()


@persistent
def _start_render(scene: bpy.types.Scene, *_: object) -> None:
    global _rendering, _rendered
    _rendering, _rendered = True, False
    if text := render_risk(scene):
        print(f"Tug: {text}")


@persistent
def _end_render(*_: object) -> None:
    """Called on the render's thread, where no timer may be registered: Blender's list of them has
    no lock. The rest is for the main thread: that of a window finds it by `_watch`."""
    global _rendered
    if bpy.app.background:
        _show_viewport_again()
    else:
        _rendered = True


def _watch() -> float:
    """A timer of the main thread for as long as Tug is registered: whether a render is over."""
    if _rendered:
        _show_viewport_again()
    return PERIOD


def _show_viewport_again() -> None:
    """The meshes have the pose of the last frame that was rendered."""
    global _rendering, _rendered
    _rendering = _rendered = False
    _look_at_all()


@persistent
def _start_anew(*_: object) -> None:
    """A file was opened. What is animated is put where its curves have it after this call, which
    may be elsewhere than when the file was saved; Blender tells of no update then."""
    global _rendering, _rendered
    _rendering = _rendered = False  # no render outlives its file
    live.forget_all()
    _problems.clear()
    # Without a window no timer runs, and one left over makes Blender as a module crash at exit.
    if not bpy.app.background:
        bpy.app.timers.register(_look_at_all)


def _look_at_all() -> None:
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.tug.bound:
            obj.update_tag()


HANDLERS = (
    ("frame_change_post", _pose_all),
    ("depsgraph_update_post", _pose_updated),
    ("undo_post", _touch_all),
    ("redo_post", _touch_all),
    ("load_post", _start_anew),
    ("render_init", _start_render),
    ("render_complete", _end_render),
    ("render_cancel", _end_render),
)


def register() -> None:
    for name, function in HANDLERS:
        getattr(bpy.app.handlers, name).append(function)
    if not bpy.app.background:
        bpy.app.timers.register(_watch, persistent=True)


def unregister() -> None:
    for name, function in HANDLERS:
        getattr(bpy.app.handlers, name).remove(function)
    for function in (_look_at_all, _watch):
        if bpy.app.timers.is_registered(function):
            bpy.app.timers.unregister(function)
