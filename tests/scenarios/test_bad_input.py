"""Bad input: one clear sentence with file, field, value and what would be right; exit 2; nothing written."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from flightapp.cli import main
from tests.scenarios.simulation import DEMO, ROOT, flightapp

PROFILE = ROOT / "profiles/sim.toml"


@pytest.fixture
def refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """What the command says that refuses these arguments, in `tmp_path`, with exit status 2 and before it starts anything."""

    def refused(*arguments: str) -> str:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["flightapp", *arguments])
        monkeypatch.setattr(os, "execv", lambda *_: pytest.fail("it flies"))
        with pytest.raises(SystemExit) as left:
            main()
        assert left.value.code == 2
        return capsys.readouterr().err

    return refused


@pytest.mark.parametrize(
    ("wrong", "right", "words"),
    [
        ("height_m = 5.0\n", "heigth_m = 5.0\n", ["heigth_m", "did you mean 'height_m'"]),
        ("north_m = 55.0", "north_m = 155.0", ["vehicles[2].start", "155.0", "outside the flight volume"]),
        ("system_id = 2", "system_id = 1", ["vehicles[1].system_id = 1", "must differ"]),
        ("time_limit_s = 90.0", "time_limit_s = 0", ["time_limit_s = 0", "greater than 0"]),
        (
            "vertices_m = [[-15.0, -30.0], [65.0, -30.0], [65.0, 30.0], [-15.0, 30.0]]",
            "vertices_m = [[-15.0, -30.0], [65.0, 30.0], [65.0, -30.0], [-15.0, 30.0]]",
            ["flight_volume.vertices_m", "crosses itself"],
        ),
        ('{ name = "ac2f" }', '{ name = "ac3f" }', ["ac3f", "no such planner", "ac2f"]),
        ('name = "boundary-seeking"', 'name = "teleport"', ["teleport", "no such evader policy", "boundary-seeking"]),
        ("radius_m = 3.0", 'radius_m = "3 m"', ["capture.radius_m", "3 m", "number"]),
    ],
)
def test_a_wrong_mission_is_refused_before_anything_starts(
    tmp_path: Path, refusal: Callable[..., str], wrong: str, right: str, words: list[str]
) -> None:
    text = DEMO.read_text()
    assert wrong in text
    mission = tmp_path / "wrong.toml"
    mission.write_text(text.replace(wrong, right, 1))
    said = refusal("sim", str(mission), "--profile", str(PROFILE))
    assert "wrong.toml" in said
    for word in words:
        assert word in said
    assert list(tmp_path.iterdir()) == [mission]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("sim", "nowhere.toml", "--profile", str(PROFILE)), "nowhere.toml: no such file"),
        (("sim", str(DEMO), "--profile", "nowhere.toml"), "nowhere.toml: no such file"),
        (("fly", str(DEMO), "--profile", str(PROFILE), "--vehicle", "p9"), "no vehicle is called 'p9'; known: p1, p2, e1"),
        (("report", "nowhere"), "nowhere"),
        (("recover", "nowhere.mcap"), "nowhere.mcap"),
        (("command", "dance", str(DEMO), "--connect", "udp/127.0.0.1:9"), "hold, resume, rtl, land, abort"),
        (("command", "land", str(DEMO), "--connect", "nonsense"), "nonsense"),
    ],
)
def test_wrong_arguments_are_refused_in_one_sentence(
    tmp_path: Path, refusal: Callable[..., str], arguments: tuple[str, ...], word: str
) -> None:
    assert word in refusal(*arguments)
    assert list(tmp_path.iterdir()) == []


def test_the_process_that_refuses_ends_with_2_and_no_traceback(tmp_path: Path) -> None:
    said = flightapp("sim", "nowhere.toml", "--profile", str(PROFILE), folder=tmp_path)
    assert said.returncode == 2
    assert said.stderr.count("\n") == 1
    assert "nowhere.toml: no such file" in said.stderr
    assert list(tmp_path.iterdir()) == []


def test_fly_without_an_autopilot_says_so_and_is_a_fault(tmp_path: Path) -> None:
    profile = tmp_path / "profile.toml"
    profile.write_text(
        PROFILE.read_text()
        .replace("telemetry_rate_hz = 50.0", "telemetry_rate_hz = 50.0\nconnect_timeout_s = 1.0")
        .replace('source = "shared-memory"', 'source = "none"')
        .replace(":14540", ":20111")
        + '\n[network]\nlisten_endpoints = ["udp/127.0.0.1:20112"]\n'
    )
    said = flightapp("fly", str(DEMO), "--profile", str(profile), "--vehicle", "e1", "--run", "run", folder=tmp_path)
    assert said.returncode == 3
    assert "autopilot link 'udpin://127.0.0.1:20111': heard nothing at all" in said.stderr
    assert "(autopilot.connection_url in the profile)" in said.stderr
