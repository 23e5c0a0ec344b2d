# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on the time of solves and positions: frame, single_shape_step, positions_25k,
positions_100k, dense_kernels, handles_100_shapes_20, growth."""

from __future__ import annotations

import multiprocessing
import resource
import subprocess
import time
from collections.abc import Iterator

import numpy as np
from continuity import draw_paths
from data import ExampleSet
from generated import tube
from library import (
    CHECKOUT,
    Dictionary,
    Form,
    Mesh,
    Model,
    Rows,
    Solver,
    cluster_triangles,
    compute_weights,
    native,
)
from methods import AMRAP, DEFAULT, Choice, Tally, Tug, make, peers
from rigs import Rig
from suite import HANDLES, TABLE, Row, Suite, compare, not_run
from timing import position_seconds, seconds_of, solve_seconds

FRAMES = 24  # of each path
PATHS = 3
END = 1e-7  # radians, the tolerance of the costs' own rotations
MEMORY_ALLOWED = 4e9  # bytes, of the process with 100 handles
GROWTH_BASE = {"n": 4000, "H": 10, "S": 6, "G": 20}
GROWTH = {
    "n": (2000, 4000, 8000, 16000),
    "H": (5, 10, 20, 40),
    "S": (3, 6, 12, 24),
    "G": (10, 20, 40, 80),
}


def along_paths(poses: ExampleSet, handles: np.ndarray, frames: int) -> np.ndarray:
    """Frames between, not on, examples: so many of each path."""
    paths = draw_paths(poses, handles, PATHS)
    return np.concatenate([path.frames(frames + 1)[1:-1] for path in paths])


def prepared(poses: ExampleSet, handle_count: int, *names: str) -> tuple[list[Tug], np.ndarray]:
    """Methods of Tug, and frames to solve."""
    handles = poses.spread_handles(handle_count)
    rig = Rig(poses.shapes, poses.triangles, handles)
    return [make(name, rig) for name in names], along_paths(poses, handles, FRAMES)


def converges(method: Tug, frames: np.ndarray, suite: Suite, row: str) -> bool:
    """Whether all frames do; the tally counts them."""
    converged = sum(method.solve(frame).converged for frame in frames) == len(frames)
    suite.tally.add(method.tally, row)
    return converged


def frame_rows(suite: Suite) -> Iterator[Row]:
    """A new pose from nothing by the default pair, on the models of Table 1; beside it the same
    energy on the handles' functions, and the paper's."""
    medians, all_converged = [], True
    for name in suite.chosen(TABLE):
        shapes, handle_count = TABLE[name]
        poses = suite.load(name).first(shapes)
        peer_names = (AMRAP, "paper")
        (method, *others), frames = prepared(poses, handle_count, DEFAULT, *peer_names)
        converged = converges(method, frames, suite, f"frame, {name}")
        milliseconds, *theirs = (
            1e3 * float(np.median(solve_seconds(one.solver, frames))) for one in (method, *others)
        )
        sizes = vars(method.solver.sizes) | {"model": name, "frames": len(frames)}
        metric = f"a new pose, cold, {name}"
        for peer, value in zip(peer_names, theirs, strict=True):
            yield compare("frame", metric, "ms", milliseconds, peer, value, converged, sizes)
        medians.append(milliseconds)
        all_converged &= converged
    metric = "a new pose, cold, largest of the medians"
    yield Row("frame", metric, "ms", max(medians), converged=all_converged)


def single_shape_rows(suite: Suite) -> Iterator[Row]:
    """A local and global step, from solves of 50 and of 150 of them; the same problem to its end by
    Newton's method and by such steps; and all of a pose of one shape."""
    name = "single_shape_step"
    poses = tube(5000, 2)
    handles = poses.spread_handles(HANDLES)
    frames = along_paths(poses, handles, FRAMES)
    rig = Rig(poses.shapes[:1], poses.triangles, handles)
    method = make(AMRAP, rig)
    sizes = {"handles": HANDLES, "groups": method.solver.sizes.groups}
    times = [alternation_microseconds(rig, frames, rounds) for rounds in (50, 150)]
    step = (times[1] - times[0]) / 100
    yield Row(name, "a local and global step", "us", step, sizes=sizes)
    if "fast" in peers():
        newton, steps = converged_microseconds(fast(rig), frames)
        peer, rounds = converged_microseconds(
            fast(rig, local_global=1, max_rounds=100_000, tolerance=END), frames
        )
        metric = f"rotations and costs to {END:g} radians, {steps:g} Newton steps"
        yield compare(
            *(name, metric, "us", newton, f"{rounds:g} local and global steps", peer),
            *(True, sizes),
        )
    whole = 1e6 * float(np.median(solve_seconds(method.solver, frames, repeats=5)))
    metric = "all of a single shape's pose, cold, converged"
    converged = converges(method, frames, suite, name)
    yield Row(name, metric, "us", whole, converged=converged, sizes=sizes)


