# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of handles and of example shapes."""

from __future__ import annotations

import bpy
from bpy.types import AnyType, Context, UILayout, UIList

from ..rigging import inputs
from . import state

HOLD_ICONS = {"PINNED": "PINNED", "SOFT": "MOD_SOFT", "FREE": "UNPINNED"}


class TUG_UL_handles(UIList):
    """Name, how each is held, and a button that selects it."""

    def draw_item(
        self,
        _context: Context,
        layout: UILayout,
        _data: AnyType,
        handle: AnyType,
        _icon: int,
        _active: AnyType,
        _property: str,
        index: int,
    ) -> None:
        row = layout.row(align=True)
        if handle.empty is None:
            row.label(text=f"{handle.name} (deleted)", icon="ERROR")
            return
        row.prop(handle, "title", text="", emboss=False, icon="EMPTY_DATA")
        if handle.hold == "SOFT":
            row.prop(handle, "firmness", text="")
        row.prop(handle, "hold", text="", icon_only=True, icon=HOLD_ICONS[handle.hold])
        icon = "RESTRICT_SELECT_OFF" if handle.empty.select_get() else "RESTRICT_SELECT_ON"
        row.operator("tug.select_handles", text="", icon=icon, emboss=False).index = index


class TUG_UL_examples(UIList):
    """Shape keys, each with a box to tick; Basis and the result are not to choose."""

    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        _data: AnyType,
        block: AnyType,
        _icon: int,
        _active: AnyType,
        _property: str,
    ) -> None:
        row = layout.row(align=True)
        use = block.name in inputs.ticked(state.rig_of(context))
        icon = "CHECKBOX_HLT" if use else "CHECKBOX_DEHLT"
        row.operator("tug.tick_example", text="", icon=icon, emboss=False).key = block.name
        row.prop(block, "name", text="", emboss=False, icon="SHAPEKEY_DATA")

    def filter_items(
        self, context: Context, data: AnyType, member: str
    ) -> tuple[list[int], list[int]]:
        blocks, obj = getattr(data, member), state.rig_of(context)
        kept = bpy.types.UI_UL_list.filter_items_by_name(
            self.filter_name, self.bitflag_filter_item, blocks, "name"
        ) or [self.bitflag_filter_item] * len(blocks)
        hidden = (data.reference_key.name, obj.tug.result)
        for number, block in enumerate(blocks):
            if block.name in hidden:
                kept[number] = 0
        return kept, []


CLASSES = (TUG_UL_handles, TUG_UL_examples)
