"""Logs of the autopilots in a run's folder stand on the run's time line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flightapp.analysis import report
from flightapp.analysis.run import load_run
from flightapp.analysis.ulog.beside import LogBeside, findings_beside, logs_beside
from tests.analysis.synthetic_run import T0_S
from tests.analysis.synthetic_run import write_run as record_run
from tests.analysis.ulog.writer import UlogWriter

OFFSET_S, DRIFT = T0_S - 500.0, 50e-6
"""Fleet time when the autopilot's clock was zero, and how much faster fleet time runs."""


def autopilot_log(folder: Path, vehicle: str, name: str) -> Path:
    """What the autopilot of one vehicle would have logged of the run in `folder`, by its own clock, with a GPS fix lost."""
    run = load_run([folder])
    own = next(one for one in run.vehicles if one.name == vehicle).own
    assert own is not None
    log = UlogWriter(boot_s=0.0)
    log_s = (own.t_s - OFFSET_S) / (1.0 + DRIFT)
    log.boot_s = float(log_s[0])
    fast = np.arange(0.0, log_s[-1] - log_s[0], 0.1)
    velocity = own.at(OFFSET_S + (log.boot_s + fast) * (1.0 + DRIFT)).velocity_ned_m_s
    slow = fast[::5]
    log.topic("vehicle_local_position", fast, vx=velocity[:, 0], vy=velocity[:, 1], vz=velocity[:, 2])
    log.topic("vehicle_land_detected", slow, landed=(slow < 3.0) | (slow > 55.0))
    log.topic("vehicle_status", slow, arming_state=2, nav_state=14, nav_state_user_intention=14)
    log.topic("sensor_gps", slow, fix_type=np.where((slow >= 20.0) & (slow < 24.0), 1, 3))
    log.messages = [(20.0, 4, "[failsafe] GPS fix lost")]
    return log.write(folder / name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run")
    record_run(path)
    autopilot_log(path, "p1", "flight-p1.ulg")
    autopilot_log(path, "p2", "log_42.ulg")
    (path / "broken.ulg").write_bytes(b"ULog?")
    return path


def by_name(logs: tuple[LogBeside, ...]) -> dict[str, LogBeside]:
    return {log.path.name: log for log in logs}


def test_a_log_is_given_to_its_vehicle_by_name_or_by_its_motion(folder: Path) -> None:
    logs = by_name(logs_beside(load_run([folder])))
    assert logs["flight-p1.ulg"].vehicle is not None
    assert logs["flight-p1.ulg"].vehicle.name == "p1"
    assert logs["log_42.ulg"].vehicle is not None
    assert logs["log_42.ulg"].vehicle.name == "p2"


def test_findings_and_messages_of_the_autopilot_are_in_fleet_time(folder: Path) -> None:
    run = load_run([folder])
    log = by_name(logs_beside(run))["flight-p1.ulg"]
    lost = next(one for one in findings_beside([log]) if one.title == "GPS fix lost")
    assert log.examined is not None
    true_s = OFFSET_S + (log.examined.log.boot_s + 20.0) * (1.0 + DRIFT)
    assert lost.from_s == pytest.approx(true_s, abs=0.05)
    assert log.alignment is not None
    assert log.alignment.offset_sigma_s < 0.05


def test_the_report_has_both_sides_on_one_time_line_and_says_what_it_could_not_read(folder: Path) -> None:
    summary, page = report([folder])
    html = page.read_text()
    assert "[failsafe] GPS fix lost" in html
    assert "broken.ulg" in html
    logs = {log["file"]: log for log in summary["autopilot_logs"]}
    assert logs["flight-p1.ulg"]["alignment"]["known"] is True
    assert "not a PX4 log" in logs["broken.ulg"]["error"]
