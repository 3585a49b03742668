"""What a person can get wrong at the command line of campaign and tune: one sentence, exit 2, nothing written."""

import sys
from pathlib import Path

import pytest

from flightapp.cli import main
from tests.analysis.campaign.small import small_file


@pytest.mark.parametrize(
    ("command", "arguments", "words"),
    [
        ("campaign", ["--planner", "ac3f"], ["--planner ac3f", "no such planner; known:", "ac2f"]),
        ("campaign", ["--planner", "ac2f", "--planner", "ac2f"], ["named twice"]),
        ("campaign", ["--planner", "ac2f", "--seeds", "9-3"], ["--seeds 9-3", "write 3-9"]),
        ("campaign", [], ["--planner", "campaign.planners in"]),
        ("campaign", ["--set", "campaign.planners=['ac3f']"], ["campaign.planners", "'ac3f' is no planner; known:", "ac2f"]),
        ("campaign", ["--planner", "ac2f", "--set", "campaign.seeds=9-3"], ["campaign.seeds: 9-3", "write 3-9"]),
        ("campaign", ["--planner", "ac2f", "--workers", "0"], ["--workers 0", "at least 1"]),
        ("campaign", ["--planner", "ac2f", "--backend", "slurm"], ["--backend slurm", "local, dask, ray"]),
        ("campaign", ["--planner", "ac2f", "--set", "sensing.rnge_m=3"], ["sensing.rnge_m", "did you mean 'range_m'"]),
        ("campaign", ["--planner", "ac2f", "--set", "sensing.range_m"], ["--set sensing.range_m", "KEY=VALUE"]),
        ("campaign", ["--planner", "ac2f", "--parameters", "no.toml"], ["no.toml: no such file"]),
        ("campaign", ["--planner", "ac2f", "--draw", "all"], ["--draw all"]),
        ("campaign", ["--planner", "ac2f", "--seeds", "0-99", "--record"], ["--record", "at most 32"]),
        ("campaign", ["--planner", "ac2f", "--output", "."], ["--output .", "not empty"]),
        ("tune", ["--seeds", "0-99"], ["tune on seeds from 10000"]),
        ("tune", ["--seeds", "10000-10003", "--batch", "5"], ["4 seeds for a batch of 5"]),
        ("tune", ["--planner", "ac3f"], ["ac3f", "known:"]),
        ("tune", ["--output", "weights.json"], ["--output weights.json", ".toml"]),
        ("tune", ["--resume"], ["no such checkpoint"]),
    ],
)
def test_one_sentence_and_nothing_written(
    command: str,
    arguments: list[str],
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scenario = small_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["flightapp", command, str(scenario), *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    said = capsys.readouterr()
    assert left.value.code == 2
    assert said.out == ""
    assert len(said.err.strip().splitlines()) == 1
    for word in words:
        assert word in said.err
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [scenario]