def fast(rig: Rig, **options: float) -> object:
    """FAST on the shape and the weights that Tug would be given."""
    from baselines import Fast

    functions = rig.functions(Dictionary.HANDLES)
    given = (rig.shapes, rig.triangles, rig.handles, functions.weights, functions.groups)
    return Fast(*given, **options)


def converged_microseconds(method: object, frames: np.ndarray) -> tuple[float, float]:
    """Medians of the time and of the steps."""
    times = [seconds_of(lambda at=frame: method.solve(at), 5).min() for frame in frames]
    steps = [method.solve(frame).rounds for frame in frames]
    return 1e6 * float(np.median(times)), float(np.median(steps))


def alternation_microseconds(rig: Rig, frames: np.ndarray, rounds: int) -> float:
    """Median of solves of so many rounds: by FAST's alternation where it was built, else by the
    paper's form on one shape. What Python adds is the same for any number of rounds."""
    options = {"max_rounds": rounds, "tolerance": 1e-300}
    if "fast" in peers():
        method = fast(rig, local_global=1, **options)
    else:
        method = Tug(rig, Choice({"form": Form.PAPER, **options}))
    return converged_microseconds(method, frames)[0]


def position_rows(suite: Suite, name: str, vertices: int) -> Iterator[Row]:
    """tug_get_positions with 7 handles and 6 shapes, of a function a handle and of the default
    pair; NumPy's product of the same sizes beside it."""
    methods, frames = prepared(tube(int(suite.size * vertices), 6), 7, AMRAP, DEFAULT)
    metric = "positions of a solved pose"
    for method, what in zip(methods, (metric, f"{metric}, {DEFAULT}"), strict=True):
        method.solve(frames[0])
        milliseconds = 1e3 * float(np.median(position_seconds(method.solver, 50)))
        sizes = vars(method.solver.sizes)
        D = np.random.default_rng(0).random((sizes["vertices"], sizes["unknowns"]))
        T = np.random.default_rng(1).random((sizes["unknowns"], 3))
        peer = 1e3 * min(timed(lambda D=D, T=T: D @ T) for _ in range(10))
        yield compare(name, what, "ms", milliseconds, "NumPy, dense D T", peer, None, sizes)


def timed(call: object) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def kernel_rows() -> Iterator[Row]:
    """The dense kernels of a solve beside OpenBLAS's, as they are inside libtug."""
    program = CHECKOUT / "build" / "release" / "native" / "time_kernels"
    if not program.exists():
        yield not_run("dense_kernels", f"{program} was not built")
        return
    run = subprocess.run([program], check=True, capture_output=True, text=True)
    for line in run.stdout.splitlines():
        what, rows, ours, peer = line.split()
        metric = f"{what}, {rows} rows"
        yield compare("dense_kernels", metric, "us", float(ours), "OpenBLAS", float(peer), None, {})


