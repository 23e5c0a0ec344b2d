# SPDX-License-Identifier: GPL-3.0-or-later
"""The solvers in memory, one for each rig that was asked for a pose.

Nothing of it is saved: a solver is made again whenever the one in memory does not fit. Two kinds of
change are told apart. Faces, keys or handles that came or went since the bind make the rig stale:
asking for a pose fails and says to bind again. Coordinates, painted weights and settings that
changed make a new solver without a word, so that a pose is always what the saved file would give.
To find those takes a look at the whole mesh, so it is done only after something touched the rig.
"""

from __future__ import annotations

import functools
import threading
import time
from dataclasses import dataclass, field

import bpy
import numpy as np

from ..geometry import Mesh, Rows
from ..native import Progress, TugError, part
from ..smoothing import Solution
from ..solver import Form, Model, SolveInfo, Solver
from . import functions, inputs
from .functions import Stored
from .inputs import Inputs, RigError

# Of object.tug: the digest of handles and settings that the result key shows the pose for. It is
# saved and undone with the key, so that neither undo nor load need a solve.
POSED = "posed"
SCALING = (Form.AVERAGE, Form.MINIMAL, Form.CLOSEST)  # the forms that may change a mesh's size


@dataclass(frozen=True)
class Recipe:
    """All that a solver is made from, as it is read off an object.

    dictionary: what it is to be; stored: its functions, or None where they are to be computed.
    group_count: how many edge groups to ask for.
    """

    given: Inputs
    dictionary: str
    stored: Stored | None
    group_count: int
    options: dict[str, float]

    def digest(self) -> str:
        """Of all that a model depends on."""
        given = self.given
        stored = (self.stored.weights, self.stored.groups) if self.stored else ()
        return inputs.digest(
            *(given.shapes, given.triangles, given.handles, given.stiffness),
            *(array for array in stored if array is not None),
            np.array([self.group_count]),
        )

    def make(self, mesh: Mesh, progress: Progress | None = None) -> Live:
        """The solver, on any thread. mesh: of the rest shape. May raise TugError."""
        given = self.given
        functions = self.stored.functions(mesh, self.group_count, part(progress, 0.0, 0.1))
        rows = Rows.pin(given.handles)
        with Model(
            *(mesh, given.solved_shapes, functions.weights, rows, functions.groups),
            stiffness=given.stiffness,
            progress=part(progress, 0.1, 1.0),
        ) as model:
            return Live(
                solver=Solver(model, **self.options),
                content=self.digest(),
                options=self.options,
                axes=given.axes,
                rest=given.shapes[0].astype(np.float64),
                triangles=given.triangles,
                groups=functions.groups,
            )


@dataclass(frozen=True)
class Pull:
    """What the handles ask for: #H by 3 targets in object space, and how firmly each is held, #H
    (see Solver.set_firmness)."""

    targets: np.ndarray
    firmness: np.ndarray

    def digest(self) -> str:
        return inputs.digest(self.targets, self.firmness)


@dataclass(frozen=True)
class LastSolve:
    """How the last pose was found, and in how many seconds, positions included."""

    info: SolveInfo
    seconds: float


@dataclass
class Live:
    """A solver, what it was made from, and a lock: renders ask for poses from a thread of their
    own. triangles: #F by 3; groups: #F, the number of each one's group."""

    solver: Solver
    content: str
    options: dict[str, float]
    axes: list[int]
    rest: np.ndarray
    triangles: np.ndarray
    groups: np.ndarray
    touched: bool = False
    last: LastSolve | None = None
    lock: threading.Lock = field(default_factory=threading.Lock)

    @functools.cached_property
    def shares(self) -> np.ndarray:
        """#V by #G: how much of the triangles around each vertex is of each group."""
        vertices, groups = len(self.rest), self.solver.sizes.groups
        cells = self.triangles * groups + self.groups[:, None]
        counts = np.bincount(cells.ravel(), minlength=vertices * groups).reshape(vertices, groups)
        return (counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)).astype(np.float32)

    def blend(self) -> np.ndarray:
        """#G by #S weights of the shapes in the last pose."""
        with self.lock:
            return self.solver.blend()

    def solution(self, pull: Pull) -> Solution:
        """What a solve finds, to be averaged and shown."""
        targets = pull.targets[:, self.axes]
        with self.lock:
            self.solver.set_firmness(pull.firmness)
            self.solver.solve(targets)
            blend, rotations = self.solver.blend(), self.solver.rotations()
            scale = self.solver.scale()
        return Solution(targets, blend, rotations, pull.firmness, scale)

    def shown(self, solution: Solution) -> np.ndarray:
        """#V by 3 positions of a solution, in object space."""
        scale = solution.scale
        with self.lock:
            self.solver.set_firmness(solution.firmness)
            # A pose is found for the shapes as given: this is the one for larger shapes, shrunk.
            self.solver.pose(solution.targets / scale, solution.blend, solution.rotations)
            return self._in_space(scale * self.solver.positions())

    def pose(self, pull: Pull) -> tuple[np.ndarray, SolveInfo]:
        """#V by 3 positions, in object space."""
        started = time.perf_counter()
        with self.lock:
            self.solver.set_firmness(pull.firmness)
            info = self.solver.solve(pull.targets[:, self.axes])
            positions = self._in_space(self.solver.positions())
        self.last = LastSolve(info, time.perf_counter() - started)
        return positions, info

    def _in_space(self, positions: np.ndarray) -> np.ndarray:
        """#V by 3, where a flat mesh is solved in its plane."""
        if len(self.axes) == 3:
            return positions
        found = self.rest.copy()
        found[:, self.axes] = positions
        return found


