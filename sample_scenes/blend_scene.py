# SPDX-License-Identifier: GPL-3.0-or-later
"""From a Sample to a Blender scene: mesh, shape keys, handles, keyframes."""

from __future__ import annotations

from math import radians

import bpy
import numpy as np
from mathutils import Matrix, Vector

from addon.rigging import rig

from .sample import LAST_FRAME, Sample


def empty_file() -> None:
    """Starts an empty file, the user's preferences untouched."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def add_sample(sample: Sample) -> bpy.types.Object:
    """Adds the mesh, its keyed handles and the frame range to the scene; gives the mesh object.

    The add-on must be registered.
    """
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, LAST_FRAME
    obj = add_mesh(sample)
    obj.tug.single_blend = sample.single_blend
    handles = {name: rig.add_handle(obj, vertex, name) for name, vertex in sample.handles.items()}
    for waypoint in sample.motion:
        for name, position in sample.handle_positions(waypoint).items():
            handles[name].location = obj.matrix_world @ Vector(position)
            handles[name].keyframe_insert("location", frame=waypoint.frame)
    scene.frame_set(scene.frame_start)
    return obj


def add_mesh(sample: Sample) -> bpy.types.Object:
    """The mesh object with its shape keys and colours, active in the scene."""
    mesh = bpy.data.meshes.new(sample.name.title())
    mesh.from_pydata(sample.rest.tolist(), [], sample.faces)
    mesh.shade_smooth()
    obj = bpy.data.objects.new(mesh.name, mesh)
    if sample.y_up:
        obj.matrix_world = Matrix.Rotation(radians(90), 4, "X")
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    for name, positions in sample.shapes.items():
        key = obj.shape_key_add(name=name, from_mix=False)
        key.points.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
        key.value = 0.0
    if sample.colors is not None:
        paint = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
        opaque = np.column_stack([sample.colors, np.ones(len(sample.colors))])
        paint.data.foreach_set("color", opaque.astype(np.float32).ravel())
    return obj


def suzanne() -> tuple[np.ndarray, np.ndarray]:
    """Blender's monkey, subdivided twice: vertices #V by 3 and quads #F by 4."""
    bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
    mesh = monkey.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    vertices = np.array([v.co for v in mesh.vertices], dtype=float)
    quads = np.array([p.vertices for p in mesh.polygons])
    bpy.data.objects.remove(monkey)
    return vertices, quads
