# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers behind docs/figures say what the papers' texts say of their figures. Measured anew,
with fewer steps or poses than the pictures have; nothing is drawn."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from addon import native

FOLDER = Path(__file__).resolve().parents[3] / "docs" / "figures"
sys.path.append(str(FOLDER))

import amrap_1  # noqa: E402
import amrap_2  # noqa: E402
import amrap_4  # noqa: E402
import amrap_5  # noqa: E402
import amrap_6  # noqa: E402
import amrap_7  # noqa: E402
import amrap_8  # noqa: E402
import baselines  # noqa: E402
import fbt_2  # noqa: E402
import fbt_3  # noqa: E402
import fbt_4  # noqa: E402
import fbt_5  # noqa: E402
import fbt_6  # noqa: E402
import fbt_7  # noqa: E402
import fbt_8  # noqa: E402
import forms  # noqa: E402
import make  # noqa: E402
import one_reference  # noqa: E402
import reconstruction  # noqa: E402
from fitting import Stages  # noqa: E402


@pytest.fixture(autouse=True, scope="module")
def peers():
    try:
        baselines.library()
    except native.LibraryError as error:
        pytest.skip(f"not run: {error}")


def test_squares_get_longer_while_the_height_goes_up_and_down():
    sizes = np.array(list(amrap_1.numbers(amrap_1.measure()).values()))
    assert (np.diff(sizes[:, 0]) > 0).all()
    assert sizes[1, 1] > sizes[0, 1]


@pytest.fixture(scope="module")
def rows():
    return amrap_2.numbers(amrap_2.measure(steps=48))


@pytest.mark.parametrize("row", ["a", "b"])
def test_amrap_blends_the_squares_piecewise_linearly_without_a_jump(rows, row):
    assert rows[row]["from_piecewise_linear"] < 1e-3
    assert rows[row]["weight_jump"] < 1e-3
    assert rows[row]["puffed_at_most"] > 0.99


def test_energy_interpolation_jumps_from_shape_to_shape(rows):
    assert rows["c"]["weight_jump"] == 1.0


def test_a_linear_shape_space_ignores_the_puffed_square(rows):
    # Which of the mixtures without an error to speak of it stops at is a matter of rounding.
    assert rows["d"]["puffed_at_most"] < 0.02
    assert rows["d"]["puffed_mean"] < 1e-3
    assert rows["d"]["objective_at_most"] < 1e-3 * rows["a"]["objective_at_most"]


def test_a_nonlinear_shape_space_jumps_out_of_a_minimum_that_was_not_the_least(rows):
    assert rows["e"]["weight_jump"] > 0.5
    assert rows["e"]["objective_jump"] > 0.5 * rows["e"]["objective_at_most"]


def test_the_snake_jumps_in_a_nonlinear_shape_space_alone():
    snake = amrap_4.numbers(amrap_4.measure(steps=28))
    assert snake["nonlinear"]["movement_jump"] > 0.5
    assert snake["ours"]["movement_jump"] < 0.02 * snake["nonlinear"]["movement_jump"]
    assert min(snake["ours"]["weights_at_most"]) > 0.9


@pytest.fixture(scope="module")
def mesh_ik():
    times = np.array([1 / 3, 11 / 30])  # about where it jumps
    return amrap_5.numbers(amrap_5.measure(times, amrap_5.PUSHES[:1], ["squares"]))


def test_mesh_ik_jumps(mesh_ik):
    assert mesh_ik["mesh_ik"]["movement_jump"] > 0.1
    assert mesh_ik["ours"]["movement_jump"] < 1e-3


def test_mesh_ik_is_caught_in_a_local_minimum(mesh_ik):
    # The drawing itself meets its handles at no cost.
    assert mesh_ik["mesh_ik"]["objective"]["Coiled"] > 1e-3
    assert mesh_ik["mesh_ik"]["distance"]["Coiled"] > 0.05
    assert max(mesh_ik["ours"]["distance"].values()) < 1e-6


def test_mesh_ik_returns_to_the_mean_shape(mesh_ik):
    pushes = mesh_ik["pushes"]["squares"]["0.05"]
    assert pushes["mesh_ik_nearer_to_even"] > 0.2 * pushes["pushes"]
    assert pushes["ours_nearer_to_even"] == 0
    assert pushes["mesh_ik_kept"] < 0.75 < 0.95 < pushes["ours_kept"]


@pytest.fixture(scope="module")
def characters():
    return amrap_6.numbers(amrap_6.measure(steps=20))


def test_the_chameleon_opens_its_mouth_by_amrap_alone(characters):
    mouth = {name: row["mouth"] for name, row in characters["chameleon"].items()}
    assert mouth["ours"] > 0.9
    assert max(mouth["linear"], mouth["nonlinear"]) < 0.25


