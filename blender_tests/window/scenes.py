# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes that window tests play in, and what is seen of them. Objects are found by name every
time: undo replaces them."""

from __future__ import annotations

import functools

import bpy
import numpy as np

from addon.rigging import rig, shape_keys
from sample_scenes import creature
from sample_scenes.blend_scene import add_mesh, add_sample

NAME = "Creature"

sample = functools.cache(creature.sample)


def add_creature(bound: bool = True) -> bpy.types.Object:
    """The sample creature with its handles, which stay where they are put: nothing is keyed."""
    obj = add_mesh(sample())
    for name, vertex in sample().handles.items():
        rig.add_handle(obj, vertex, name)
    if bound:
        rig.bind(obj)
    return obj


def add_moving_creature() -> bpy.types.Object:
    """The sample creature, bound, with its handles keyed over 48 frames."""
    obj = add_sample(sample())
    rig.bind(obj)
    return obj


def shown(name: str) -> np.ndarray:
    """#V by 3 positions of a mesh as Blender shows it, after modifiers."""
    obj = bpy.data.objects[name]
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def key_of(name: str) -> np.ndarray:
    """#V by 3: the result key of a rig."""
    obj = bpy.data.objects[name]
    return shape_keys.coordinates(obj.data.shape_keys.key_blocks[obj.tug.result])


def pose_asked(name: str) -> np.ndarray:
    """#V by 3: what the solver answers for the handles as they are, as the key would hold it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return rig.positions(bpy.data.objects[name], depsgraph).astype(np.float32)


def diagonal(name: str) -> float:
    """Of the mesh as it is shown."""
    return float(np.linalg.norm(np.ptp(shown(name), axis=0)))
