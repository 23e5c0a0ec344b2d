# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does with a rig: add handles, bind, unbind; and its poses."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np

from ..native import Progress, TugError
from ..smoothing import Solution
from ..solver import SolveInfo
from . import functions, inputs, live, shape_keys
from .inputs import RigError
from .job import Job
from .live import Pull

HANDLE_SIZE = 0.03  # of an empty, relative to the diagonal of the mesh
SAME_PLACE = 1e-5  # relative to the diagonal, for a vertex that an edit of the mesh renumbered


@dataclass(frozen=True)
class BindSummary:
    """What a bind made and how long each part took, in seconds."""

    vertices: int
    shapes: int
    handles: int
    groups: int
    dimension: int
    weights_computed: bool  # False: they were read from the vertex groups
    warnings: str  # about the mesh, a line each
    weights_seconds: float
    model_seconds: float
    solve_seconds: float


def add_handle(obj: bpy.types.Object, vertex: int, name: str) -> bpy.types.Object:
    """A new empty at the vertex as it is displayed now; the next bind lets it pin the vertex."""
    inputs.check_object(obj)
    inputs.check_local(obj)
    points = shape_keys.displayed(obj)
    if not 0 <= vertex < len(points):
        raise RigError(f'"{obj.name}" has no vertex {vertex}, only 0 to {len(points) - 1}')
    world = np.array(obj.matrix_world)
    points = points @ world[:3, :3].T + world[:3, 3]
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = HANDLE_SIZE * np.linalg.norm(np.ptp(points, axis=0))
    empty.location = points[vertex]
    empty.show_in_front = empty.show_name = True
    handle_collection(obj).objects.link(empty)
    handle = obj.tug.handles.add()
    handle.name, handle.empty, handle.vertex = empty.name, empty, vertex
    obj.update_tag()
    return empty


def bind(obj: bpy.types.Object, progress: Progress | None = None) -> BindSummary:
    """Make the model and show its pose in the result key.

    Weights are read from the handles' vertex groups where they are there, else computed and written
    there. Handles that were deleted are dropped. On an error the scene is as it was. About a second
    at 20,000 vertices.
    """
    job = plan_bind(obj)
    job.build(progress)
    return finish_bind(obj, job)


def plan_bind(obj: bpy.types.Object) -> Job:
    """The first part of a bind: check and read everything, on the main thread. The second, which
    takes the time, is Job.build, on any thread; finish_bind is the last."""
    inputs.check_object(obj)
    inputs.check_local(obj)
    handles = _alive_handles(obj)
    examples = inputs.ticked(obj)
    given = inputs.gather(obj, examples, handles, _found_again(obj, handles))
    return Job(
        name=obj.name,
        identity=obj.session_uid,
        examples=examples,
        recipe=live.recipe(obj, given, functions.to_bind(obj, handles, given)),
        follow_nearest=obj.tug.follow_nearest,
        pull=_pull(obj, bpy.context.evaluated_depsgraph_get(), live.alive(obj, bpy.context.scene)),
    )


def finish_bind(obj: bpy.types.Object, job: Job) -> BindSummary:
    """The last part of a bind: write what was built, on the main thread.

    Handles may have been pulled meanwhile. Raises RigError, and changes nothing, where anything
    else about the object is no longer what was read.
    """
    now, built = plan_bind(obj), job.built
    if built is None:
        raise ValueError("the job has not been built")
    if not now.agrees_with(job):
        raise RigError(f'"{obj.name}" was edited while it was being bound: bind it again')
    pose = built.pose
    if now.pull.digest() != job.pull.digest():
        with _explaining(obj):
            pose, _ = built.live.pose(now.pull)
    drop_deleted_handles(obj)
    _keep_handles(obj, job)
    functions.keep(obj, job.given, built.recipe.stored, computed=job.computes)
    _keep_keys(obj, job.examples)
    _keep_state(obj, job)
    live.keep(obj, built.live)
    _write(obj, pose, now.pull)
    return BindSummary(
        vertices=len(pose),
        shapes=len(job.examples),
        handles=len(job.given.handles),
        groups=built.live.solver.sizes.groups,
        dimension=len(job.given.axes),
        weights_computed=job.computes,
        warnings=built.warnings,
        weights_seconds=built.seconds[0],
        model_seconds=built.seconds[1],
        solve_seconds=built.seconds[2],
    )


