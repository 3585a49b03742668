"""A pursuit over a slow and lossy network still captures, the same way every time it is asked; questions are checked first."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.core.errors import InputError
from flightapp.sim.network_campaign.conditions import Condition, parse_grid, side_of
from flightapp.sim.network_campaign.flight import Flown
from flightapp.sim.network_campaign.table import rows_of

ROOT = Path(__file__).parents[3]
DEMO, SIM = ROOT / "missions/demo_two_pursuers.toml", ROOT / "profiles/sim.toml"


def call(*arguments: str) -> tuple[int, str]:
    """Exit status and all output; an InputError is raised, as `flightapp.cli.main` gets it."""
    result = CliRunner().invoke(app, ["campaign", "network", "--mission", str(DEMO), "--profile", str(SIM), *arguments])
    if isinstance(result.exception, InputError):
        raise result.exception
    return result.exit_code, result.output


def test_a_pursuit_over_a_slow_and_lossy_network_captures(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    arguments = ("--seeds", "0", "--delays-ms", "80", "--losses", "20", "--partitions", "none", "--workers", "1")
    status, output = call(*arguments, "--out", str(folder), "--json")
    assert status == 0, output
    (row,) = csv.DictReader((folder / "table.csv").read_text().splitlines())
    assert (row["captured"], row["missions"], row["violations"]) == ("1", "1", "0")
    assert float(row["age_p50_ms"]) > 80.0
    assert float(row["separation_min_m"]) > 1.5
    assert (folder / "network.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((folder / "missions.json").read_text())["flown"][0]["condition"]["loss_percent"] == 20.0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--delays-ms", "fast"), "--delays-ms fast"),
        (("--losses", "100"), "--losses 100"),
        (("--partitions", "thirds"), "--partitions thirds"),
        (("--seeds", "x"), "--seeds x"),
    ],
)
def test_a_bad_question_is_one_sentence_and_leaves_nothing(arguments: tuple[str, str], told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told):
        call(*arguments, "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_mission_that_is_no_pursuit_is_refused(tmp_path: Path) -> None:
    hover = ROOT / "missions/hover.toml"
    with pytest.raises(InputError, match="measures pursuits"):
        call("--mission", str(hover), "--out", str(tmp_path / "out"))


def test_the_grid_has_every_pair_once_and_partitions_at_its_ends() -> None:
    grid = parse_grid("200,5", "0,30", "none,one")
    assert len(set(grid)) == len(grid) == 6
    assert {(one.delay_ms, one.loss_percent) for one in grid if one.partition == "one"} == {(5.0, 0.0), (200.0, 30.0)}
    with pytest.raises(InputError, match="--partitions"):
        parse_grid("5", "0", "")


def test_sides_of_a_partition() -> None:
    assert side_of("none", ["p1", "p2", "p3"], ["e1"]) == ()
    assert side_of("one", ["p1", "p2", "p3"], ["e1"]) == ("p3",)
    assert side_of("halves", ["p1", "p2", "p3", "p4"], ["e1"]) == ("p1", "p2")
    assert side_of("halves", ["p1"], ["e1"]) == ("e1",)


def test_a_row_counts_what_happened() -> None:
    condition = Condition("none", 5.0, 0.0)
    captured = Flown(condition, 0, "captured", 10.0, 3.0, 60.0, 90.0, 0, split_felt=False, violations=())
    escaped = Flown(condition, 1, "escaped", None, 2.0, 70.0, 95.0, 2, split_felt=False, violations=("contact: p1 touches p2",))
    (row,) = rows_of([escaped, captured])
    assert (row.captured, row.missions, row.leader_changes, row.violations) == (1, 2, 2, 1)
    assert (row.capture_time_s, row.separation_min_m) == (10.0, 2.0)
    assert row.captured_low < 0.5 < row.captured_high
