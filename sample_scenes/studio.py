# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera, lights, materials and render of a contact sheet.

Cycles on the CPU, since it needs neither a display nor a GPU.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import radians
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

SAMPLES = 16
PAPER = (0.90, 0.89, 0.87)
INK = (0.05, 0.05, 0.06)
CLAY = (0.62, 0.50, 0.42)


def add_camera(
    scene: bpy.types.Scene, turn: Matrix, width: float, height: float, depth: float
) -> None:
    data = bpy.data.cameras.new("Sheet")
    data.type, data.ortho_scale = "ORTHO", max(width, height)
    data.clip_end = depth + 100.0
    camera = bpy.data.objects.new("Sheet", data)
    camera.location = turn @ Vector((width / 2, -height / 2, 50.0))
    camera.rotation_euler = turn.to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def add_lights(scene: bpy.types.Scene, turn: Matrix) -> None:
    """Key, fill and rim as suns that turn with the camera, under an even sky."""
    for name, towards, energy, angle in (
        ("Key", (-0.7, 0.9, 0.7), 2.4, 10),
        ("Fill", (1.0, 0.1, 0.6), 0.5, 40),
        ("Rim", (0.8, 0.7, -0.8), 2.2, 10),
    ):
        data = bpy.data.lights.new(name, "SUN")
        data.energy, data.angle = energy, radians(angle)
        sun = bpy.data.objects.new(name, data)
        sun.rotation_euler = (turn @ Vector(towards)).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(sun)
    scene.world = _sky()


def _sky() -> bpy.types.World:
    """Plain paper to the camera, dimmer to what it lights."""
    world = bpy.data.worlds.new("Sheet")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background, rays = nodes["Background"], nodes.new("ShaderNodeLightPath")
    strength = nodes.new("ShaderNodeMapRange")
    strength.inputs["To Min"].default_value = 0.35
    links.new(rays.outputs["Is Camera Ray"], strength.inputs["Value"])
    links.new(strength.outputs["Result"], background.inputs["Strength"])
    background.inputs["Color"].default_value = (*PAPER, 1)
    return world


def clay(mesh: bpy.types.Mesh) -> bpy.types.Material:
    """A matt material in the mesh's own colours if it has any, in plain clay otherwise."""
    material = bpy.data.materials.new("Clay")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*CLAY, 1)
    surface.inputs["Roughness"].default_value = 0.6
    if mesh.color_attributes:
        paint = nodes.new("ShaderNodeVertexColor")
        paint.layer_name = mesh.color_attributes[0].name
        links.new(paint.outputs["Color"], surface.inputs["Base Color"])
    return material


def ink() -> bpy.types.Material:
    material = bpy.data.materials.new("Ink")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    glow = nodes.new("ShaderNodeEmission")
    glow.inputs["Color"].default_value = (*INK, 1)
    links.new(glow.outputs["Emission"], nodes["Material Output"].inputs["Surface"])
    return material


def render(scene: bpy.types.Scene, path: Path, width: int, height: int) -> None:
    output = scene.render
    output.engine = "CYCLES"
    output.resolution_x, output.resolution_y, output.resolution_percentage = width, height, 100
    output.image_settings.file_format = "PNG"
    output.filepath = str(path.resolve())
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
    scene.cycles.max_bounces = 2
    with _silence():
        bpy.ops.render.render(write_still=True, scene=scene.name)


@contextmanager
def _silence() -> Iterator[None]:
    """Keeps the renderer's hundreds of lines off stdout, where Blender writes past Python."""
    sys.stdout.flush()
    before = os.dup(1)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)
