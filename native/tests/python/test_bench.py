# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's machinery on small generated poses: the form of its rows, the report, and what
evaluate.py says to questions that it cannot answer. Nothing is timed."""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from addon.solver import Form

BENCH = Path(__file__).resolve().parents[2] / "bench"
KEYS = {
    *("name", "metric", "unit", "value", "peer", "peer_value", "ratio", "converged", "sizes"),
}
ENVIRONMENT = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}

sys.path.insert(0, str(BENCH))
from generated import tube  # noqa: E402
from methods import Choice, Tally, Tug  # noqa: E402
from quality import drag_dependence  # noqa: E402
from rigs import Rig  # noqa: E402
from rows_examples import DICTIONARIES, distortions  # noqa: E402
from rows_few_points import choose, scale_errors, told_apart  # noqa: E402
from suite import Row, compare  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Two sets in space and one in the plane; in `others` a single pose, and files that are no
    sets."""
    folder = tmp_path_factory.mktemp("poses")
    for number, poses in enumerate((4, 3)):
        made = tube(200 + 50 * number, poses)
        np.savez(folder / f"tube-{number}.npz", verts=made.shapes, faces=made.triangles)
    y, x = np.mgrid[0:4, 0:12].reshape(2, -1).astype(float)
    corner = (np.arange(3)[:, None] * 12 + np.arange(11)).ravel()
    quads = corner[:, None] + np.array([0, 1, 13, 12])
    shapes = [np.stack([x, y + bend * (x - 5.5) ** 2], axis=1) for bend in (0.0, 0.05, -0.05)]
    np.savez(folder / "flat.npz", verts=np.stack(shapes), quads=quads)
    others = folder / "others"
    others.mkdir()
    np.savez(others / "single.npz", verts=np.stack(shapes[:1]), quads=quads)
    np.savez(others / "bare.npz", verts=np.stack(shapes))
    np.savez(others / "wrong.npz", verts=np.stack(shapes), quads=quads + 7)
    (others / "text.npz").write_text("nothing of the kind")
    return folder


def evaluate(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, BENCH / "evaluate.py", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT)


def test_evaluate_writes_every_measure_of_every_method_and_set(folder, tmp_path):
    out = tmp_path / "new" / "out.json"
    methods = ("steady_lbo", "minimal_skeleton_soft", "fbt", "no_rotations")
    options = ("--data", folder, "--sets", "tube-0,flat", "--methods", ",".join(methods))
    done = evaluate(*options, "--handles", 5, "--examples", 3, "--out", out)
    assert done.returncode == 0, done.stderr
    sets = json.loads(out.read_text())["sets"]
    assert list(sets) == ["tube-0", "flat"]
    for name, dimension in (("tube-0", 3), ("flat", 2)):
        assert sets[name]["sizes"]["poses"] == 3  # of tube-0's four
        assert sets[name]["sizes"]["handles"] == 5
        assert sets[name]["sizes"]["dimension"] == dimension
        assert tuple(sets[name]["methods"]) == methods
        for found in sets[name]["methods"].values():
            assert len(found["leave_one_out"]["poses"]) == 3
            assert found["drag_dependence"] == 0.0


def test_evaluate_takes_all_sets_and_poses_unless_told(folder, tmp_path):
    out = tmp_path / "out.json"
    done = evaluate("--data", folder, "--handles", 4, "--out", out)
    assert done.returncode == 0, done.stderr
    sets = json.loads(out.read_text())["sets"]
    assert {name: found["sizes"]["poses"] for name, found in sets.items()} == {
        "flat": 3,
        "tube-0": 4,
        "tube-1": 3,
    }


@pytest.mark.parametrize(
    ("data", "options", "words"),
    [
        ("nowhere", (), ("there is no folder", "nowhere")),
        ("others", ("--sets", "single"), ("single has 1 pose", "two are the least")),
        ("others", ("--sets", "bare"), ("bare.npz is no set of poses", "quads")),
        ("others", ("--sets", "wrong"), ("wrong.npz", "faces name vertices it lacks")),
        ("others", ("--sets", "text"), ("text.npz is no set of poses",)),
        (".", ("--sets", "flat,lynx"), ("no set lynx", "there are: flat, tube-0, tube-1")),
        (".", ("--sets", ","), ("--sets", "no names")),
        (".", ("--methods", "amrap,magic"), ("no method magic", "there are: steady_handles, ")),
        (".", ("--examples", "1"), ("--examples 1", "two are the least")),
        (".", ("--examples", "many"), ("--examples", "many")),
        (".", ("--handles", "0"), ("--handles 0", "one is the least")),
        (".", ("--handles", "49", "--sets", "flat"), ("flat has 48 vertices", "49 handles")),
    ],
)
def test_evaluate_says_what_is_wrong_and_writes_nothing(folder, tmp_path, data, options, words):
    out = tmp_path / "out.json"
    done = evaluate("--data", folder / data, "--out", out, *options)
    assert done.returncode != 0
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr
    assert done.stdout == ""  # found before any work was done
    assert not out.exists()