def unbind(obj: bpy.types.Object) -> None:
    """Take the result key away and show the artist's keys as before the bind. Handles and vertex
    groups stay."""
    rig, keys = obj.tug, obj.data.shape_keys
    rig.dictionary = rig.dictionary  # the default is that of a rig never bound
    functions.drop_attributes(obj.data)
    if keys is not None:
        for name in inputs.bound_examples(obj):
            _unmute(obj, name)
        if rig.result in keys.key_blocks:
            obj.shape_key_remove(keys.key_blocks[rig.result])
    obj.driver_remove("tug.reach")
    rig.bound, rig.result = False, ""
    live.invalidate(obj)
    live.forget(obj)


def positions(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """The pose for the handles as `depsgraph` has them: #V by 3 in object space. Writes nothing."""
    current = live.current(obj, depsgraph.scene)
    with _explaining(obj):
        return current.pose(_pull(obj, depsgraph))[0]


def solution(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Solution:
    """What a solve finds for the handles as `depsgraph` has them. Writes nothing."""
    current = live.current(obj, depsgraph.scene)
    with _explaining(obj):
        return current.solution(_pull(obj, depsgraph))


def shown(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, given: Solution) -> np.ndarray:
    """#V by 3 positions of a solution, in object space. Writes nothing."""
    current = live.current(obj, depsgraph.scene)
    with _explaining(obj):
        return current.shown(given)


def solve(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, pull: Pull | None = None
) -> SolveInfo:
    """Write the pose for the handles as `depsgraph` has them to the result key. pull: what they ask
    for, where it was read already."""
    current = live.current(obj, depsgraph.scene)
    pull = pull or _pull(obj, depsgraph)
    with _explaining(obj):
        pose, info = current.pose(pull)
    _write(obj, pose, pull)
    return info


def follow(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """`solve`, unless the result key already shows the pose for these handles and settings. What it
    shows is kept with the object, so after undo, redo or load nothing is solved."""
    live.check(obj, depsgraph.scene)
    pull = _pull(obj, depsgraph)
    if obj.tug.get(live.POSED) != _asked(obj, pull):
        solve(obj, depsgraph, pull)


def show(obj: bpy.types.Object, pose: np.ndarray, depsgraph: bpy.types.Depsgraph) -> None:
    """Write #V by 3 positions to the result key; they stay until handles or settings change."""
    _write(obj, pose, _pull(obj, depsgraph))


def _write(obj: bpy.types.Object, pose: np.ndarray, pull: Pull) -> None:
    inputs.check_local(obj)
    result = obj.data.shape_keys.key_blocks[obj.tug.result]
    shape_keys.write(obj.data, result, pose)
    # No property of its own, as setting one would have Blender evaluate the object once more.
    obj.tug[live.POSED] = _asked(obj, pull)


def _asked(obj: bpy.types.Object, pull: Pull) -> str:
    """Digest of what a pose depends on besides the model."""
    options = np.array([*live.solver_options(obj).values()], np.float64)
    return pull.digest() + inputs.digest(options)


@contextmanager
def _explaining(obj: bpy.types.Object) -> Iterator[None]:
    try:
        yield
    except TugError as error:
        raise RigError(f'"{obj.name}" cannot be solved: {error.reason}') from error


def _pull(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, is_used: Sequence[bool] | None = None
) -> Pull:
    """What the handles ask for, or those of them that are used, as `depsgraph` has them."""
    handles, evaluated = obj.tug.handles, obj.evaluated_get(depsgraph).tug.handles
    numbers = [n for n in range(len(handles)) if is_used is None or is_used[n]]
    firmness = np.array([_firmness(evaluated[number]) for number in numbers])
    if not firmness.any():
        raise RigError(f'every handle of "{obj.name}" is free: none is left to pull it by')
    return Pull(_targets(obj, [handles[number].empty for number in numbers], depsgraph), firmness)


def _firmness(handle: bpy.types.PropertyGroup) -> float:
    return {"PINNED": np.inf, "SOFT": handle.firmness, "FREE": 0.0}[handle.hold]


def _targets(
    obj: bpy.types.Object,
    empties: Sequence[bpy.types.Object],
    depsgraph: bpy.types.Depsgraph,
) -> np.ndarray:
    """#H by 3: where empties are, in the space of the object."""
    world = np.array([empty.evaluated_get(depsgraph).matrix_world.translation for empty in empties])
    matrix = obj.evaluated_get(depsgraph).matrix_world
    x, y, z = (tuple(column)[:3] for column in matrix.col[:3])
    # By Cramer's rule: LAPACK's threads take milliseconds to start beside Blender's.
    inverse = np.array([_cross(y, z), _cross(z, x), _cross(x, y)]).T
    volume = np.dot(x, inverse[:, 0])
    if volume == 0:
        raise RigError(f'"{obj.name}" has a scale of zero: its handles cannot be told apart')
    return (world - matrix.translation) @ inverse / volume


def _cross(u: Sequence[float], v: Sequence[float]) -> tuple[float, float, float]:
    """Of single vectors, for which NumPy's takes ten times as long."""
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


def handle_collection(obj: bpy.types.Object) -> bpy.types.Collection:
    """Where the object's handles are, made where it is missing."""
    rig, scenes = obj.tug, obj.users_scene or [bpy.context.scene]
    if rig.collection is None:
        rig.collection = bpy.data.collections.new(f"{obj.name} Handles")
    if not any(rig.collection in scene.collection.children_recursive for scene in scenes):
        home = obj.users_collection[0] if obj.users_collection else scenes[0].collection
        home.children.link(rig.collection)  # it is new, or was deleted in the Outliner
    return rig.collection


def _alive_handles(obj: bpy.types.Object) -> list[bpy.types.PropertyGroup]:
    is_alive = live.alive(obj, bpy.context.scene)
    return [handle for handle, there in zip(obj.tug.handles, is_alive, strict=True) if there]


def _found_again(obj: bpy.types.Object, handles: Sequence[bpy.types.PropertyGroup]) -> list[int]:
    """The vertices of the handles, where an edit of the faces may have renumbered them."""
    if not obj.tug.bound or inputs.topology(obj.data) == obj.tug.topology:
        return [handle.vertex for handle in handles]
    rest = shape_keys.coordinates(obj.data.shape_keys.reference_key)
    tolerance = SAME_PLACE * np.linalg.norm(np.ptp(rest, axis=0))
    vertices = []
    for handle in handles:
        if handle.rest_vertex != handle.vertex:  # new, or put on this vertex by the artist
            vertices.append(handle.vertex)
            continue
        distance = np.linalg.norm(rest - np.array(handle.rest), axis=1)
        if distance.min() > tolerance:
            raise RigError(
                f'the vertex of the handle "{handle.name}" is no longer there since '
                f'"{obj.name}" was edited: put the handle on another vertex or delete it'
            )
        vertices.append(int(distance.argmin()))
    return vertices


def drop_deleted_handles(obj: bpy.types.Object) -> None:
    is_alive = live.alive(obj, bpy.context.scene)
    for number in reversed(range(len(is_alive))):
        if not is_alive[number]:
            functions.drop_handle(obj, number)


def _keep_handles(obj: bpy.types.Object, job: Job) -> None:
    for handle, vertex in zip(obj.tug.handles, job.given.handles, strict=True):
        handle.name = handle.empty.name
        handle.vertex = handle.rest_vertex = int(vertex)
        handle.rest = job.given.shapes[0, vertex]


def _keep_keys(obj: bpy.types.Object, examples: Sequence[str]) -> None:
    rig, keys = obj.tug, obj.data.shape_keys
    before = inputs.bound_examples(obj)
    for name in set(before) - set(examples):
        _unmute(obj, name)
    for name in examples[1:]:
        shape = rig.shapes.get(name) or rig.shapes.add()
        shape.name = name
        block = keys.key_blocks[name]
        if name not in before:
            shape.was_muted = block.mute
        block.mute = True
    result = keys.key_blocks.get(rig.result) or shape_keys.add_result(obj)
    rig.result = result.name
    result.mute = False


def _unmute(obj: bpy.types.Object, name: str) -> None:
    block = obj.data.shape_keys.key_blocks.get(name)
    if block is not None and name in obj.tug.shapes:
        block.mute = obj.tug.shapes[name].was_muted


def _keep_state(obj: bpy.types.Object, job: Job) -> None:
    rig = obj.tug
    rig.bound = True
    rig.examples = json.dumps(job.examples)
    rig.key_names = json.dumps(obj.data.shape_keys.key_blocks.keys())
    rig.vertex_count = len(obj.data.vertices)
    rig.topology = job.given.topology
    tie(obj)


def tie(obj: bpy.types.Object) -> None:
    """Let Blender update the object whenever a handle moves."""
    obj.driver_remove("tug.reach")
    driver = obj.driver_add("tug.reach").driver
    driver.type = "SUM"
    for handle in obj.tug.handles:
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        variable.targets[0].id = handle.empty
