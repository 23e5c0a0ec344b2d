# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample character that comes with the extension: arrays in a file beside this one."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from bpy.types import Object

from .rigging import rig
from .rigging.inputs import RigError

FILE = Path(__file__).with_name("sample.npz")
NAME = "Fox"


def add_scene(path: Path | None = None) -> Object:
    """A new scene with the character and its handles, not bound; gives the mesh."""
    path = path or FILE
    if not path.is_file():
        raise RigError("this Tug was not installed from its zip, which has the sample in it")
    with np.load(path) as arrays:
        sample = {name: arrays[name] for name in arrays.files}
    scene = bpy.data.scenes.new("Tug Sample")
    obj = _mesh_object(sample)
    scene.collection.objects.link(obj)
    if bpy.context.window is not None:
        bpy.context.window.scene = scene
    for name, vertex in zip(sample["handle_names"], sample["handle_vertices"], strict=True):
        rig.add_handle(obj, int(vertex), str(name))
    return obj


def _mesh_object(sample: dict[str, np.ndarray]) -> Object:
    mesh = bpy.data.meshes.new(NAME)
    shapes = sample["shapes"].astype(np.float32)
    mesh.from_pydata(shapes[0].tolist(), [], sample["faces"].tolist())
    mesh.shade_smooth()
    paint = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    opaque = np.column_stack([sample["colors"], np.ones(len(shapes[0]))])
    paint.data.foreach_set("color", opaque.astype(np.float32).ravel())
    mesh.materials.append(_painted())
    obj = bpy.data.objects.new(NAME, mesh)
    for name, shape in zip(sample["names"], shapes, strict=True):
        key = obj.shape_key_add(name=str(name), from_mix=False)
        key.points.foreach_set("co", shape.ravel())
        key.value = 0.0
    return obj


def _painted() -> bpy.types.Material:
    """Shows the colours of the vertices."""
    material = bpy.data.materials.new(NAME)
    if bpy.app.version < (5, 0):  # nothing else is possible later
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    attribute = nodes.new("ShaderNodeVertexColor")
    attribute.layer_name = "Paint"
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    return material
