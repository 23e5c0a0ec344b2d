# SPDX-License-Identifier: GPL-3.0-or-later
"""What a .blend file keeps of a rig: `Object.tug`.

Nothing but `reach` and how handles are held can be animated: a pose is a function of where the
handles are and how they are held.
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

from .rigging import handles, live


def _changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    live.invalidate(group.id_data)
    group.id_data.update_tag()


def _set(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Without it Blender does not look at the object again when a script sets a property."""
    group.id_data.update_tag()


def _get_title(handle: bpy.types.PropertyGroup) -> str:
    return handle.empty.name if handle.empty else handle.name


def _set_title(handle: bpy.types.PropertyGroup, name: str) -> None:
    if handle.empty and name:
        handles.rename(handle.id_data, handle, name)


class TUG_PG_handle(bpy.types.PropertyGroup):
    # `name` is that of the empty when the rig last looked, to find the handle by.
    title: StringProperty(
        name="Name",
        description="Of the handle, its empty and its vertex group",
        get=_get_title,
        set=_set_title,
        options=set(),
    )
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
    hold: EnumProperty(
        name="Hold",
        description="How the mesh is held here",
        items=(
            ("PINNED", "Pinned", "The vertex stays on the handle", "PINNED", 0),
            ("SOFT", "Soft", "The handle pulls as a spring does", "MOD_SOFT", 1),
            (
                "FREE",
                "Free",
                "This part of the mesh goes where the other handles take it",
                "UNPINNED",
                2,
            ),
        ),
        default="PINNED",
        update=_set,
    )
    firmness: FloatProperty(
        name="Firmness",
        description="How many times as stiff as the mesh the spring of a soft handle is",
        default=1.0,
        min=0.001,
        max=1000.0,
        soft_min=0.01,
        soft_max=10.0,
        update=_set,
    )
    group: StringProperty(
        name="Vertex Group", description="How much each vertex belongs to this handle"
    )
    # Digest of the weights that Tug wrote, to tell them from painted ones.
    computed_weights: StringProperty(options={"HIDDEN"})
    # Where the vertex was in the rest shape at the bind, to find it again when the mesh was edited.
    rest: FloatVectorProperty(size=3, options={"HIDDEN"})
    rest_vertex: IntProperty(default=-1, options={"HIDDEN"})


class TUG_PG_bone(bpy.types.PropertyGroup):
    """A part that moves as one from key to key."""

    group: StringProperty(
        name="Vertex Group", description="How much each vertex belongs to this bone"
    )
    computed_weights: StringProperty(options={"HIDDEN"})  # as of a handle


class TUG_PG_shape(bpy.types.PropertyGroup):
    """One shape key, found by its name."""

    use: BoolProperty(
        name="Example", description="Let poses draw on this shape key", default=True, options=set()
    )
    was_muted: BoolProperty(options={"HIDDEN"})


DICTIONARIES = (
    (
        "EIGENFUNCTIONS",
        "Smooth",
        "The whole mesh moves smoothly, wherever its handles are. Nearest to the shape keys for "
        "most meshes",
    ),
    (
        "HANDLES",
        "Handles",
        "Each handle moves the mesh around it, by weights in a vertex group that can be painted",
    ),
    (
        "SKELETON",
        "Bones from Shape Keys",
        "Parts that are stiff in all shape keys are found and move as bones do, by weights in "
        "vertex groups that can be painted",
    ),
    (
        "VERTEX_GROUPS",
        "Vertex Groups",
        "The vertex groups of the armature's deforming bones or, without an armature, all but "
        "those that Tug made",
    ),
)


def _get_dictionary(rig: TUG_PG_rig) -> int:
    """A rig that was bound before there was a choice has its weights with its handles."""
    default = "HANDLES" if rig.bound and not rig.bound_dictionary else "EIGENFUNCTIONS"
    names = [name for name, *_ in DICTIONARIES]
    return names.index(rig.chosen_dictionary or default)


def _set_dictionary(rig: TUG_PG_rig, number: int) -> None:
    rig.chosen_dictionary = DICTIONARIES[number][0]


