# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of a rig: where new ones go, their names, their mirror images, and taking them away."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from bpy.types import Object
from mathutils import Vector

from ..geometry import Mesh
from . import inputs, live, rig, shape_keys
from .inputs import RigError

# What is nearer to the mirror plane, relative to the diagonal, is on it and has no mirror image.
ON_PLANE = 0.02


def add_spread(obj: Object, count: int) -> list[Object]:
    """New handles where the surface is farthest from all others, along its edges. Loose parts come
    first, as each needs one."""
    taken = [handle.vertex for handle in obj.tug.handles]
    with Mesh(*inputs.surface(obj)) as mesh:
        if not taken:  # begin at an end of the mesh, as a nose or a tail
            return _add_numbered(obj, mesh.spread(count, _farthest(mesh, [0])).tolist())
        added = []
        for _ in range(count):
            added.append(_farthest(mesh, taken + added))
    return _add_numbered(obj, added)


def add_on(obj: Object, vertices: Sequence[int]) -> list[Object]:
    """A new handle on each of the vertices that has none yet."""
    taken = {handle.vertex for handle in obj.tug.handles}
    return _add_numbered(obj, [vertex for vertex in vertices if vertex not in taken])


def add_on_bones(obj: Object) -> list[Object]:
    """A new handle for every deforming bone of the object's armature, on the surface near the
    middle of the bone."""
    armature = armature_of(obj)
    if armature is None:
        raise RigError(f'"{obj.name}" has no armature: add an Armature modifier with one')
    rest = shape_keys.coordinates(obj.data.shape_keys.reference_key)
    into = obj.matrix_world.inverted() @ armature.matrix_world
    taken = {handle.vertex for handle in obj.tug.handles}
    added = []
    for bone in armature.data.bones:
        vertex = _nearest(rest, into @ ((bone.head_local + bone.tail_local) / 2))
        if bone.use_deform and vertex not in taken:
            # Not the bone's own name: a handle's weights go by its name, and so do the bone's.
            added.append(rig.add_handle(obj, vertex, f"Handle {bone.name}"))
            taken.add(vertex)
    return added


def armature_of(obj: Object) -> Object | None:
    return next(
        (m.object for m in obj.modifiers if m.type == "ARMATURE" and m.object is not None), None
    )


def nearest_vertex(obj: Object, place: Vector, depsgraph: bpy.types.Depsgraph) -> int:
    """The vertex that is shown nearest to a place in object space."""
    shown = obj.evaluated_get(depsgraph).data
    if len(shown.vertices) == len(obj.data.vertices):  # deformed, and nothing generated
        flat = np.empty(3 * len(shown.vertices), np.float32)
        shown.attributes["position"].data.foreach_get("vector", flat)
        return _nearest(flat.reshape(-1, 3), place)
    return _nearest(shape_keys.displayed(obj), place)


def add_mirrored(obj: Object) -> list[Object]:
    """A partner across the object's X for every handle that lacks one, named as Blender names
    sides; a handle off the middle without a side in its name gets one."""
    rest = shape_keys.coordinates(obj.data.shape_keys.reference_key)
    near = ON_PLANE * np.linalg.norm(np.ptp(rest, axis=0))
    added = []
    for handle in list(obj.tug.handles):
        x, y, z = rest[handle.vertex]
        if abs(x) <= near:
            continue
        if flipped(handle.name) == handle.name:
            rename(obj, handle, f"{handle.name}.{'L' if x > 0 else 'R'}")
        vertex = _nearest(rest, (-x, y, z))
        partner = next((h for h in obj.tug.handles if h.vertex == vertex), None)
        if partner is not None:
            if flipped(partner.name) == partner.name:
                rename(obj, partner, flipped(handle.name))
        elif flipped(handle.name) not in obj.tug.handles:
            added.append(rig.add_handle(obj, vertex, flipped(handle.name)))
    return added


