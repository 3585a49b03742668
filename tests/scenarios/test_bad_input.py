"""Bad input: one clear sentence with file, field, value and what would be right; exit 2; nothing written."""

from pathlib import Path

import pytest

from tests.scenarios.simulation import DEMO, ROOT, flightapp

PROFILE = ROOT / "profiles/sim.toml"


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
def test_a_wrong_mission_is_refused_before_anything_starts(tmp_path: Path, wrong: str, right: str, words: list[str]) -> None:
    text = DEMO.read_text()
    assert wrong in text
    mission = tmp_path / "wrong.toml"
    mission.write_text(text.replace(wrong, right, 1))
    said = flightapp("sim", str(mission), "--profile", str(PROFILE), folder=tmp_path)
    assert said.returncode == 2
    assert "Traceback" not in said.stderr
    assert "wrong.toml" in said.stderr
    for word in words:
        assert word in said.stderr, said.stderr
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
def test_wrong_arguments_are_refused_in_one_sentence(tmp_path: Path, arguments: tuple[str, ...], word: str) -> None:
    said = flightapp(*arguments, folder=tmp_path)
    assert said.returncode == 2
    assert word in said.stderr
    assert "Traceback" not in said.stderr
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