def many_handles_rows(suite: Suite) -> Iterator[Row]:
    """100 handles and 20 shapes, in a process with bounded memory."""
    name, count, shapes = "handles_100_shapes_20", *((20, 8) if suite.quick else (100, 20))
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=solve_many_handles, args=(count, shapes, sender))
    process.start()
    sender.close()
    try:
        result = receiver.recv()
    except EOFError:
        result = "the process ended early"
    process.join()
    if isinstance(result, str):
        yield not_run(name, result)
        return
    milliseconds, positions_ms, bind_seconds, memory, added, converged, sizes, tally = result
    suite.tally.add(tally)
    yield Row(name, "a new pose, cold", "ms", milliseconds, converged=converged, sizes=sizes)
    yield Row(name, "positions", "ms", positions_ms, sizes=sizes)
    yield Row(name, "functions, groups and model", "s", bind_seconds, sizes=sizes)
    yield Row(name, "memory of the process at its peak", "GB", memory, sizes=sizes)
    yield Row(name, "of it, since the mesh was there", "GB", added, sizes=sizes)


def solve_many_handles(handle_count: int, shapes: int, sender: object) -> None:
    """Send times and memory, or the reason why there are none."""
    resource.setrlimit(resource.RLIMIT_AS, (int(MEMORY_ALLOWED),) * 2)
    suite = Suite(folder=None, quick=False)
    try:
        poses = tube(10_000, shapes)
        before = peak_gigabytes()
        start = time.perf_counter()
        (method,), frames = prepared(poses, handle_count, DEFAULT)
        bind_seconds = time.perf_counter() - start
    except (native.TugError, MemoryError) as error:
        sender.send(f"{error} in {1e-9 * MEMORY_ALLOWED:g} GB")
        return
    frames = frames[::12]
    converged = converges(method, frames, suite, "handles_100_shapes_20")
    milliseconds = 1e3 * float(np.median(solve_seconds(method.solver, frames)))
    positions_ms = 1e3 * float(np.median(position_seconds(method.solver, 10)))
    memory = peak_gigabytes()
    times = (milliseconds, positions_ms, bind_seconds)
    sizes = vars(method.solver.sizes)
    sender.send((*times, memory, memory - before, converged, sizes, suite.tally))


def peak_gigabytes() -> float:
    """Of this process: what of it was in memory at most."""
    return 1024e-9 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def growth_rows(suite: Suite) -> Iterator[Row]:
    """Exponents p of time ~ x^p, fitted to four sizes, the others at GROWTH_BASE."""
    scaled = {"n": [int(suite.size * n) for n in GROWTH["n"]]}
    base = GROWTH_BASE | {"n": int(suite.size * GROWTH_BASE["n"])}
    for letter, values in (GROWTH | scaled).items():
        tally = Tally()
        times = np.array([grow(base | {letter: x}, tally) for x in values])
        suite.tally.add(tally, f"growth in {letter}")
        exponents = np.polyfit(np.log(values), np.log(times), 1)[0]
        sizes = {"values": values} | {k: v for k, v in base.items() if k != letter}
        for what, exponent, column in zip(
            ("model", "solve", "positions"), exponents, times.T, strict=True
        ):
            seconds = {"seconds": column.tolist()}
            metric = f"exponent of {what} in {letter}"
            converged = tally.unconverged == 0 if what == "solve" else None
            sized = {"converged": converged, "sizes": sizes | seconds}
            yield Row("growth", metric, "", float(exponent), **sized)


def grow(size: dict[str, int], tally: Tally) -> tuple[float, float, float]:
    """Seconds of model, solve and positions, each a median."""
    poses = tube(size["n"], size["S"])
    handles = poses.spread_handles(size["H"])
    with Mesh(poses.shapes[0], poses.triangles) as mesh:
        weights, _ = compute_weights(mesh, [[handle] for handle in handles])
        groups = cluster_triangles(mesh, weights, size["G"])
        given = (mesh, poses.shapes, weights, Rows.pin(handles), groups)
        model_seconds = np.median(seconds_of(lambda: Model(*given).close(), 3))
        model = Model(*given)
    with Solver(model) as solver:
        frames = along_paths(poses, handles, 4)
        for frame in frames:
            tally.count(solver.solve(frame), Form.STEADY, poses.diagonal)
        solve = np.median(solve_seconds(solver, frames))
        positions = np.median(position_seconds(solver, 20))
    model.close()
    return float(model_seconds), float(solve), float(positions)
