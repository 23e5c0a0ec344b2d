# SPDX-License-Identifier: GPL-3.0-or-later
"""FBT's Figure 7: half of a fox is completed, and its points are found again, from one to eight
other poses; and by Der's reduced deformable model in place of Tug."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from fox_poses import mixtures
from project import (
    DISTANCES,
    ON_BONES,
    OURS,
    PEER,
    Dictionary,
    Experiment,
    Mesh,
    Outcome,
    Sample,
    bodies,
    creature,
    fit,
    make_functions,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EXPERIMENTS = 50
MIXTURES = 9  # beside the seven poses of the scene
SHOWN = 6  # experiment: the fox pounces
TILES = {"1 example": "1 example", "8 examples": "8 examples", PEER: "Der et al. 2006"}
TITLES = {"completed": "completion", "registered": "registration"}
LABELS = {
    "completed": "% of the surface within the distance",
    "registered": "% of the matches within the distance",
}


@dataclass(frozen=True)
class Curves:
    """outcomes: by method, one for each experiment. shown, poses: an experiment and what the
    methods make of it."""

    sample: Sample
    outcomes: dict[str, list[Outcome]]
    shown: Experiment
    poses: dict[str, np.ndarray]


def fox_shapes(sample: Sample) -> np.ndarray:
    """#P by #V by 3."""
    rest, quads = sample.shapes["Basis"], np.array(sample.faces)
    more = creature.posed(rest, quads, mixtures(MIXTURES, np.random.default_rng(7)))
    return np.stack([*sample.shapes.values(), *more.values()])


def measure(experiments: int = EXPERIMENTS) -> Curves:
    sample = creature.sample()
    shapes, triangles = fox_shapes(sample), sample.triangles()
    outcomes: dict[str, list[Outcome]] = {}
    for seed in range(experiments):
        experiment = Experiment.draw(shapes, triangles, np.random.default_rng(seed))
        found = complete(experiment)
        for method, (outcome, _) in found.items():
            outcomes.setdefault(method, []).append(outcome)
        if seed == min(SHOWN, experiments - 1):
            shown, poses = experiment, {method: pose for method, (_, pose) in found.items()}
    return Curves(sample, outcomes, shown, poses)


def complete(experiment: Experiment) -> dict[str, tuple[Outcome, np.ndarray]]:
    """By every method."""
    with Mesh(experiment.examples[0], experiment.faces) as mesh:
        functions, bones = (
            make_functions(kind, mesh, experiment.examples, ())
            for kind in (Dictionary.EIGENFUNCTIONS, Dictionary.SKELETON)
        )
    made = bodies(experiment, functions, bones)
    features = experiment.discs(made[OURS[0]])
    return {method: fit(experiment, body, features) for method, body in made.items()}


def numbers(curves: Curves) -> dict[str, object]:
    """For each method the mean distance from the truth after and before the registration, in parts
    of the root of the area, and the curves."""
    table = {}
    for method, outcomes in curves.outcomes.items():
        table[method] = {
            "error": float(np.mean([outcome.error for outcome in outcomes])),
            "start": float(np.mean([outcome.start for outcome in outcomes])),
            **{what: curve_of(outcomes, what).tolist() for what in TITLES},
        }
    count = len(next(iter(curves.outcomes.values())))
    return {"experiments": count, "distances": DISTANCES.tolist(), "methods": table}


def curve_of(outcomes: list[Outcome], what: str) -> np.ndarray:
    return np.mean([getattr(outcome, what) for outcome in outcomes], axis=0)


def draw(curves: Curves, path: Path) -> None:
    import drawing

    figure = drawing.plt.figure(figsize=(11.5, 7.0))
    rows = figure.add_gridspec(2, 1, height_ratios=[1, 1.45])
    rows.update(left=0.055, right=0.985, top=0.96, bottom=0.07, hspace=0.16)
    draw_shown(rows[0].subgridspec(1, 2 + len(TILES), wspace=0.02).subplots(), curves)
    for axes, what in zip(rows[1].subgridspec(1, 2, wspace=0.14).subplots(), TITLES, strict=True):
        draw_curves(axes, curves, what)
    drawing.save(figure, path)


def draw_shown(tiles: np.ndarray, curves: Curves) -> None:
    """What is left of the target with its features, what the methods make of it, the whole."""
    import drawing

    shown, camera = curves.shown, drawing.Camera(*curves.sample.view)
    poses = {"half of the fox": shown.target}
    poses |= {title: curves.poses[method] for method, title in TILES.items()}
    poses["the whole"] = shown.target
    window = drawing.window_around([camera.project(pose) for pose in poses.values()], 0.02)
    for number, (axes, (title, pose)) in enumerate(zip(tiles, poses.items(), strict=True)):
        seen = camera.project(pose)
        triangles = shown.vertices[shown.triangles] if number == 0 else shown.faces
        drawing.frame(axes, window)
        drawing.draw_solid(axes, seen, triangles, curves.sample.colors, window)
        if number == 0:
            drawing.draw_handles(axes, seen[shown.features])
        drawing.frame(axes, window)
        axes.set_title(title, fontsize=9.5, pad=2)


def draw_curves(axes: Axes, curves: Curves, what: str) -> None:
    import drawing

    blues = drawing.plt.get_cmap("Blues")(np.linspace(0.4, 1.0, len(OURS)))
    styles = {method: {"color": color} for method, color in zip(OURS, blues, strict=True)}
    styles[ON_BONES] = {"color": drawing.SHAPE_COLORS[1], "linestyle": (0, (4, 1.5))}
    styles[PEER] = {"color": drawing.SHAPE_COLORS[0]}
    for method, style in styles.items():
        percent = 100 * curve_of(curves.outcomes[method], what)
        axes.plot(DISTANCES, percent, label=method, linewidth=1.6, **style)
    axes.set(xlim=DISTANCES[[0, -1]], ylim=(0, 100), title=TITLES[what], ylabel=LABELS[what])
    axes.set_xlabel("distance from the truth, in roots of the area")
    axes.grid(color="0.92")
    if what == "registered":
        axes.legend(frameon=False, loc="lower right")