def flipped(name: str) -> str:
    """The name of the other side, or the same where it has no side."""
    return bpy.utils.flip_name(name)


def rename(obj: Object, handle: bpy.types.PropertyGroup, name: str) -> None:
    """The empty, its vertex group and the rig."""
    handle.empty.name = name
    follow_name(obj, handle)


def follow_name(obj: Object, handle: bpy.types.PropertyGroup) -> None:
    """Take over the name of the empty, wherever it was renamed."""
    name = handle.empty.name
    group = obj.vertex_groups.get(handle.group)
    if group is not None and handle.group == handle.name:
        group.name = name
        handle.group = group.name
    handle.name = name


def put_on(obj: Object, handle: bpy.types.PropertyGroup, vertex: int) -> None:
    """Another vertex for a handle, which goes there. A bound rig then needs a bind."""
    others = {other.vertex: other.name for other in obj.tug.handles if other != handle}
    if vertex in others:
        raise RigError(f'the handle "{others[vertex]}" is on that vertex already: choose another')
    handle.vertex = vertex
    place(obj, handle, Vector(shape_keys.displayed(obj)[vertex]))


def place(obj: Object, handle: bpy.types.PropertyGroup, where: Vector) -> None:
    """Move an empty to a place in object space; its rotation and scale stay."""
    matrix = handle.empty.matrix_world.copy()
    matrix.translation = obj.matrix_world @ where
    handle.empty.matrix_world = matrix


def delete(obj: Object, number: int) -> None:
    """Take a handle away. A bound rig keeps its place until the next bind, which finds new
    weights."""
    handle = obj.tug.handles[number]
    empty, was_bound = handle.empty, obj.tug.bound and handle.rest_vertex >= 0
    shared = any(empty in [h.empty for h in other.tug.handles] for other in sharing(obj))
    if empty is not None and not shared:
        bpy.data.objects.remove(empty)
    obj.tug.handles[number].empty = None
    if not was_bound:
        rig.drop_deleted_handles(obj)
    obj.update_tag()


def sharing(obj: Object) -> list[Object]:
    """Other rigs, as duplicates of this one, with some of the same empties."""
    own = {handle.empty for handle in obj.tug.handles if handle.empty is not None}
    return [
        other
        for other in bpy.data.objects
        if other.type == "MESH"
        and other != obj
        and any(handle.empty in own for handle in other.tug.handles)
    ]


def make_own(obj: Object) -> None:
    """Copies of all empties, where they are relative to the one that they were shared with."""
    others = sharing(obj)
    if not others:
        raise RigError(f'"{obj.name}" shares its handles with nothing')
    if obj.data in [other.data for other in others]:
        raise RigError(
            f'"{obj.name}" shares its mesh too, which can have one pose only: make the mesh '
            "single-user first (Object > Relations > Make Single User)"
        )
    carry = obj.matrix_world @ others[0].matrix_world.inverted()
    obj.tug.collection = None
    collection = rig.handle_collection(obj)
    for handle in obj.tug.handles:
        if handle.empty is None:
            continue
        copy = handle.empty.copy()
        copy.animation_data_clear()
        collection.objects.link(copy)
        copy.matrix_world = carry @ handle.empty.matrix_world
        handle.empty = copy
        follow_name(obj, handle)
    if obj.tug.bound:
        rig.tie(obj)
    live.invalidate(obj)
    obj.update_tag()


def _add_numbered(obj: Object, vertices: Sequence[int]) -> list[Object]:
    first = len(obj.tug.handles) + 1
    return [
        rig.add_handle(obj, vertex, f"Handle {number}")
        for number, vertex in enumerate(vertices, first)
    ]


def _farthest(mesh: Mesh, vertices: Sequence[int]) -> int:
    return int(mesh.distances(vertices).argmax())


def _nearest(points: np.ndarray, place: Sequence[float]) -> int:
    return int(((points - np.array(place)) ** 2).sum(axis=1).argmin())