def test_the_fox_does_not_curl_up_without_the_costs(characters):
    fox = characters["fox"]
    assert fox["linear"]["weight"] < 0.2 < 0.5 < fox["ours"]["weight"]
    assert fox["ours"]["distance"] < 0.7 * fox["linear"]["distance"]


def test_the_fox_jumps_in_a_nonlinear_shape_space_alone(characters):
    fox = characters["fox"]
    assert fox["nonlinear"]["movement_jump"] > 0.1
    assert fox["ours"]["movement_jump"] < 1e-3


def test_a_blend_that_varies_keeps_the_lifted_leg():
    legs = amrap_7.numbers(amrap_7.measure())
    for body in amrap_7.BODIES:
        assert legs["varying"][body] < legs["single"][body]
    assert legs["varying"]["Basis"] < 0.2 * legs["single"]["Basis"]


def test_lambda_moves_from_piecewise_linear_to_piecewise_constant():
    panels = amrap_8.numbers(amrap_8.measure(resolution=40))
    small, default, large = (
        panels[f"no_rotations_{x}"]["one_shape"] for x in ("0.01", "0.5", "10")
    )
    assert small + 0.05 < default < large - 0.05
    assert large > 0.95


def test_the_steady_form_does_not_jump_where_the_papers_does():
    table = forms.numbers(forms.measure(steps_a_frame=1))
    assert table["steady"]["movement_jump"] < 1e-3
    assert table["steady"]["unconverged"] == 0
    assert table["paper"]["movement_jump"] > 0.02
    assert table["paper"]["unconverged"] > 0


def test_more_examples_complete_and_register_the_fox_better_than_one_or_than_der():
    methods = fbt_7.numbers(fbt_7.measure(experiments=3))["methods"]
    all_, one, der = (methods[name] for name in ("8 examples", "1 example", fbt_7.PEER))
    for curve in fbt_7.TITLES:
        assert np.mean(all_[curve]) > np.mean(one[curve]) + 0.02
        assert np.mean(all_[curve]) > np.mean(der[curve]) + 0.02
    assert all_["error"] < 0.8 * min(one["error"], der["error"])


def test_the_dictionary_nears_a_pose_with_every_example():
    for by_count in fbt_2.numbers(fbt_2.measure()).values():
        errors = [by_count[str(count)]["largest"] for count in range(1, 5)]
        assert errors == sorted(errors, reverse=True)
        assert errors[-1] < 0.005 < errors[0]


@pytest.mark.parametrize("figure", [fbt_3, fbt_4])
def test_the_scale_of_few_points_is_found(figure):
    drawn = {figure.DRAWN: figure.tasks()[figure.DRAWN]}
    row = figure.numbers(reconstruction.measure(drawn))[figure.DRAWN]
    assert abs(row["scale"] - 1) < 0.01
    assert row["scale_of_examples_off"] < 1e-5
    assert row["mean"] < 0.04


def test_feet_are_told_apart_and_turn_on_their_way():
    gallop = fbt_5.numbers(fbt_5.measure())
    for row in gallop["correspondence"]["steady"].values():
        assert row["solved"]
        assert row["right_to_best_wrong"] < 1
    assert gallop["half_way"]["rotations"] < 0.8 * gallop["half_way"]["straight"]
    assert gallop["longest_step_to_mean"] < 1.5


def test_icp_turns_the_head_that_features_left_open():
    fox = fbt_6.numbers(fbt_6.measure())
    assert fox["part"] > 0.5
    assert fox["final"]["mean"] < 0.5 * fox["start"]["mean"]
    assert fox["matches_right"] > 0.85


@pytest.mark.parametrize("name", fbt_8.FIGURES)
def test_leaving_a_part_of_the_method_out_makes_it_worse(name):
    figure, _ = fbt_8.FIGURES[name]
    ablations = fbt_8.ablate(figure.tasks()[figure.DRAWN])
    for left_out in ("one_example", "one_reference", "no_scale"):
        assert ablations.mean_error(left_out) > 1.2 * ablations.mean_error("full")


def test_one_reference_is_the_minimal_form_where_that_takes_it():
    task = fbt_4.tasks()[fbt_4.DRAWN]
    stages = Stages(task)
    targets = task.size * task.examples[0][task.features]
    targets[0] += 0.05 * task.unit
    found, alone = stages.solve(targets), one_reference.solve_with_one(stages, targets)
    assert stages.solvers[-1].blend()[0].argmax() == 0
    assert alone.scale == pytest.approx(found.scale, rel=2e-3)
    apart = np.linalg.norm(alone.positions - found.positions, axis=1)
    assert apart.max() < 0.01 * task.unit


@pytest.mark.parametrize("name", make.FIGURES)
def test_every_figure_is_shown_with_its_numbers(name):
    page = (FOLDER.parent / "figures.md").read_text()
    assert f"figures/{name}.png" in page
    assert (FOLDER / f"{name}.png").stat().st_size < 300_000
    assert (FOLDER / f"{name}.json").exists()
