# SPDX-License-Identifier: GPL-3.0-or-later
"""What a .blend file keeps of a rig: `Object.tug`.

Nothing but `reach` can be animated: a pose is a function of the handles alone.
"""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import live


def _changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    live.invalidate(group.id_data)
    group.id_data.update_tag()


def _set(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Without it Blender does not look at the object again when a script sets a property."""
    group.id_data.update_tag()


class TUG_PG_handle(bpy.types.PropertyGroup):
    empty: PointerProperty(
        name="Empty", description="Pull this to pose the mesh", type=bpy.types.Object
    )
    vertex: IntProperty(
        name="Vertex",
        description="Vertex that stays on the empty",
        min=0,
        update=_changed,
        options=set(),
    )
    free: BoolProperty(
        name="Free",
        description="Let this part of the mesh go where the other handles take it",
        default=False,
        update=_changed,
        options=set(),
    )
    group: StringProperty(
        name="Vertex Group", description="How much each vertex belongs to this handle"
    )
    # Digest of the weights that Tug wrote, to tell them from painted ones.
    computed_weights: StringProperty(options={"HIDDEN"})
    # Where the vertex was in the rest shape at the bind, to find it again when the mesh was edited.
    rest: FloatVectorProperty(size=3, options={"HIDDEN"})
    rest_vertex: IntProperty(default=-1, options={"HIDDEN"})


class TUG_PG_shape(bpy.types.PropertyGroup):
    """One shape key, found by its name."""

    use: BoolProperty(
        name="Example", description="Let poses draw on this shape key", default=True, options=set()
    )
    was_muted: BoolProperty(options={"HIDDEN"})


class TUG_PG_rig(bpy.types.PropertyGroup):
    handles: CollectionProperty(type=TUG_PG_handle)
    shapes: CollectionProperty(type=TUG_PG_shape)
    collection: PointerProperty(
        name="Handles", description="Where new handles go", type=bpy.types.Collection
    )

    live: BoolProperty(
        name="Live",
        description="Pose the mesh while its handles move. Renders are posed in any case",
        default=True,
        update=_set,
        options=set(),
    )
    form: EnumProperty(
        name="Method",
        description="How the shape keys are brought together",
        items=(
            ("STEADY", "Steady", "The mesh turns and bends smoothly and never jumps"),
            ("PAPER", "Original", "As first published: may jump between shape keys"),
            ("NO_ROTATIONS", "Straight", "Parts do not turn beyond what the shape keys show"),
            (
                "TRUST_REGION",
                "Original, Settled",
                "Like Original, but every pose comes to rest. Slower than Steady: for baking",
            ),
        ),
        default="STEADY",
        update=_set,
        options=set(),
    )
    selectivity: FloatProperty(
        name="Selectivity",
        description="How much the shape keys that fit the handles best go before the others",
        default=0.5,
        min=0.0,
        soft_max=2.0,
        update=_set,
        options=set(),
    )
    steadiness: FloatProperty(
        name="Steadiness",
        description="How smoothly parts turn while handles move; less follows the shape keys more",
        default=0.1,
        min=0.0,
        soft_max=1.0,
        update=_set,
        options=set(),
    )
    group_count: IntProperty(
        name="Parts",
        description="How many parts of the mesh choose their shape keys on their own; "
        "0 takes two for each handle",
        default=0,
        min=0,
        soft_max=100,
        update=_changed,
        options=set(),
    )
    single_blend: BoolProperty(
        name="One Blend",
        description="Use the same mixture of shape keys for the whole mesh",
        default=False,
        update=_set,
        options=set(),
    )
    squared: BoolProperty(
        name="Soft Choice",
        description="Mix more shape keys at a time instead of settling on few",
        default=False,
        update=_set,
        options=set(),
    )
    follow_nearest: BoolProperty(
        name="Loose Parts Follow",
        description="Parts without a handle move with the nearest one. Applies when weights are "
        "computed",
        default=False,
        options=set(),
    )

    stiffness_group: StringProperty(
        name="Stiffness Group",
        description="Vertex group whose weights say where the mesh resists being deformed",
        update=_changed,
        options=set(),
    )
    stiffness_max: FloatProperty(
        name="Max Stiffness",
        description="How many times stiffer the mesh is where the weight is one than where it is "
        "zero",
        default=10.0,
        min=1.0,
        soft_max=100.0,
        update=_changed,
        options=set(),
    )

    # What the rig was bound to. The model itself is not saved: it is made again from the vertex
    # groups, the shape keys and this.
    bound: BoolProperty(name="Bound", options={"HIDDEN"})
    result: StringProperty(name="Result", options={"HIDDEN"})
    examples: StringProperty(name="Examples", description="JSON list", options={"HIDDEN"})
    vertex_count: IntProperty(options={"HIDDEN"})
    topology: StringProperty(options={"HIDDEN"})
    # Driven by the handles, so that Blender evaluates them even where they are hidden.
    reach: FloatProperty(options={"HIDDEN", "ANIMATABLE"})


CLASSES = (TUG_PG_handle, TUG_PG_shape, TUG_PG_rig)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.tug = PointerProperty(type=TUG_PG_rig)


def unregister() -> None:
    del bpy.types.Object.tug
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
