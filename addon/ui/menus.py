# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu Object > Tug, in Edit Mode Mesh > Tug, by which F3 finds everything too."""

from __future__ import annotations

import bpy
from bpy.types import Context, Menu


class TUG_MT_add_handles(Menu):
    bl_label = "Add Handles"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.operator("tug.click_handles", icon="CURSOR")
        layout.operator("tug.add_handles_on_vertices", icon="VERTEXSEL")
        layout.operator("tug.add_handles", icon="STICKY_UVS_DISABLE")
        layout.operator("tug.add_handles_on_bones", icon="BONE_DATA")


class TUG_MT_tug(Menu):
    bl_label = "Tug"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        layout.operator("tug.set_up")
        layout.operator("tug.bind")
        layout.operator("tug.unbind")
        layout.operator("tug.drag")
        layout.operator("tug.update_pose")
        layout.separator()
        layout.menu("TUG_MT_add_handles")
        layout.operator("tug.mirror_handles")
        layout.operator("tug.put_handle")
        layout.operator("tug.select_handles")
        layout.operator("tug.delete_handle")
        layout.operator("tug.make_handles_own")
        layout.separator()
        layout.operator("tug.copy_pose")
        layout.operator("tug.paste_pose").flipped = False
        layout.operator("tug.paste_pose", text="Paste Pose Flipped").flipped = True
        layout.operator("tug.mirror_pose")
        layout.operator("tug.pose_from_key")
        layout.operator("tug.reset_pose")
        layout.operator("tug.keyframe_handles")
        layout.operator("tug.save_pose")
        layout.separator()
        layout.operator("tug.bake")
        layout.operator("tug.remove_bake")
        layout.operator("tug.fit")
        layout.operator("tug.fit_frames")
        layout.operator("tug.store_colours")
        layout.separator()
        layout.operator("tug.open_sample")


def draw_tug(menu: Menu, _context: Context) -> None:
    menu.layout.separator()
    menu.layout.menu("TUG_MT_tug")


HOMES = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh")
CLASSES = (TUG_MT_add_handles, TUG_MT_tug)


def register() -> None:
    for menu in HOMES:
        getattr(bpy.types, menu).append(draw_tug)


def unregister() -> None:
    for menu in HOMES:
        getattr(bpy.types, menu).remove(draw_tug)
