# SPDX-License-Identifier: GPL-3.0-or-later
"""The weight functions of a rig as its file keeps them, so that a pose is a function of the file.

Weights that are positive live in vertex groups, where an artist sees and paints them: one for each
handle, for each bone that was found, or those of the artist. Eigenfunctions have both signs, and
their edge groups do not follow from them: they live in attributes of the mesh, with names that
begin with a dot, which Blender does not list.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, islice

import bpy
import numpy as np

from ..dictionaries import (
    GROUPS_A_HANDLE,
    Dictionary,
    Functions,
    functions_of_weights,
    make_functions,
)
from ..geometry import Mesh
from ..native import Progress
from ..parts import make_followed_functions
from ..weights import compute_weights
from . import vertex_groups
from .inputs import Inputs, RigError, digest

VERTEX_GROUPS = "VERTEX_GROUPS"  # the kind of dictionary that only a rig in Blender has

FUNCTION = ".tug_function_{}"  # floats of the vertices, numbered from 0
EDGE_GROUP = ".tug_group"  # integers of the faces
BONE = "Tug Bone {}"  # vertex groups, numbered from 1

SAME = 1e-5  # of a vertex group, what may be left when others are taken away

WHAT_TO_DO = {
    Dictionary.HANDLES: "belong to no handle, the first is vertex {vertex}: paint them into a "
    "handle's vertex group, or delete the groups {names} to have all weights computed anew",
    Dictionary.SKELETON: "belong to no bone, the first is vertex {vertex}: paint them into one of "
    "the groups {names}, or delete these to have the bones found anew",
    VERTEX_GROUPS: "are in none of the vertex groups {names}, the first is vertex {vertex}: give "
    "them a weight in one, or let something else deform the mesh",
}


@dataclass(frozen=True)
class Stored:
    """weights: #V by #W float32. groups: edge groups, #F, or None: clusters of the weights."""

    weights: np.ndarray
    groups: np.ndarray | None = None

    def functions(
        self, mesh: Mesh, group_count: int, progress: Progress | None = None
    ) -> Functions:
        """What a model is made from. group_count: as for functions_of_weights."""
        weights = self.weights.astype(np.float64)
        if self.groups is None:
            return functions_of_weights(mesh, weights, group_count, progress=progress)
        return Functions(weights, self.groups)


def group_count(obj: bpy.types.Object, handle_count: int) -> int:
    """How many edge groups to ask for; 0 for as many as suit the dictionary."""
    if obj.tug.dictionary == Dictionary.HANDLES:
        return obj.tug.group_count or GROUPS_A_HANDLE * handle_count
    return obj.tug.group_count


def compute(
    kind: str,
    mesh: Mesh,
    given: Inputs,
    group_count: int,
    *,
    follow_nearest: bool,
    progress: Progress | None,
) -> Stored:
    """The functions of a dictionary as they will be stored. Touches nothing of Blender."""
    if kind == Dictionary.HANDLES:
        weights, _ = compute_weights(
            mesh,
            [[vertex] for vertex in given.handles],
            follow_nearest=follow_nearest,
            progress=progress,
        )
        return Stored(vertex_groups.rounded(weights))
    make = make_followed_functions if follow_nearest else make_functions
    made = make(
        *(Dictionary(kind), mesh, given.solved_shapes, given.handles),
        group_count=group_count,
        progress=progress,
    )
    if kind == Dictionary.SKELETON:
        return Stored(vertex_groups.rounded(made.weights))
    groups = _of_whole_faces(made.groups, given.faces)
    return Stored(made.weights.astype(np.float32), groups)