# By session_uid, which survives renaming and undo; a Blender object would not.
_registry: dict[int, Live] = {}
_registry_lock = threading.RLock()


def current(obj: bpy.types.Object, scene: bpy.types.Scene) -> Live:
    """The solver that fits the object now, made where need be. Raises RigError if stale."""
    with _registry_lock:
        check(obj, scene)
        live = _registry.get(obj.session_uid)
        if live is None or live.touched or live.options != solver_options(obj):
            live = _registry[obj.session_uid] = _refreshed(obj, live)
        return live


def known(obj: bpy.types.Object) -> Live | None:
    """The solver in memory, whether it still fits or not."""
    return _registry.get(obj.session_uid)


def keep(obj: bpy.types.Object, live: Live) -> None:
    with _registry_lock:
        _registry[obj.session_uid] = live


def touch(obj: bpy.types.Object) -> None:
    """Something about the object may have changed: look before its next pose."""
    if live := _registry.get(obj.session_uid):
        live.touched = True


def invalidate(obj: bpy.types.Object) -> None:
    """The same, and the pose that is shown may no longer be the one for its handles."""
    touch(obj)
    if POSED in obj.tug:
        del obj.tug[POSED]


def touch_all() -> None:
    for live in list(_registry.values()):
        live.touched = True


def forget(obj: bpy.types.Object) -> None:
    _registry.pop(obj.session_uid, None)


def forget_all() -> None:
    _registry.clear()


def solver_options(obj: bpy.types.Object) -> dict[str, float]:
    rig = obj.tug
    form = Form[rig.form]
    return {
        "form": form,
        # Properties are float32: this is the number that was typed.
        "lambda_": round(rig.selectivity, 6),
        "prior": round(rig.steadiness, 6),
        "single_blend": rig.single_blend,
        "squared": rig.squared,
        "scale": rig.follow_size and form in SCALING,
    }


def read(obj: bpy.types.Object) -> Recipe:
    """The recipe of a bound object, at a look at the whole mesh."""
    if inputs.topology(obj.data) != obj.tug.topology:
        raise _stale(obj, "its faces were edited")
    given = inputs.gather(obj, inputs.bound_examples(obj), obj.tug.handles)
    return recipe(obj, given, functions.read(obj, given))


def recipe(obj: bpy.types.Object, given: Inputs, stored: Stored | None) -> Recipe:
    count = functions.group_count(obj, len(given.handles))
    return Recipe(given, obj.tug.dictionary, stored, count, solver_options(obj))


def alive(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[bool]:
    """For each handle, whether its empty is still there. Deleting an empty in the viewport takes it
    out of the scene only: the pointer of the rig keeps it in the file."""
    names = set(scene.objects.keys())  # many times faster than asking for each name
    empties = [handle.empty for handle in obj.tug.handles]
    return [empty is not None and empty.name in names for empty in empties]


def _refreshed(obj: bpy.types.Object, live: Live | None) -> Live:
    recipe = read(obj)
    if live and (live.content, live.options) == (recipe.digest(), recipe.options):
        live.touched = False
        return live
    try:
        with Mesh(recipe.given.solved_shapes[0], recipe.given.triangles) as mesh:
            return recipe.make(mesh)
    except TugError as error:
        raise RigError(f'"{obj.name}" cannot be solved: {error.reason}') from error


def check(obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Raises RigError where the object is no longer what was bound, as far as microseconds tell."""
    inputs.check_object(obj)
    rig, keys = obj.tug, obj.data.shape_keys
    if not rig.bound:
        raise RigError(f'"{obj.name}" is not bound: bind it first')
    examples = inputs.bound_examples(obj)
    if len(obj.data.vertices) != rig.vertex_count:
        counts = f"from {rig.vertex_count} to {len(obj.data.vertices)}"
        raise _stale(obj, f"its number of vertices went {counts}")
    for name in (rig.result, *examples):
        if name not in keys.key_blocks:
            raise _stale(obj, f'its shape key "{name}" was deleted or renamed')
    if keys.reference_key.name != examples[0]:
        raise _stale(obj, f'its shape key "{examples[0]}" is no longer the first')
    for handle, is_alive in zip(rig.handles, alive(obj, scene), strict=True):
        if not is_alive:
            raise _stale(obj, f'its handle "{handle.name}" was deleted')
        if handle.rest_vertex < 0:
            raise _stale(obj, f'its handle "{handle.name}" is new')
    if reason := functions.changed(obj):
        raise _stale(obj, reason)


def _stale(obj: bpy.types.Object, reason: str) -> RigError:
    return RigError(f'"{obj.name}" has changed since it was bound, {reason}: bind it again')
