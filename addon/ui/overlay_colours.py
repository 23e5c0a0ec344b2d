# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours over the meshes that show the examples each place is made of, or its parts.

They are drawn, and kept with the mesh only where the artist asks for it.
"""

from __future__ import annotations

from typing import ClassVar

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent
from bpy.props import EnumProperty
from gpu_extras.batch import batch_for_shader

from ..native import LibraryError
from ..rigging import blends, inputs, rig, shape_keys
from ..rigging.inputs import RigError
from . import drawing
from .picking import bound_rigs

# How much nearer than the mesh the colours are drawn, in parts of the depth of the view.
NEARER = 2e-5
OPACITY = 0.6
ATTRIBUTES = {"EXAMPLES": "Tug Examples", "PARTS": "Tug Parts"}

# By session_uid, until something changes.
_batches: dict[int, gpu.types.GPUBatch] = {}
_handler: object = None


class TUG_OT_store_colours(bpy.types.Operator):
    """Keep the colours that are shown with the mesh, as a colour attribute"""

    bl_idname = "tug.store_colours"
    bl_label = "Keep Colours"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        if obj is None or obj.type != "MESH" or not obj.tug.bound:
            cls.poll_message_set("Select a bound mesh")
            return False
        if context.window_manager.tug_colours == "NONE":
            cls.poll_message_set("Choose which colours to show first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        wanted = context.window_manager.tug_colours
        try:
            name = store(context.object, wanted, context.evaluated_depsgraph_get())
        except (RigError, LibraryError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f'The colours are in the attribute "{name}"')
        return {"FINISHED"}


def store(obj: bpy.types.Object, wanted: str, depsgraph: bpy.types.Depsgraph) -> str:
    """Write the colours to a colour attribute of the mesh, made where it is missing; its name."""
    inputs.check_object(obj)
    rig.positions(obj, depsgraph)  # the solver may show another frame, or none
    name, attributes = ATTRIBUTES[wanted], obj.data.color_attributes
    found = attributes.get(name) or attributes.new(name, "FLOAT_COLOR", "POINT")
    if (found.data_type, found.domain) != ("FLOAT_COLOR", "POINT"):
        raise RigError(
            f'the attribute "{name}" of "{obj.name}" is of another kind: delete or rename it'
        )
    found.data.foreach_set("color", _with_opacity(colours(obj, wanted), 1.0).ravel())
    obj.data.update_tag()
    return name


def colours(obj: bpy.types.Object, wanted: str) -> np.ndarray | None:
    """#V by 3, or None before the first pose."""
    if wanted == "EXAMPLES":
        return blends.example_colours(obj, drawing.shape_colours(len(inputs.bound_examples(obj))))
    # The first of the shapes' colours is grey.
    return blends.group_colours(obj, drawing.shape_colours(blends.group_count(obj) + 1)[1:])


def _draw() -> None:
    context = bpy.context
    wanted, space = context.window_manager.tug_colours, context.space_data
    if wanted == "NONE" or not space.overlay.show_overlays or space.shading.type == "WIREFRAME":
        return
    for obj in bound_rigs(context.scene):
        if not obj.visible_get(viewport=space) or obj.data.is_editmode:
            continue
        if obj.session_uid not in _batches:
            _batches[obj.session_uid] = _batch(obj, wanted, context.evaluated_depsgraph_get())
        if batch := _batches[obj.session_uid]:
            _draw_over(batch, obj)


def _draw_over(batch: gpu.types.GPUBatch, obj: bpy.types.Object) -> None:
    """Half transparent, so that light and shadow stay visible."""
    projection = gpu.matrix.get_projection_matrix()
    projection[2] -= NEARER * projection[3]
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        gpu.matrix.load_projection_matrix(projection)
        gpu.matrix.multiply_matrix(obj.matrix_world)
        batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")


def _batch(
    obj: bpy.types.Object, wanted: str, depsgraph: bpy.types.Depsgraph
) -> gpu.types.GPUBatch | None:
    shown = colours(obj, wanted)
    positions = _positions(obj, depsgraph)
    if shown is None or len(shown) != len(positions):
        return None
    triangles = np.empty(3 * len(obj.data.loop_triangles), np.int32)
    obj.data.loop_triangles.foreach_get("vertices", triangles)
    return batch_for_shader(
        gpu.shader.from_builtin("SMOOTH_COLOR"),
        "TRIS",
        {"pos": positions, "color": _with_opacity(shown, OPACITY)},
        indices=triangles.reshape(-1, 3),
    )


def _positions(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """#V by 3, after modifiers where these keep the vertices."""
    mesh = obj.evaluated_get(depsgraph).data
    if len(mesh.vertices) != len(obj.data.vertices):
        return shape_keys.displayed(obj).astype(np.float32)
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def _with_opacity(shown: np.ndarray, opacity: float) -> np.ndarray:
    return np.column_stack([shown, np.full(len(shown), opacity)]).astype(np.float32)


def _chosen(_manager: bpy.types.WindowManager, context: bpy.types.Context) -> None:
    """See that every rig has a pose to show the colours of: after loading a file none has."""
    _batches.clear()
    if context.window_manager.tug_colours == "NONE":
        return
    for obj in bound_rigs(context.scene):
        try:
            rig.positions(obj, context.evaluated_depsgraph_get())
        except (RigError, LibraryError) as error:
            print(f"Tug: {error}")


@persistent
def _forget(*_: object) -> None:
    _batches.clear()


HANDLERS = ("depsgraph_update_post", "frame_change_post", "load_post")
CLASSES = (TUG_OT_store_colours,)


def register() -> None:
    global _handler
    bpy.types.WindowManager.tug_colours = EnumProperty(
        name="Colours",
        description="What the colours over bound meshes show",
        items=(
            ("NONE", "None", "No colours"),
            ("EXAMPLES", "Examples", "Which shape keys each place is made of in this pose"),
            ("PARTS", "Parts", "The parts that choose their shape keys on their own"),
        ),
        update=_chosen,
    )
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(_forget)
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
        _handler = None
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).remove(_forget)
    _batches.clear()
    del bpy.types.WindowManager.tug_colours
