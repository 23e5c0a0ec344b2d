# SPDX-License-Identifier: GPL-3.0-or-later
"""A small rig for the tests, and what they look at."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bmesh
import bpy
import numpy as np

from addon.caches import pc2
from addon.rigging import rig, shape_keys

AROUND, ALONG = 10, 16  # vertices of a ring, rings
LENGTH = 4.0
# Names and vertices of the handles: the ends and the middle of the tube.
HANDLES = {"Root": 0, "Middle": 8 * AROUND + 5, "Tip": 15 * AROUND}


def tube() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Vertices and quads of an open tube along z."""
    angle = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    ring = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle)], axis=1)
    height = np.linspace(0, LENGTH, ALONG)
    vertices = np.concatenate(
        [np.tile(ring, (ALONG, 1)), np.repeat(height, AROUND)[:, None]], axis=1
    )
    number = np.arange(ALONG * AROUND).reshape(ALONG, AROUND)
    low, high = number[:-1], number[1:]
    quads = np.stack([low, np.roll(low, -1, 1), np.roll(high, -1, 1), high], axis=-1)
    return vertices, quads.reshape(-1, 4).tolist()


def bent(vertices: np.ndarray, angle: float) -> np.ndarray:
    """Bent towards x to an arc of `angle`."""
    turn, radius = angle * vertices[:, 2] / LENGTH, LENGTH / angle
    x = radius - (radius - vertices[:, 0]) * np.cos(turn)
    z = (radius - vertices[:, 0]) * np.sin(turn)
    return np.stack([x, vertices[:, 1], z], axis=1)


def swollen(vertices: np.ndarray) -> np.ndarray:
    factor = 1 + np.sin(np.pi * vertices[:, 2] / LENGTH)
    return vertices * np.stack([factor, factor, np.ones_like(factor)], axis=1)


def add_mesh(
    name: str, vertices: np.ndarray, faces: Sequence[Sequence[int]], edges: Sequence = ()
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), edges, faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_key(obj: bpy.types.Object, name: str, positions: np.ndarray) -> bpy.types.ShapeKey:
    block = obj.shape_key_add(name=name, from_mix=False)
    block.value = 0.0
    shape_keys.write(obj.data, block, positions)
    return block


def add_keys(obj: bpy.types.Object, *shapes: np.ndarray) -> None:
    """Basis, and a key for each of the shapes."""
    basis = np.empty((len(obj.data.vertices), 3), np.float32)
    obj.data.attributes["position"].data.foreach_get("vector", basis.ravel())
    add_key(obj, "Basis", basis)
    for number, shape in enumerate(shapes):
        add_key(obj, f"Shape {number}", shape)


def add_tube(name: str = "Tube") -> bpy.types.Object:
    """The tube with keys Basis, Bend, Unbend and Swell; no handles."""
    vertices, quads = tube()
    obj = add_mesh(name, vertices, quads)
    add_key(obj, "Basis", vertices)
    add_key(obj, "Bend", bent(vertices, 1.5))
    add_key(obj, "Unbend", bent(vertices, -1.5))
    add_key(obj, "Swell", swollen(vertices))
    return obj


def add_rig(
    name: str = "Tube", prefix: str = "", *, dictionary: str = "EIGENFUNCTIONS"
) -> bpy.types.Object:
    """The tube with its handles, not bound."""
    obj = add_tube(name)
    obj.tug.dictionary = dictionary
    for handle, vertex in HANDLES.items():
        rig.add_handle(obj, vertex, prefix + handle)
    return obj


def bound_rig(
    name: str = "Tube", prefix: str = "", *, dictionary: str = "EIGENFUNCTIONS"
) -> bpy.types.Object:
    obj = add_rig(name, prefix, dictionary=dictionary)
    rig.bind(obj)
    return obj


@contextmanager
def in_mode(obj: bpy.types.Object, mode: str) -> Iterator[None]:
    """The object is active, and in Object Mode again afterwards."""
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode=mode)
    try:
        yield
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def delete_vertices(obj: bpy.types.Object, *numbers: int) -> None:
    """In Edit Mode, as an artist would."""
    with in_mode(obj, "EDIT"):
        mesh = bmesh.from_edit_mesh(obj.data)
        mesh.verts.ensure_lookup_table()
        bmesh.ops.delete(mesh, geom=[mesh.verts[number] for number in numbers], context="VERTS")
        bmesh.update_edit_mesh(obj.data)


