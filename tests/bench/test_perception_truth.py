"""Perception's bench through the command line, and its yardstick against cases that a person can judge."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.bench.perception_truth.bodies import Body
from flightapp.bench.perception_truth.conditions import GOOD, OPEN_FIELDS, Condition
from flightapp.bench.perception_truth.score import is_free, is_unseen, score_trial, stands_for_a_tree
from flightapp.bench.perception_truth.summary import summarise, wilson
from flightapp.bench.perception_truth.trials import Trial, all_trials, stage
from flightapp.cli import main
from flightapp.config.profile import load_profile
from perception.synthetic.flaws import Cover, Flaws
from perception.types import PerceivedObstacles

pytestmark = pytest.mark.timeout(400)
"""Several processes start here; with an empty kernel cache on a busy machine each of them compiles first."""
ROOT = Path(__file__).parents[2]
PROFILE = load_profile(ROOT / "profiles/sim.toml")
HERE = np.zeros(2)
BEHIND = np.array([[math.pi / 2, math.pi], [-math.pi, -math.pi / 2]])


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "flightapp", "bench", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("truth")
    finished = command("perception", "--quick", "--json", "--out", str(folder))
    assert finished.returncode == 0, finished.stderr
    found: dict[str, Any] = json.loads(finished.stdout)
    return found


def test_what_a_pilot_counts_on(quick: dict[str, Any]) -> None:
    rates = {(cell["width_m"], cell["distance_m"]): cell["frame"]["rate"] for cell in quick["detection"]}
    assert rates[0.5, 4.0] > 0.95
    fields = {one["name"]: one["discs"] for one in quick["false_discs"]}
    assert fields["open field, 5 m high"] == 0
    assert fields["open field, 10 m high"] == 0
    assert quick["sectors"]["outside_reported_seen"] == 0.0
    covered = next(one for one in quick["conditions"] if one["name"] == "lens covered, whole")
    assert covered["false_free"]["frames"] == covered["false_free"]["frames_settling"] == 0


def test_every_rate_has_its_interval_and_every_aim_a_verdict(quick: dict[str, Any]) -> None:
    assert quick["quick"] is True
    assert quick["frames"] == sum(trial.frames for trial in all_trials(0, quick=True))
    cells = [*quick["detection"], *quick["branch"]]
    assert len(cells) == 9 + 3
    for rate in [cell[kind] for cell in cells for kind in ("frame", "half_second")]:
        assert 0.0 <= rate["low"] <= rate["rate"] <= rate["high"] <= 1.0
        assert rate["of"] > 0
    assert {aim["verdict"] for aim in quick["aims"]} <= {"met", "missed", "not measured"}
    assert {"machine", "seed", "wall_s", "position", "moving", "false_free"} <= set(quick)


def test_the_picture_is_drawn(quick: dict[str, Any]) -> None:
    image = cv2.imread(quick["picture"])
    assert image is not None
    assert image.shape[0] > 300
    assert image.shape[1] > 800


def refusal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """What the command says that refuses these arguments with exit status 2."""
    monkeypatch.setattr(sys, "argv", ["flightapp", "bench", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    return capsys.readouterr().err


def test_bench_without_a_name_is_the_bench_of_speed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["nowhere.toml"], ["speed", "nowhere.toml"]):
        assert "nowhere.toml" in refusal(monkeypatch, capsys, *arguments)


def test_a_folder_that_cannot_be_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.chdir(ROOT)
    said = refusal(monkeypatch, capsys, "perception", "--quick", "--out", str(tmp_path / "file" / "folder"))
    assert said.count("\n") == 1
    assert "--out" in said


def test_the_full_measurement_covers_what_is_promised() -> None:
    trials = all_trials(0, quick=False)
    places = {(trial.width_m, trial.distance_m) for trial in trials if trial.kind == "width"}
    assert places == {(w, float(d)) for w in (0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0) for d in range(1, 10)}
    assert len({trial.seed for trial in trials}) == len(trials)
    assert {trial.condition.speed_m_s for trial in trials} == {0.0, 2.0, 4.0, 8.0}
    assert {abs(trial.condition.pitch_deg) for trial in trials} >= {0.0, 10.0, 20.0, 30.0}


def test_the_same_trial_gives_the_same_score() -> None:
    trial = Trial("width", GOOD, 0.1, 6.0, 11, frames=4)
    first, second = score_trial(trial, PROFILE), score_trial(trial, PROFILE)
    assert repr(first) == repr(second)


@given(width=st.floats(0.03, 2.0), distance=st.floats(1.0, 9.0), seed=st.integers(0, 10**6))
def test_a_pole_stands_as_far_away_as_its_trial_says(width: float, distance: float, seed: int) -> None:
    body = stage(Trial("width", GOOD, width, distance, seed)).body_at(0.0)
    assert body is not None
    assert float(body.gap_m(HERE[None])[0]) == pytest.approx(distance, abs=0.11)
    points = body.visible_points_m(HERE)
    assert np.abs(body.gap_m(points)).max() < 1e-9
    assert np.hypot(*points.T).min() == pytest.approx(float(body.gap_m(HERE[None])[0]), abs=1e-9)


def test_trees_of_a_tree_line_are_out_of_range() -> None:
    field = next(one for one in OPEN_FIELDS if "tree line" in one.name)
    trees = stage(Trial("open", field, 0.0, 0.0, 3)).scene.cylinders
    assert len(trees) > 20
    assert (np.hypot(trees[:, 0], trees[:, 1]) - trees[:, 2]).min() >= 12.0


def perceived(*discs: tuple[float, float, float], unseen: np.ndarray = BEHIND) -> PerceivedObstacles:
    rows = np.array([(*disc, 0, 0, -math.inf, math.inf) for disc in discs]).reshape(-1, 7)
    return PerceivedObstacles(0.0, rows, np.zeros(len(rows)), np.ones(len(rows)), unseen)


@pytest.mark.parametrize(
    ("reported", "expected"),
    [
        (perceived(), True),
        (perceived((5.3, 0.0, 0.3)), False),
        (perceived((4.0, 0.0, 0.6)), False),
        (perceived((8.0, 0.0, 0.5)), True),
        (perceived((5.3, 1.5, 0.3)), True),
        (perceived((-5.3, 0.0, 0.3)), True),
        (perceived(unseen=np.array([[-0.2, 0.2]])), False),
        (perceived(unseen=np.array([[0.0, 0.2]])), True),
        (perceived((5.2, -0.2, 0.2), unseen=np.array([[0.0, 0.2]])), False),
        (perceived(unseen=np.array([[-math.pi, math.pi]])), False),
    ],
)
def test_a_thing_is_free_unless_a_disc_or_an_unseen_sector_covers_all_of_it(reported: PerceivedObstacles, expected: bool) -> None:
    assert is_free(reported, Body.upright(5.3, 0.0, 0.3), HERE, GOOD) is expected


def test_half_a_wall_left_out_is_a_free_part() -> None:
    wall = Body((5.0, -1.0, 5.0, 1.0), 0.05)
    half = perceived(*[(5.2, east, 0.25) for east in np.arange(-1.0, 0.1, 0.25)])
    whole = perceived(*[(5.2, east, 0.25) for east in np.arange(-1.0, 1.1, 0.25)])
    assert is_free(half, wall, HERE, GOOD) is True
    assert is_free(whole, wall, HERE, GOOD) is False


def test_a_disc_of_a_tree_is_not_a_false_one() -> None:
    trees = np.array([[9.0, 0.0, 0.3, 10.0], [20.0, 5.0, 0.5, 10.0]])
    discs = np.array([[9.1, 0.1, 0.3], [5.0, 0.0, 0.15], [9.0, 3.0, 0.15]])
    assert stands_for_a_tree(discs, trees, HERE, GOOD).tolist() == [True, False, False]
    assert stands_for_a_tree(discs, np.zeros((0, 4)), HERE, GOOD).tolist() == [False] * 3


@given(start=st.floats(-math.pi, math.pi), width=st.floats(0.01, 1.0), part=st.floats(0.01, 0.99))
def test_bearings_in_unseen_sectors(start: float, width: float, part: float) -> None:
    sector = np.array([[start, start + width]])
    inside, outside = start + part * width, start - 0.01 - part
    assert is_unseen(sector, np.array([inside, inside - 2 * math.pi, outside])).tolist() == [True, True, False]


def test_a_camera_that_sees_nothing_finds_nothing() -> None:
    covered = Condition("lens covered", flaws=Flaws(cover=Cover()))
    score = score_trial(Trial("condition", covered, 0.5, 4.0, 5, frames=4), PROFILE)
    assert score.found == [False] * 4
    summary = summarise([score])
    assert summary["conditions"][0]["widths"][0]["frame"]["rate"] == 0.0
    assert all(aim["verdict"] == "not measured" for aim in summary["aims"] if "found" in aim["name"])


@pytest.mark.parametrize(("found", "of", "low", "high"), [(0, 10, 0.0, 0.278), (5, 10, 0.237, 0.763), (10, 10, 0.722, 1.0)])
def test_wilsons_interval(found: int, of: int, low: float, high: float) -> None:
    assert wilson(found, of) == pytest.approx((low, high), abs=1e-3)
