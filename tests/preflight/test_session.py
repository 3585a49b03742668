"""`flightapp preflight` against the real mock over real MAVLink: found, written, waived, and the exit status."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.sim.fleet_files import ReservedPorts, prepare
from tests.sim.mock_process import MockProcess, free_udp_port, mock_autopilot

ROOT = Path(__file__).parents[2]
HOVER = ROOT / "missions/hover.toml"
WRONG = {"COM_OBL_RC_ACT": 0, "COM_RC_OVERRIDE": 3, "COM_LOW_BAT_ACT": 3, "SYS_FAILURE_EN": 1}
"""What the mock is given; the first and the last one must not fly."""


@dataclass
class OnTheGround:
    """A vehicle that stands at its start, and the profile that leads to it."""

    mock: MockProcess
    profile: Path

    def preflight(self, *options: str) -> tuple[int, dict[str, Any]]:
        """Exit status and what was printed. In this process: what starts one is the same for the last test below."""
        command = ["preflight", str(HOVER), "--profile", str(self.profile), "--vehicle", "e1", "--json", *options]
        said = CliRunner().invoke(app, command)
        assert said.stdout, said.output
        return said.exit_code, json.loads(said.stdout)


@pytest.fixture(scope="module")
def vehicle(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OnTheGround]:
    folder = tmp_path_factory.mktemp("ground")
    ports = ReservedPorts(2)
    (files,) = prepare(load_mission(HOVER), load_profile(ROOT / "profiles/sim.toml"), folder, folder, ports.numbers)
    place = ("--mission", str(HOVER), "--vehicle", "e1")
    with mock_autopilot(folder, *place, parameters=WRONG, port=files.mavlink_port) as mock:
        yield OnTheGround(mock, files.profile)
    ports.release()


def test_what_is_wrong_fails_by_name_may_be_waived_and_is_put_right_when_asked(vehicle: OnTheGround) -> None:
    """One vehicle, three looks: as it is, with one failure waived and the parameters written, and again."""
    status, first = vehicle.preflight()
    levels = {result["check"]: result["level"] for result in first["results"]}
    assert status == 3
    assert not first["ready"]
    assert sorted(name for name, level in levels.items() if level == "failed") == ["COM_OBL_RC_ACT", "SYS_FAILURE_EN"]
    for check in ("autopilot", "system-id", "health", "transmitter", "start", "home", "battery", "fence", "disk"):
        assert levels[check] == "passed", (check, first["results"])
    assert all(result["found"] and result["reason"] for result in first["results"])
    assert all(result["remedy"] for result in first["results"] if result["level"] in ("failed", "warning"))
    assert first["parameters"] == [], "nothing is written unless it is asked for"

    status, waived = vehicle.preflight("--waive", "COM_OBL_RC_ACT", "--waive", "SYS_FAILURE_EN")
    assert (status, waived["ready"]) == (0, True)
    assert {result["check"] for result in waived["results"] if result["level"] == "waived"} == {
        "COM_OBL_RC_ACT",
        "SYS_FAILURE_EN",
    }

    status, written = vehicle.preflight("--write-parameters", "--yes")
    assert (status, written["ready"]) == (0, True)
    by_name = {one["name"]: one for one in written["parameters"]}
    assert (by_name["COM_OBL_RC_ACT"]["old"], by_name["COM_OBL_RC_ACT"]["read_back"]) == (0, 4)
    assert (by_name["SYS_FAILURE_EN"]["old"], by_name["SYS_FAILURE_EN"]["read_back"]) == (1, 0)
    assert by_name["MPC_JERK_MAX"]["read_back"] == by_name["MPC_JERK_MAX"]["wanted"] == 40.0
    assert "COM_RC_OVERRIDE" not in by_name, "what is right is left alone"


def test_an_autopilot_that_is_not_there_is_one_sentence_with_link_and_remedy(vehicle: OnTheGround, tmp_path: Path) -> None:
    url = f"udpin://127.0.0.1:{free_udp_port()}"
    tables = tomllib.loads(vehicle.profile.read_text())
    tables["autopilot"] |= {"connection_url": url, "connect_timeout_s": 0.5}
    silent = tmp_path / "profile.toml"
    silent.write_text(tomli_w.dumps(tables))
    command = [sys.executable, "-m", "flightapp", "preflight", str(HOVER), "--profile", str(silent), "--vehicle", "e1"]
    said = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=60, check=False)
    assert said.returncode == 3
    assert said.stderr.splitlines()[-1].startswith(f"autopilot link '{url}': heard nothing at all within 0.5 s;")
