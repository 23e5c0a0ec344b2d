# SPDX-License-Identifier: GPL-3.0-or-later
"""Reset, keep, copy, paste, mirror and key poses."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Context, Event, Object, Operator

from ..rigging import inputs, poses, rig
from ..rigging.inputs import RigError
from . import state
from .auto_key import key_location
from .rig_operator import RigOperator

# What was copied last. It outlives files, so that poses go from one to the next.
_copied: poses.Places = {}

POSING = (state.keys, state.handles)


class TUG_OT_reset_pose(RigOperator, Operator):
    """Put all handles back where the mesh has them at rest"""

    bl_idname = "tug.reset_pose"
    bl_label = "Reset Pose"
    needs = POSING

    def act(self, context: Context, obj: Object) -> None:
        put(context, obj, poses.rest(obj))


class TUG_OT_pose_from_key(RigOperator, Operator):
    """Put all handles where a shape key has them"""

    bl_idname = "tug.pose_from_key"
    bl_label = "Pose from Example"
    bl_property = "key"
    needs = POSING

    def _keys(self, context: Context) -> list[tuple[str, str, str]]:
        # Blender keeps no copy of the texts: they must stay alive.
        obj = state.rig_of(context)
        type(self)._items = [(name, name, "") for name in (inputs.ticked(obj) if obj else ())]
        return type(self)._items

    key: EnumProperty(name="Shape Key", description="The pose to take", items=_keys)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def act(self, context: Context, obj: Object) -> None:
        put(context, obj, poses.of_key(obj, self.key))


class TUG_OT_copy_pose(RigOperator, Operator):
    """Remember where all handles are, for this mesh or another with handles of the same names"""

    bl_idname = "tug.copy_pose"
    bl_label = "Copy Pose"
    bl_options = {"REGISTER"}
    needs = (state.handles,)

    def act(self, context: Context, obj: Object) -> str:
        _copied.clear()
        _copied.update(poses.current(obj, context.evaluated_depsgraph_get()))
        return "Pose copied"


class TUG_OT_paste_pose(RigOperator, Operator):
    """Put the handles where the copied pose has them"""

    bl_idname = "tug.paste_pose"
    bl_label = "Paste Pose"

    @staticmethod
    def copied(_obj: Object) -> str:
        return "" if _copied else "Copy a pose first"

    needs = (*POSING, copied)

    flipped: BoolProperty(
        name="Flipped", description="Change the left and the right side over", default=False
    )

    def act(self, context: Context, obj: Object) -> str:
        places = poses.mirrored(obj, _copied) if self.flipped else _copied
        count = put(context, obj, places)
        if not count:
            raise RigError(
                f'the copied pose has no handle of "{obj.name}": their names are '
                f"{', '.join(_copied)}"
            )
        return f"{count} handles posed"


class TUG_OT_mirror_pose(RigOperator, Operator):
    """Change the left and the right side of the pose over, by names that end in .L and .R"""

    bl_idname = "tug.mirror_pose"
    bl_label = "Mirror Pose"
    needs = POSING

    def act(self, context: Context, obj: Object) -> None:
        now = poses.current(obj, context.evaluated_depsgraph_get())
        put(context, obj, poses.mirrored(obj, now))


class TUG_OT_keyframe_handles(RigOperator, Operator):
    """Key the location of all handles at this frame"""

    bl_idname = "tug.keyframe_handles"
    bl_label = "Keyframe All Handles"
    needs = (state.handles,)

    def act(self, _context: Context, obj: Object) -> None:
        poses.keyframe(obj)


class TUG_OT_save_pose(RigOperator, Operator):
    """Keep the pose as a new shape key. It becomes an example: later poses draw on it"""

    bl_idname = "tug.save_pose"
    bl_label = "Save Pose as Shape Key"
    needs = (state.local, state.bound, state.out_of_edit_mode, state.up_to_date)

    key_name: StringProperty(name="Name", description="Of the new shape key", default="Pose")
    use: BoolProperty(
        name="Use as Example", description="Bind again, with the new shape key", default=True
    )

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def act(self, _context: Context, obj: Object) -> str:
        block = poses.save(obj, self.key_name)
        if self.use:
            bpy.ops.tug.bind("INVOKE_DEFAULT")
        else:
            inputs.tick(obj, block.name, use=False)
        return f'Saved as "{block.name}"'


class TUG_OT_update_pose(RigOperator, Operator):
    """Pose the mesh for where the handles are now. For a mesh that is not live"""

    bl_idname = "tug.update_pose"
    bl_label = "Update Pose"
    needs = (state.local, state.bound, state.out_of_edit_mode)

    def act(self, context: Context, obj: Object) -> None:
        rig.solve(obj, context.evaluated_depsgraph_get())


def put(context: Context, obj: Object, places: poses.Places) -> int:
    """Move the handles that have a place, and key them where Auto Keying is on; how many."""
    moved = poses.put(obj, places)
    for empty in moved:
        key_location(context, empty)
    return len(moved)


CLASSES = (
    TUG_OT_reset_pose,
    TUG_OT_pose_from_key,
    TUG_OT_copy_pose,
    TUG_OT_paste_pose,
    TUG_OT_mirror_pose,
    TUG_OT_keyframe_handles,
    TUG_OT_save_pose,
    TUG_OT_update_pose,
)