def add_armature(
    **bones: tuple[Sequence[float], Sequence[float]],
) -> bpy.types.Object:
    """Heads and tails of bones, by their names."""
    obj = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.scene.collection.objects.link(obj)
    with in_mode(obj, "EDIT"):
        for name, (head, tail) in bones.items():
            bone = obj.data.edit_bones.new(name)
            bone.head, bone.tail = head, tail
    return obj


def key(obj: bpy.types.Object, name: str) -> bpy.types.ShapeKey:
    return obj.data.shape_keys.key_blocks[name]


def pull_to(obj: bpy.types.Object, name: str) -> None:
    """Put the handles where the key has their vertices."""
    for handle in obj.tug.handles:
        handle.empty.location = obj.matrix_world @ key(obj, name).points[handle.vertex].co
    bpy.context.view_layer.update()


def pull_between(obj: bpy.types.Object) -> None:
    """Put the handles half-way between two examples."""
    for handle in obj.tug.handles:
        ends = [key(obj, name).points[handle.vertex].co for name in ("Bend", "Swell")]
        handle.empty.location = obj.matrix_world @ ((ends[0] + ends[1]) / 2)
    bpy.context.view_layer.update()


def animate(obj: bpy.types.Object, last: int = 12) -> None:
    """Key the handles from the rest shape at frame 1 to Bend at frame `last`."""
    for frame, name in ((1, "Basis"), (last, "Bend")):
        pull_to(obj, name)
        for handle in obj.tug.handles:
            handle.empty.keyframe_insert("location", frame=frame)


def depsgraph() -> bpy.types.Depsgraph:
    return bpy.context.evaluated_depsgraph_get()


def expected(obj: bpy.types.Object) -> np.ndarray:
    """The solver's positions for the handles as they are now."""
    return rig.positions(obj, depsgraph())


def evaluated(obj: bpy.types.Object) -> np.ndarray:
    """The mesh as Blender shows it, after modifiers."""
    mesh = obj.evaluated_get(depsgraph()).data
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def solved(obj: bpy.types.Object) -> np.ndarray:
    """Solve for the handles as they are now: the mesh as Blender shows it."""
    bpy.context.view_layer.update()
    rig.solve(obj, depsgraph())
    return evaluated(obj)


def read_pc2(path: Path) -> tuple[int, np.ndarray]:
    """The first frame's number and the frames, #frames by #V by 3."""
    data = Path(path).read_bytes()
    _, _, vertices, first, _, frames = pc2.HEADER.unpack_from(data)
    positions = np.frombuffer(data, "<f4", offset=pc2.HEADER.size)
    return int(first), positions.reshape(frames, vertices, 3)


def assert_close(actual: np.ndarray, wanted: np.ndarray) -> None:
    """Equal to float32 precision of coordinates of this size."""
    np.testing.assert_allclose(actual, wanted, rtol=0, atol=8e-7 * LENGTH)


def attributes(mesh: bpy.types.Mesh) -> dict[str, list[float]]:
    """What Tug keeps with a mesh, by name."""
    return {
        attribute.name: [element.value for element in attribute.data]
        for attribute in mesh.attributes
        if attribute.name.startswith(".tug")
    }


def state(obj: bpy.types.Object) -> str:
    """Everything that a bind or a bake may change about an object and its scene."""
    keys = obj.data.shape_keys
    return json.dumps(
        {
            "objects": sorted(bpy.data.objects.keys()),
            "meshes": sorted(bpy.data.meshes.keys()),
            "groups": [group.name for group in obj.vertex_groups],
            "weights": [[(g.group, g.weight) for g in v.groups] for v in obj.data.vertices],
            "keys": [
                (block.name, block.mute, block.value, shape_keys.coordinates(block).tolist())
                for block in (keys.key_blocks if keys else ())
            ],
            "modifiers": [modifier.name for modifier in obj.modifiers],
            "drivers": len(obj.animation_data.drivers) if obj.animation_data else 0,
            "frame": bpy.context.scene.frame_current,
            "rig": [obj.tug.bound, obj.tug.result, obj.tug.examples, obj.tug.topology],
            "dictionary": [obj.tug.dictionary, obj.tug.bound_dictionary, obj.tug.groups],
            "bones": [bone.group for bone in obj.tug.bones],
            "attributes": attributes(obj.data),
            "handles": [(h.name, h.vertex, h.group, h.rest_vertex) for h in obj.tug.handles],
        }
    )