def test_history_is_seen_where_there_is_some():
    poses = tube(200, 3)
    handles = poses.spread_handles(6)
    rig = Rig(poses.shapes, poses.triangles, handles)
    choice = Choice({"form": Form.PAPER, "warm_start": 1, "max_rounds": 5})
    warm = functools.partial(Tug, rig, choice)
    assert drag_dependence(poses, handles, functools.partial(Tug, rig), Tally()) == 0.0
    assert drag_dependence(poses, handles, warm, Tally()) > 1e-6


def test_dictionaries_of_more_examples_come_nearer_to_a_pose():
    found = distortions(tube(300, 5), 2)
    assert found.shape == (len(DICTIONARIES), 4)
    assert (found > 0).all()
    assert (found[:, -1] < found[:, 0]).all()
    # With one example two of the dictionaries are the same.
    np.testing.assert_allclose(found[0, 0], found[2, 0])


def test_rows_have_all_keys_and_the_report_shows_them(tmp_path):
    bench, report = tmp_path / "bench.json", tmp_path / "report.md"
    names = "positions_25k,recognition"
    command = ["in_environment.py", "bench.py", "--quick", "--only", names, "--out", str(bench)]
    done = run(*command, TUG_DATA=str(tmp_path / "nowhere"))
    if "not run: " in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.returncode == 0, done.stderr
    rows = json.loads(bench.read_text())
    assert list(dict.fromkeys(row["name"] for row in rows)) == ["machine", *names.split(",")]
    for row in rows:
        check_row(row)
    assert run("report.py", str(bench), "--out", str(report)).returncode == 0
    text = report.read_text()
    for row in rows:
        assert row["metric"] in text
    assert "there is no folder" in text.partition("## Not run")[2]


def test_report_has_exponents_and_every_method_on_every_set(tmp_path):
    bench, report = tmp_path / "bench.json", tmp_path / "report.md"
    rows = [
        Row("growth", f"exponent of {what} in {letter}", "", 1.5, sizes=sizes)
        for letter in "nHSG"
        for what in ("model", "solve", "positions")
        for sizes in [{"values": [1, 2, 4, 8], "seconds": [0.001, 0.002, 0.003, 0.004]}]
    ]
    for name, ranked in (("lion", True), ("hand", False)):
        sizes = {"set": name, "ranked": ranked}
        for method, error in (("paper", 0.01), ("fast", 0.04)):
            values = ("diagonals", 0.02, method, error, True, sizes)
            rows.append(compare("leave_one_out", f"mean error of each method, {name}", *values))
    for method, error in (("steady_lbo", 0.01), ("average_lbo", 0.02), ("fbt", 0.005)):
        sizes = {"set": "lion", "method": method, "unconverged": 3}
        rows.append(Row("dictionaries", f"mean error, {method}, lion", "", error, sizes=sizes))
    for method, worst in (("steady_lbo", 1e-9), ("amrap", 2e-9)):
        sizes = {"set": "lion", "method": method, "examples": 6}
        rows.append(Row("history", "largest vertex difference", "", worst, sizes=sizes))
    bench.write_text(json.dumps([asdict(row) for row in rows]))
    assert run("report.py", str(bench), "--out", str(report)).returncode == 0
    text = report.read_text()
    assert "| `steady_lbo` | **0.0100** | 3 |" in text
    assert "| `average_lbo` | 0.0200 | 3 |" in text
    assert "| `fbt` | 0.0050 | 3 |" in text
    assert "| lion | 6 | 1e-09 |" in text.partition("examples, steady_lbo")[2]
    assert "| lion | 6 | 2e-09 |" in text.partition("examples, amrap")[2]
    assert "| exponent of | in n | in H | in S | in G |" in text
    assert "| solve | 1.5 | 1.5 | 1.5 | 1.5 |" in text
    assert "| solve | G | 1: 1 | 2: 2 | 4: 3 | 8: 4 |" in text
    assert "| *lion* | 0.02 | **0.01** | 0.04 |" in text
    assert "| hand | 0.02 | **0.01** | 0.04 |" in text


