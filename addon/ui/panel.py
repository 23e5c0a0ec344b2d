# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the sidebar of the 3D view: what to do next first, and below it everything else."""

from __future__ import annotations

import textwrap

from bpy.types import Context, Object, Panel, UILayout

from .. import handlers
from ..caches import mesh_cache
from ..rigging import handles
from . import state, work

PIXELS_A_CHARACTER = 7  # at a scale of one


class Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Tug"


class OnRig(Sidebar):
    """A part of the panel for a mesh with shape keys."""

    bl_parent_id = "TUG_PT_tug"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return not state.missing(context, state.keys)


class TUG_PT_tug(Sidebar, Panel):
    bl_label = "Tug"

    def draw(self, context: Context) -> None:
        layout, obj = self.layout, state.rig_of(context)
        if obj is None:
            say(context, layout, "Select a mesh with shape keys, or try the sample", "INFO")
            layout.operator("tug.open_sample", icon="MONKEY")
        elif obj.data.shape_keys is None:
            say(context, layout, state.keys(obj), "INFO")
            layout.operator("object.shape_key_add", text="Add Shape Key", icon="ADD")
            layout.operator("tug.open_sample", icon="MONKEY")
        else:
            layout.label(text=obj.name, icon="MESH_DATA")
            if running := work.running(obj):
                layout.progress(factor=running.fraction, text=sentence(running.stage))
                return
            draw_state(context, layout, obj)
            draw_next(context, layout, obj)


def draw_state(context: Context, layout: UILayout, obj: Object) -> None:
    """Not bound, bound, or stale and why."""
    reason = state.stale(obj, context.scene) if obj.tug.bound else ""
    if not obj.tug.bound:
        count = len(obj.tug.handles)
        text, icon = f"Not bound, {count} handles" if count else "No handles yet", "INFO"
    elif reason:
        text, icon = reason, "ERROR"
    elif mesh_cache.shown(obj, "VIEWPORT"):
        text, icon = "Shows its bake", "RENDER_ANIMATION"
    elif state.local(obj):
        text, icon = "Linked: bake it to see it move", "LIBRARY_DATA_DIRECT"
    else:
        text, icon = state.pending(obj) or "Bound", "LINKED"
    say(context, layout, text, icon)
    if text == "Bound" and (last := state.last_solve(obj)):
        layout.label(text=last, icon="TIME")
    if others := handles.sharing(obj):
        say(context, layout, f"Shares its handles with {others[0].name}", "LIBRARY_DATA_OVERRIDE")
        layout.operator("tug.make_handles_own", icon="DUPLICATE")


def draw_next(context: Context, layout: UILayout, obj: Object) -> None:
    """The one thing to do now, larger than the rest."""
    big = layout.column(align=True)
    big.scale_y = 1.5
    if not obj.tug.handles:
        big.operator("tug.set_up", icon="PLAY")
    elif not obj.tug.bound:
        big.operator("tug.bind", icon="LINKED")
    elif state.stale(obj, context.scene) or state.pending(obj):
        big.operator("tug.bind", text="Bind Again", icon="FILE_REFRESH")
    if obj.tug.bound:
        tool = context.workspace.tools.from_space_view3d_mode(context.mode)
        dragging = tool is not None and tool.idname == "tug.drag"
        choose = big.operator("wm.tool_set_by_id", text="Drag", icon="VIEW_PAN", depress=dragging)
        choose.name = "tug.drag"
        row = layout.row(align=True)
        row.prop(obj.tug, "live", toggle=True, icon="PLAY")
        row.operator("tug.update_pose", text="", icon="FILE_REFRESH")
        row.operator("tug.unbind", text="", icon="UNLINKED")


class TUG_PT_handles(OnRig, Panel):
    bl_label = "Handles"
    bl_options = set()

    def draw(self, context: Context) -> None:
        layout, obj = self.layout, state.rig_of(context)
        row = layout.row()
        row.template_list(
            *("TUG_UL_handles", "", obj.tug, "handles", obj.tug, "active_handle"), rows=4
        )
        column = row.column(align=True)
        column.menu("TUG_MT_add_handles", text="", icon="ADD")
        column.operator("tug.delete_handle", text="", icon="REMOVE")
        column.separator()
        column.operator("tug.select_handles", text="", icon="RESTRICT_SELECT_OFF").index = -1
        column.operator("tug.mirror_handles", text="", icon="MOD_MIRROR")
        if obj.data.is_editmode:
            layout.operator("tug.add_handles_on_vertices", text="Add on Selected", icon="ADD")
            layout.operator("tug.put_handle", icon="SNAP_VERTEX")
        draw_hold(layout, obj)