def to_bind(
    obj: bpy.types.Object, handles: Sequence[bpy.types.PropertyGroup], given: Inputs
) -> Stored | None:
    """What the object has for a bind to these handles; None where the bind must compute it.

    Raises RigError where computing it would overwrite what the artist painted.
    """
    match obj.tug.dictionary:
        case Dictionary.HANDLES:
            return _handles_to_bind(obj, handles)
        case Dictionary.SKELETON:
            return _bones_to_bind(obj, given)
        case Dictionary.EIGENFUNCTIONS:
            return None
        case _:
            return _read_independent_groups(obj, _groups_of_the_artist(obj))


def read(obj: bpy.types.Object, given: Inputs) -> Stored:
    """What a bound object has."""
    if obj.tug.dictionary != Dictionary.EIGENFUNCTIONS:
        return _read_groups(obj, _names(obj))
    attributes, faces = obj.data.attributes, np.empty(len(obj.data.polygons), np.int32)
    weights = np.empty((obj.tug.function_count, len(obj.data.vertices)), np.float32)
    for number, function in enumerate(weights):
        attributes[FUNCTION.format(number)].data.foreach_get("value", function)
    attributes[EDGE_GROUP].data.foreach_get("value", faces)
    return Stored(np.ascontiguousarray(weights.T), faces[given.faces])


def changed(obj: bpy.types.Object) -> str:
    """Why what a bind stored no longer serves, or an empty string. Microseconds."""
    rig = obj.tug
    if rig.dictionary != (rig.bound_dictionary or Dictionary.HANDLES):
        return "something else is to deform it"
    if rig.dictionary == Dictionary.EIGENFUNCTIONS:
        if rig.group_count != rig.bound_group_count:
            return "its number of parts was changed"
        names = [EDGE_GROUP, *map(FUNCTION.format, range(rig.function_count))]
        if any(name not in obj.data.attributes for name in names):
            return "the functions that Tug keeps with its mesh were deleted"
    else:
        for name in _names(obj):
            if name not in obj.vertex_groups:
                return f'its vertex group "{name}" was deleted or renamed'
    return ""


def keep(obj: bpy.types.Object, given: Inputs, stored: Stored, *, computed: bool) -> None:
    """Write what a bind made, and drop what other dictionaries left. The handles are those of the
    bind."""
    rig = obj.tug
    kind = rig.dictionary
    _drop_others(obj)
    match kind:
        case Dictionary.HANDLES:
            _keep_handles(obj, stored, computed=computed)
        case Dictionary.SKELETON if computed:
            _keep_bones(obj, given, stored)
        case Dictionary.EIGENFUNCTIONS:
            _keep_attributes(obj.data, given, stored)
            rig.function_count = stored.weights.shape[1]
            rig.bound_group_count = rig.group_count
        case _ if kind == VERTEX_GROUPS:
            rig.groups = json.dumps(_groups_of_the_artist(obj))
    rig.bound_dictionary = kind
    rig.dictionary = kind  # set, so that it is what it is whatever the default becomes


def drop_attributes(mesh: bpy.types.Mesh) -> None:
    for name in [EDGE_GROUP, *_function_attributes(mesh)]:
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])


def drop_handle(obj: bpy.types.Object, number: int) -> None:
    """Take a handle off the rig, and its group if it is as a bind wrote it."""
    handle = obj.tug.handles[number]
    if handle.group in _written(obj, [handle]):
        obj.vertex_groups.remove(obj.vertex_groups[handle.group])
    obj.tug.handles.remove(number)


