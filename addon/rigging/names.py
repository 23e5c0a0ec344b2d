# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that an artist changes, of shape keys and of handles, are taken over by the rig."""

from __future__ import annotations

import json

import bpy
from bpy.app.handlers import persistent

from . import handles, inputs

_owner = object()  # of the subscriptions


def follow(obj: bpy.types.Object) -> None:
    """Look at a rig's names. Shape keys are told apart by their order, so that one which is renamed
    when others come or go is taken for deleted."""
    rig, keys = obj.tug, obj.data.shape_keys
    for handle in rig.handles:
        if handle.empty is not None and handle.empty.name != handle.name:
            handles.follow_name(obj, handle)
    if not rig.bound or keys is None:
        return
    before, now = json.loads(rig.key_names or "[]"), list(keys.key_blocks.keys())
    if before == now:
        return
    if len(before) == len(now):
        pairs = zip(before, now, strict=True)
        _rename(rig, {old: new for old, new in pairs if old not in now and new not in before})
    rig.key_names = json.dumps(now)


def _rename(rig: bpy.types.PropertyGroup, names: dict[str, str]) -> None:
    """names: new ones by old ones."""
    examples = inputs.bound_examples(rig.id_data)
    rig.examples = json.dumps([names.get(name, name) for name in examples])
    rig.result = names.get(rig.result, rig.result)
    for shape in rig.shapes:
        shape.name = names.get(shape.name, shape.name)


def _follow_all() -> None:
    for obj in bpy.data.objects:
        if obj.type == "MESH" and len(obj.tug.handles) and not inputs.is_linked(obj):
            follow(obj)


@persistent
def _subscribe(*_: object) -> None:
    """Blender forgets subscriptions when it loads a file."""
    bpy.msgbus.clear_by_owner(_owner)
    for kind in (bpy.types.ShapeKey, bpy.types.Object):
        bpy.msgbus.subscribe_rna(key=(kind, "name"), owner=_owner, args=(), notify=_follow_all)


def register() -> None:
    bpy.app.handlers.load_post.append(_subscribe)
    _subscribe()


def unregister() -> None:
    bpy.msgbus.clear_by_owner(_owner)
    bpy.app.handlers.load_post.remove(_subscribe)