def draw_hold(layout: UILayout, obj: Object) -> None:
    """How the active handle is held, with dots to key it."""
    number = obj.tug.active_handle
    if not 0 <= number < len(obj.tug.handles) or obj.tug.handles[number].empty is None:
        return
    handle, column = obj.tug.handles[number], layout.column()
    column.use_property_split = True
    column.prop(handle, "hold")
    sub = column.column()
    sub.active = handle.hold == "SOFT"
    sub.prop(handle, "firmness")
    column.use_property_decorate = False
    column.prop(handle.empty, "empty_display_type", text="Display")
    column.prop(handle.empty, "empty_display_size", text="Size")
    column.prop(handle.empty, "show_name", text="Name")


class TUG_PT_examples(OnRig, Panel):
    bl_label = "Examples"

    def draw(self, context: Context) -> None:
        obj = state.rig_of(context)
        keys = obj.data.shape_keys
        self.layout.template_list(
            *("TUG_UL_examples", "", keys, "key_blocks", obj, "active_shape_key_index"), rows=4
        )


class TUG_PT_method(OnRig, Panel):
    bl_label = "Method"

    def draw(self, context: Context) -> None:
        layout, obj = self.layout, state.rig_of(context)
        rig = obj.tug
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(rig, "dictionary")
        layout.prop(rig, "form")
        column = layout.column(align=True)
        column.prop(rig, "selectivity")
        column.prop(rig, "steadiness")
        column.prop(rig, "group_count")
        column = layout.column(heading="Blend")
        column.prop(rig, "single_blend")
        column.prop(rig, "squared")
        layout.prop(rig, "follow_size")
        layout.prop(rig, "follow_nearest")
        column = layout.column(align=True)
        column.prop_search(rig, "stiffness_group", obj, "vertex_groups")
        sub = column.column()
        sub.active = bool(rig.stiffness_group)
        sub.prop(rig, "stiffness_max")


class TUG_PT_colours(OnRig, Panel):
    bl_label = "Colours"

    def draw(self, context: Context) -> None:
        self.layout.prop(context.window_manager, "tug_colours", text="Show")
        self.layout.operator("tug.store_colours", icon="GROUP_VCOL")


class TUG_PT_poses(OnRig, Panel):
    bl_label = "Poses"

    def draw(self, _context: Context) -> None:
        layout = self.layout
        row = layout.row(align=True)
        row.operator("tug.copy_pose", text="Copy", icon="COPYDOWN")
        row.operator("tug.paste_pose", text="Paste", icon="PASTEDOWN").flipped = False
        row.operator("tug.paste_pose", text="", icon="PASTEFLIPDOWN").flipped = True
        column = layout.column(align=True)
        column.operator_menu_enum("tug.pose_from_key", "key", icon="SHAPEKEY_DATA")
        column.operator("tug.mirror_pose", icon="MOD_MIRROR")
        column.operator("tug.reset_pose", icon="LOOP_BACK")
        column = layout.column(align=True)
        column.operator("tug.keyframe_handles", icon="KEY_HLT")
        column.operator("tug.save_pose", icon="ADD")


class TUG_PT_bake(OnRig, Panel):
    bl_label = "Bake"

    def draw(self, context: Context) -> None:
        layout, obj = self.layout, state.rig_of(context)
        layout.operator("tug.bake", icon="RENDER_ANIMATION")
        modifier = obj.modifiers.get(mesh_cache.NAME)
        if modifier is not None:
            layout.prop(modifier, "show_viewport", text="Show Bake")
            layout.operator("tug.remove_bake", icon="X")
        if text := handlers.render_risk(context.scene):
            say(context, layout, text, "INFO")
            layout.prop(context.scene.render, "use_lock_interface")


class TUG_PT_fit(OnRig, Panel):
    bl_label = "Fit"

    def draw(self, context: Context) -> None:
        layout, rig = self.layout, state.rig_of(context).tug
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(rig, "fit_target")
        layout.prop(rig, "fit_markers")
        column = layout.column(align=True)
        column.prop(rig, "fit_reach")
        column.prop(rig, "fit_firmness")
        column = layout.column(align=True)
        column.operator("tug.fit", icon="MOD_SHRINKWRAP")
        column.operator("tug.fit_frames", icon="RENDER_ANIMATION")


def say(context: Context, layout: UILayout, text: str, icon: str) -> None:
    """A text on as many lines as the panel's width asks for."""
    scale = context.preferences.system.ui_scale * PIXELS_A_CHARACTER
    width = context.region.width / scale - 6 if context.region else 40
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(text, max(width, 16))):
        column.label(text=line, icon="BLANK1" if number else icon)


def sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


CLASSES = (
    TUG_PT_tug,
    TUG_PT_handles,
    TUG_PT_poses,
    TUG_PT_examples,
    TUG_PT_method,
    TUG_PT_colours,
    TUG_PT_bake,
    TUG_PT_fit,
)
