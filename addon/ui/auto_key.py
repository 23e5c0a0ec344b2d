# SPDX-License-Identifier: GPL-3.0-or-later
"""Auto Keying: a handle that was moved is keyed where the scene asks for it, as Blender does."""

from __future__ import annotations

from collections.abc import Iterator

import bpy


def key_location(context: bpy.types.Context, empty: bpy.types.Object) -> None:
    """Key the location of an object, or what the active keying set says, if Auto Keying is on."""
    settings = context.scene.tool_settings
    if not settings.use_keyframe_insert_auto:
        return
    keying_set = context.scene.keying_sets_all.active
    paths = [("location", -1)]
    # Blender's keying sets ask the editor what is selected; a script has none.
    if settings.use_keyframe_insert_keyingset and keying_set and context.area:
        paths = list(_paths(context, keying_set, empty))
    for path, index in paths:
        empty.keyframe_insert(path, index=index, options=_options(context))


def _paths(
    context: bpy.types.Context, keying_set: bpy.types.KeyingSet, empty: bpy.types.Object
) -> Iterator[tuple[str, int]]:
    """Paths and indices (-1 for all) that the set has for the object."""
    with context.temp_override(object=empty, selected_objects=[empty]):
        keying_set.refresh()
    for path in keying_set.paths:
        if path.id == empty:
            yield path.data_path, -1 if path.use_entire_array else path.array_index


def _options(context: bpy.types.Context) -> set[str]:
    settings, edit = context.scene.tool_settings, context.preferences.edit
    wanted = {
        "INSERTKEY_NEEDED": edit.use_auto_keyframe_insert_needed,
        "INSERTKEY_AVAILABLE": edit.use_keyframe_insert_available,
        "INSERTKEY_VISUAL": edit.use_visual_keying,
        "INSERTKEY_REPLACE": settings.auto_keying_mode == "REPLACE_KEYS",
        "INSERTKEY_CYCLE_AWARE": settings.use_keyframe_cycle_aware,
    }
    return {option for option, is_wanted in wanted.items() if is_wanted}
