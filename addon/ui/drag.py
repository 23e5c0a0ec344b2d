# SPDX-License-Identifier: GPL-3.0-or-later
"""A handle on its way, with the mesh that follows it, and the way back."""

from __future__ import annotations

import bpy
from mathutils import Matrix, Vector

from ..caches import mesh_cache
from ..rigging import live, rig, shape_keys
from ..rigging.inputs import RigError
from .auto_key import key_location


class Drag:
    """Moves one handle of a bound rig and poses the mesh.

    The handle becomes the only selected one, so that its keys show in the timeline; what is active
    stays. Raises RigError where the rig cannot be posed.
    """

    def __init__(
        self, context: bpy.types.Context, obj: bpy.types.Object, empty: bpy.types.Object
    ) -> None:
        live.check(obj, context.scene)
        if mesh_cache.shown(obj, "VIEWPORT"):
            raise RigError(f'"{obj.name}" shows its bake: hide the modifier in the viewport first')
        self.obj, self.empty = obj, empty
        self._layer = context.view_layer
        self._settle()
        self.start = empty.matrix_world.translation.copy()
        self.selected_anew = not empty.select_get()
        self._location = empty.location.copy()
        self._to_location = _to_location(empty)
        self._posed = obj.tug.get(live.POSED)
        self._pose = shape_keys.coordinates(self._result())
        self._selected = {
            handle.empty: handle.empty.select_get()
            for handle in obj.tug.handles
            if handle.empty is not None
        }
        for other in self._selected:
            other.select_set(other == empty)

    @property
    def moved(self) -> Vector:
        """How far the handle got, which constraints and locks may keep from where it is pulled."""
        return self.empty.matrix_world.translation - self.start

    def pull(self, offset: Vector) -> None:
        """Put the handle that far from its first place, in the world, and pose the mesh."""
        change = self._to_location @ offset
        for axis, locked in enumerate(self.empty.lock_location):
            if locked:
                change[axis] = 0.0
        self.empty.location = self._location + change
        self._layer.update()
        rig.follow(self.obj, self._layer.depsgraph)

    def finish(self, context: bpy.types.Context) -> None:
        key_location(context, self.empty)

    def restore(self) -> None:
        """Everything as it was before, to the last bit."""
        for empty, selected in self._selected.items():
            empty.select_set(selected)
        self.empty.location = self._location
        self._layer.update()
        shape_keys.write(self.obj.data, self._result(), self._pose)
        if self._posed is None:
            live.invalidate(self.obj)
        else:
            self.obj.tug[live.POSED] = self._posed

    def _settle(self) -> None:
        """After an undo, Blender shows what is animated where its curves have it, whatever its
        location says. Let it be where it is shown."""
        shown = self.empty.matrix_world.translation.copy()
        self.empty.update_tag(refresh={"OBJECT"})
        self._layer.update()
        if self.empty.matrix_world.translation != shown:
            self.empty.update_tag(refresh={"TIME"})
            self._layer.update()

    def _result(self) -> bpy.types.ShapeKey:
        return self.obj.data.shape_keys.key_blocks[self.obj.tug.result]


def _to_location(empty: bpy.types.Object) -> Matrix:
    """What a change of place in the world means for the location, before constraints: 3 by 3."""
    parent, frame = empty.parent, Matrix.Identity(3)
    if parent is not None and not empty.parent_type.startswith("VERTEX"):
        frame = parent.matrix_world.to_3x3()
        bone = parent.pose.bones.get(empty.parent_bone) if parent.pose else None
        if bone is not None and empty.parent_type == "BONE":
            is_relative = bone.bone.use_relative_parent
            frame @= (bone.matrix_channel if is_relative else bone.matrix).to_3x3()
    if parent is not None:
        frame @= empty.matrix_parent_inverse.to_3x3()
    return frame.inverted_safe()