def test_report_has_the_curves_of_every_method_at_some_distances(tmp_path):
    bench, report = tmp_path / "bench.json", tmp_path / "report.md"
    distances = np.linspace(0.0, 0.1, 41)
    sizes = {
        "collection": "tubes",
        "method": "8 examples",
        "experiments": 50,
        "start": 0.04,
        "seconds": 0.5,
        "distances": distances.tolist(),
        "completed": np.sqrt(distances).tolist(),
        "registered": (2 * distances).tolist(),
    }
    gain = "completed: least rise from fewer to more examples"
    rows = [
        Row("completion", "mean distance from the truth", "roots of the area", 0.01, sizes=sizes),
        Row("completion", gain, "of the curve's mean", -0.02),
    ]
    bench.write_text(json.dumps([asdict(row) for row in rows]))
    assert run("report.py", str(bench), "--out", str(report)).returncode == 0
    text = report.read_text()
    curves = "10.0 | 14.1 | 22.4 | 2.0 | 4.0 | 10.0"
    assert f"| tubes | 50 | 8 examples | 0.01 | {curves} | 0.04 | 0.5 |" in text
    assert f"| `completion` | {gain} | -0.02 of the curve's mean | >= 0 | **no** |" in text


def test_report_has_the_tables_of_forms_and_dictionaries(tmp_path):
    bench, report = tmp_path / "bench.json", tmp_path / "report.md"
    sizes = {"set": "hand", "form": "closest", "shapes": 7, "groups": 18, "unknowns": 154}
    sizes |= {"published_atoms": 163}
    rows = [
        compare("table_1", f"{what}, closest, hand", "ms", ours, "published", theirs, None, sizes)
        for what, ours, theirs in (("a round", 0.01, 1.2), ("a run", 0.5, 15.5))
    ]
    for dictionary, values in (("skeleton", [4.0, 2.0]), ("one example", [5.0])):
        sizes = {"set": "hand", "dictionary": dictionary, "by_examples": values}
        rows.append(Row("table_2", "distortion", "%", values[-1], sizes=sizes))
    sizes = {"set": "hand", "by_examples": [0.25, 0.5]}
    rows.append(Row("table_2", "a run, 2 examples, hand", "ms", 0.5, sizes=sizes))
    bench.write_text(json.dumps([asdict(row) for row in rows]))
    assert run("report.py", str(bench), "--out", str(report)).returncode == 0
    text = report.read_text()
    assert "| hand | closest | 7 | 18 | 154 | 163 | 0.01 | 1.2 | 120 | 0.5 | 15.5 | 31 |" in text
    assert "| hand | skeleton | 4 | 2 |\n| hand | one example | 5 | - |" in text
    assert "| hand | a run | 0.25 | 0.5 |" in text
    assert "Times and sizes beside peers" not in text


def test_few_points_of_an_example_tell_its_size_and_which_is_which():
    poses = tube(600, 4)
    examples, others = choose(poses, 2)
    assert sorted(examples + others) == [0, 1, 2, 3]
    errors = scale_errors(poses, examples, others, 6, 1.5)
    assert errors.shape == (2, 4)
    assert errors[:, :2].max() < 1e-4 < errors[:, 2:].max()
    assert list(told_apart(poses, [0, 1, 2], [1, 2], Form.STEADY)) == [True, True]


def test_examples_are_chosen_whatever_way_they_face():
    poses = tube(200, 4)
    turned = replace(poses, shapes=poses.shapes.copy())
    turned.shapes[2] = poses.shapes[2][:, [1, 2, 0]] + 3.0
    assert choose(turned, 3) == choose(poses, 3)


def test_report_has_what_few_points_tell(tmp_path):
    bench, report = tmp_path / "bench.json", tmp_path / "report.md"
    metric = "error of an example's alpha, 6 points of hand 0.7 times as large as 7 examples"
    bench.write_text(json.dumps([asdict(Row("scale", metric, "", 2e-15))]))
    assert run("report.py", str(bench), "--out", str(report)).returncode == 0
    assert f"| `scale` | {metric} | 2e-15 | <= 0.01 | yes |" in report.read_text()
    assert f"| `scale` | {metric} | 2e-15 |\n" in report.read_text()


def run(script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess:
    command = [sys.executable, str(BENCH / script), *arguments]
    given = {**ENVIRONMENT, **environment}
    return subprocess.run(command, capture_output=True, text=True, env=given)


def check_row(row: dict) -> None:
    assert set(row) == KEYS
    assert isinstance(row["name"], str) and isinstance(row["sizes"], dict)
    assert row["converged"] in (None, True, False)
    assert (row["peer"] is None) == (row["peer_value"] is None)
    if row["value"] is None:
        assert row["metric"].startswith("not run: ")
    else:
        assert np.isfinite(row["value"])


def test_an_unknown_row_is_refused(tmp_path):
    done = run("in_environment.py", "bench.py", "--only", "magic", "--out", str(tmp_path / "x"))
    if "not run: " in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.returncode != 0
    assert "no row magic; there are: " in done.stderr