class TUG_PG_rig(bpy.types.PropertyGroup):
    handles: CollectionProperty(type=TUG_PG_handle)
    bones: CollectionProperty(type=TUG_PG_bone)
    shapes: CollectionProperty(type=TUG_PG_shape)
    collection: PointerProperty(
        name="Handles", description="Where new handles go", type=bpy.types.Collection
    )

    active_handle: IntProperty(name="Active Handle", options={"HIDDEN"})
    live: BoolProperty(
        name="Live",
        description="Pose the mesh while its handles move. Renders are posed in any case",
        default=True,
        update=_set,
        options=set(),
    )
    dictionary: EnumProperty(
        name="Deform With",
        description="What the mesh is moved by. Applies when it is bound",
        items=DICTIONARIES,
        get=_get_dictionary,
        set=_set_dictionary,
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
            (
                "AVERAGE",
                "Average",
                "As near as can be to all shape keys at once. Smooth, but details fade and not "
                "even a shape key itself is met",
            ),
            (
                "MINIMAL",
                "Nearest Key",
                "The one shape key that has to be bent least. Meets every shape key, and jumps "
                "where another becomes the nearest",
            ),
            (
                "CLOSEST",
                "Nearest Key, Quick",
                "Settles early on the shape key that looks nearest: in ten steps, for fitting",
            ),
        ),
        default="STEADY",
        update=_set,
        options=set(),
    )
    follow_size: BoolProperty(
        name="Follow Size",
        description="Let the whole mesh grow or shrink with its handles. For the methods Average "
        "and Nearest Key",
        default=False,
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
        "0 takes as many as suit what the mesh is deformed with",
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
        description="Loose parts without a handle move with what is nearest to them. Applies when "
        "the mesh is bound",
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

    fit_target: PointerProperty(
        name="Target",
        description="A scan to fit the mesh to, whole or in part: a mesh or a point cloud",
        type=bpy.types.Object,
        poll=lambda rig, obj: obj != rig.id_data and obj.type in {"MESH", "POINTCLOUD"},
    )
    fit_markers: PointerProperty(
        name="Markers",
        description="Empties with the names of handles, which say where those belong on the "
        "target, or alone are the target. Empties that are children of the target count as well",
        type=bpy.types.Collection,
    )
    fit_reach: FloatProperty(
        name="Reach",
        description="How far from the mesh the target may be to draw on it, in parts of the size "
        "of the mesh",
        default=0.1,
        min=0.001,
        soft_max=0.5,
        options=set(),
    )
    fit_firmness: FloatProperty(
        name="Target Firmness",
        description="How much the target counts beside the shape keys; less for a noisy one",
        default=1000.0,
        min=0.001,
        soft_max=10000.0,
        options=set(),
    )

    # What the rig was bound to. The model itself is not saved: it is made again from the vertex
    # groups, the shape keys and this.
    bound: BoolProperty(name="Bound", options={"HIDDEN"})
    result: StringProperty(name="Result", options={"HIDDEN"})
    examples: StringProperty(name="Examples", description="JSON list", options={"HIDDEN"})
    key_names: StringProperty(description="JSON list, of all keys in order", options={"HIDDEN"})
    vertex_count: IntProperty(options={"HIDDEN"})
    topology: StringProperty(options={"HIDDEN"})
    # Which dictionary was chosen, empty for the default, and which the rig was bound with, empty
    # where that was before there was a choice.
    chosen_dictionary: StringProperty(options={"HIDDEN"})
    bound_dictionary: StringProperty(options={"HIDDEN"})
    bound_group_count: IntProperty(options={"HIDDEN"})
    function_count: IntProperty(options={"HIDDEN"})
    groups: StringProperty(description="JSON list", options={"HIDDEN"})
    bones_source: StringProperty(options={"HIDDEN"})  # digest of the shapes they were found in
    # Driven by the handles, so that Blender evaluates them even where they are hidden.
    reach: FloatProperty(options={"HIDDEN", "ANIMATABLE"})


CLASSES = (TUG_PG_handle, TUG_PG_bone, TUG_PG_shape, TUG_PG_rig)

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    _register_classes()
    bpy.types.Object.tug = PointerProperty(type=TUG_PG_rig)


def unregister() -> None:
    del bpy.types.Object.tug
    _unregister_classes()