def _of_whole_faces(groups: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Edge groups that do not divide a face: #F, numbered without gaps. A face has the group of its
    first triangle."""
    _, first, face = np.unique(faces, return_index=True, return_inverse=True)
    return np.unique(groups[first], return_inverse=True)[1][face].astype(np.int32)


def _names(obj: bpy.types.Object) -> list[str]:
    """The vertex groups that a bound object draws on."""
    match obj.tug.dictionary:
        case Dictionary.HANDLES:
            return [handle.group for handle in obj.tug.handles]
        case Dictionary.SKELETON:
            return [bone.group for bone in obj.tug.bones]
        case _:
            return json.loads(obj.tug.groups)


def _read_groups(obj: bpy.types.Object, names: Sequence[str]) -> Stored:
    weights = vertex_groups.read(obj, names)
    lost = np.flatnonzero(weights.sum(axis=1) <= 0)
    if len(lost):
        told = WHAT_TO_DO[obj.tug.dictionary].format(vertex=lost[0], names=", ".join(names))
        raise RigError(f'{len(lost)} vertices of "{obj.name}" {told}')
    return Stored(weights)


def _groups_of_the_artist(obj: bpy.types.Object) -> list[str]:
    """Those of the bones that deform the object; without any bone, all that are not Tug's."""
    armatures = [each.object for each in obj.modifiers if each.type == "ARMATURE"]
    bones = {
        bone.name
        for armature in (*armatures, obj.find_armature())
        if armature is not None
        for bone in armature.data.bones
        if bone.use_deform
    }
    rig, names = obj.tug, _filled_groups(obj)
    ours = {
        *(handle.group for handle in rig.handles),
        *(bone.group for bone in rig.bones),
        rig.stiffness_group,
    }
    found = [name for name in names if name in bones] or [
        name for name in names if name not in ours
    ]
    if not found:
        raise RigError(
            f'"{obj.name}" has no vertex groups to be deformed by: give it an armature with '
            "weights, or paint some, or let something else deform the mesh"
        )
    return found


def _filled_groups(obj: bpy.types.Object) -> list[str]:
    names = [group.name for group in obj.vertex_groups]
    filled = vertex_groups.read(obj, names).any(axis=0)
    return [name for name, has_weights in zip(names, filled, strict=True) if has_weights]


def _read_independent_groups(obj: bpy.types.Object, names: Sequence[str]) -> Stored:
    stored = _read_groups(obj, names)
    lengths = np.linalg.norm(stored.weights, axis=0)
    left = np.abs(np.diag(np.linalg.qr(stored.weights.astype(np.float64), mode="r")))
    if len(same := np.flatnonzero(left <= SAME * lengths)):
        raise RigError(
            f'the vertex group "{names[same[0]]}" of "{obj.name}" is the sum of others, or the '
            "same as another, and moves nothing by itself: delete it or paint it otherwise"
        )
    return stored


# Handles ----------------------------------------------------------------------------------------


def _group(handle: bpy.types.PropertyGroup) -> str:
    return handle.group or handle.empty.name


def _handles_to_bind(
    obj: bpy.types.Object, handles: Sequence[bpy.types.PropertyGroup]
) -> Stored | None:
    present = [_group(handle) for handle in handles if _group(handle) in obj.vertex_groups]
    deleted = sum(1 for h in obj.tug.handles if h.group) > sum(1 for h in handles if h.group)
    moved = any(h.group and h.rest_vertex != h.vertex for h in handles)
    if len(present) == len(handles) and not deleted and not moved:
        return _read_groups(obj, present)
    written = _written(obj, obj.tug.handles)
    _refuse_painted(obj, "handles", [name for name in present if name not in written])
    return None


def _keep_handles(obj: bpy.types.Object, stored: Stored, *, computed: bool) -> None:
    handles = obj.tug.handles
    names = [_group(handle) for handle in handles]
    if computed:
        vertex_groups.write(obj, names, stored.weights)
    for number, handle in enumerate(handles):
        handle.group = names[number]
        if computed:
            handle.computed_weights = digest(stored.weights[:, number])


# Bones ------------------------------------------------------------------------------------------


def _bones_to_bind(obj: bpy.types.Object, given: Inputs) -> Stored | None:
    """Bones are found anew when the shapes have changed, but not where they were painted."""
    bones = obj.tug.bones
    present = [bone.group for bone in bones if bone.group in obj.vertex_groups]
    written = _written(obj, bones)
    painted = [name for name in present if name not in written]
    whole = bool(bones) and len(present) == len(bones)
    if whole and (painted or obj.tug.bones_source == _source(given)):
        return _read_groups(obj, present)
    _refuse_painted(obj, "bones", painted)
    return None


def _keep_bones(obj: bpy.types.Object, given: Inputs, stored: Stored) -> None:
    _drop_groups(obj, [bone.group for bone in obj.tug.bones])
    obj.tug.bones.clear()
    unused = (name for name in map(BONE.format, count(1)) if name not in obj.vertex_groups)
    names = list(islice(unused, stored.weights.shape[1]))
    vertex_groups.write(obj, names, stored.weights)
    for name, column in zip(names, stored.weights.T, strict=True):
        bone = obj.tug.bones.add()
        bone.group, bone.computed_weights = name, digest(column)
    obj.tug.bones_source = _source(given)


def _source(given: Inputs) -> str:
    return digest(given.shapes, given.triangles)


# What Tug wrote ---------------------------------------------------------------------------------


def _written(obj: bpy.types.Object, owners: Sequence[bpy.types.PropertyGroup]) -> set[str]:
    """Names of the groups of handles or bones that are exactly as a bind wrote them."""
    written = {owner.group: owner.computed_weights for owner in owners}
    names = [name for name in written if name in obj.vertex_groups]
    columns = vertex_groups.read(obj, names).T
    return {
        name for name, column in zip(names, columns, strict=True) if digest(column) == written[name]
    }


def _refuse_painted(obj: bpy.types.Object, what: str, painted: Sequence[str]) -> None:
    if painted:
        raise RigError(
            f'the {what} of "{obj.name}" need new weights, but these vertex groups hold weights '
            f"that Tug did not make: {', '.join(painted)}. Delete or rename them, or paint a "
            f"vertex group for each of the {what}"
        )


def _drop_others(obj: bpy.types.Object) -> None:
    """What other dictionaries than the chosen one left: they can make it again, and the list of
    groups stays short. Where anything of it was painted, all of it stays."""
    rig = obj.tug
    if rig.dictionary != Dictionary.EIGENFUNCTIONS:
        drop_attributes(obj.data)
    if rig.dictionary != Dictionary.HANDLES:
        groups = [handle.group for handle in rig.handles if handle.group in obj.vertex_groups]
        if len(_written(obj, rig.handles)) == len(groups):
            _drop_groups(obj, groups)
            for handle in rig.handles:
                handle.group = handle.computed_weights = ""
    if rig.dictionary != Dictionary.SKELETON:
        groups = [bone.group for bone in rig.bones if bone.group in obj.vertex_groups]
        if len(_written(obj, rig.bones)) == len(groups):
            _drop_groups(obj, groups)
            rig.bones.clear()


def _drop_groups(obj: bpy.types.Object, names: Sequence[str]) -> None:
    for name in names:
        if name in obj.vertex_groups:
            obj.vertex_groups.remove(obj.vertex_groups[name])


# Attributes -------------------------------------------------------------------------------------


def _keep_attributes(mesh: bpy.types.Mesh, given: Inputs, stored: Stored) -> None:
    drop_attributes(mesh)
    for number, function in enumerate(stored.weights.T):
        # A new attribute may move the others: each is filled before the next is made.
        attribute = mesh.attributes.new(FUNCTION.format(number), "FLOAT", "POINT")
        attribute.data.foreach_set("value", np.ascontiguousarray(function))
    faces = np.empty(len(mesh.polygons), np.int32)
    faces[given.faces] = stored.groups
    attribute = mesh.attributes.new(EDGE_GROUP, "INT", "FACE")
    attribute.data.foreach_set("value", faces)


def _function_attributes(mesh: bpy.types.Mesh) -> list[str]:
    prefix = FUNCTION.format("")
    return [name for name in mesh.attributes.keys() if name.startswith(prefix)]  # noqa: SIM118
