"""A clean flight raises no alarm; every injected fault is found, and by the analyser that is meant for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analysers import ANALYSERS
from flightapp.analysis.ulog.flight import ExaminedLog, examine
from tests.analysis.ulog.flights import DELAY_S, clean_flight
from tests.analysis.ulog.writer import UlogWriter

SHARED = Path(__file__).resolve().parents[4] / "shared" / "data" / "ulog"


def alarms(examined: ExaminedLog) -> list[Finding]:
    return [finding for finding in examined.findings if finding.severity >= Severity.WARNING]


def test_a_clean_flight_raises_no_alarm_and_every_analyser_speaks(tmp_path: Path) -> None:
    examined = examine(clean_flight().write(tmp_path / "clean.ulg"))
    assert alarms(examined) == []
    assert {finding.analyser for finding in examined.findings} == {analyser.name for analyser in ANALYSERS}
    assert not [finding for finding in examined.findings if finding.title == "not known"]
    assert examined.worst == Severity.OK


def _after(name: str, column: str, from_s: float, to_s: float, value: float) -> Callable[[UlogWriter], None]:
    """A fault that lasts: `column` of topic `name` is `value` from one time to another."""

    def inject(log: UlogWriter) -> None:
        times, columns = log.topics[name]
        log.change(name, **{column: np.where((times >= from_s) & (times < to_s), value, columns[column])})

    return inject


def _no_setpoints(log: UlogWriter) -> None:
    times, columns = log.topics["offboard_control_mode"]
    kept = (times < 20.0) | (times > 20.8)
    log.topics["offboard_control_mode"] = (times[kept], {key: value[kept] for key, value in columns.items()})


def _power_lost(log: UlogWriter) -> None:
    log.cut_after(30.0)


def _complaint(log: UlogWriter) -> None:
    log.messages.append((20.0, 2, "[commander] Critical: motor 2 stopped"))


def _vibrates(log: UlogWriter) -> None:
    log.change("vehicle_imu_status", accel_vibration_metric=14.0)


def _lags(log: UlogWriter) -> None:
    times, _ = log.topics["vehicle_local_position"]
    moved = np.column_stack(
        [np.interp(times - 1.2, times, log.topics["vehicle_local_position"][1][c]) for c in ("vx", "vy", "vz")]
    )
    log.change("vehicle_local_position", vx=moved[:, 0], vy=moved[:, 1], vz=moved[:, 2])


FAULTS: list[tuple[str, str, Severity, Callable[[UlogWriter], None]]] = [
    ("battery", "battery brown-out", Severity.FAILURE, _after("battery_status", "voltage_v", 30, 35, 11.2)),
    ("battery", "battery sag", Severity.WARNING, _after("battery_status", "voltage_v", 30, 35, 12.8)),
    ("battery", "flown without a measured battery", Severity.FAILURE, _after("battery_status", "voltage_v", 0, 60, 0.05)),
    ("battery", "charge low", Severity.WARNING, _after("battery_status", "remaining", 40, 60, 0.1)),
    ("battery", "PX4's battery warning", Severity.FAILURE, _after("battery_status", "warning", 40, 60, 2)),
    ("power", "5 V rail low", Severity.FAILURE, _after("system_power", "voltage5v_v", 20, 30, 4.4)),
    ("GPS", "GPS fix lost", Severity.FAILURE, _after("vehicle_gps_position", "fix_type", 20, 25, 1)),
    ("GPS", "GPS interference", Severity.FAILURE, _after("vehicle_gps_position", "jamming_indicator", 5, 60, 120)),
    ("GPS", "jamming reported", Severity.FAILURE, _after("vehicle_gps_position", "jamming_state", 20, 25, 3)),
    ("GPS", "spoofing reported", Severity.WARNING, _after("vehicle_gps_position", "spoofing_state", 20, 25, 2)),
    ("GPS", "GPS inaccurate", Severity.FAILURE, _after("vehicle_gps_position", "eph", 20, 25, 12.0)),
    ("GPS", "few satellites", Severity.WARNING, _after("vehicle_gps_position", "satellites_used", 20, 25, 4)),
    ("estimator", "horizontal position reset", Severity.WARNING, _after("vehicle_local_position", "xy_reset_counter", 20, 61, 3)),
    ("estimator", "horizontal position lost", Severity.FAILURE, _after("vehicle_local_position", "xy_valid", 20, 22, 0)),
    ("estimator", "position rejected", Severity.WARNING, _after("estimator_status", "pos_test_ratio", 20, 25, 2.5)),
    (
        "magnetometer",
        "magnetic field disturbed",
        Severity.WARNING,
        _after("estimator_status_flags", "cs_mag_field_disturbed", 20, 30, 1),
    ),
    ("offboard", "offboard signal lost", Severity.FAILURE, _after("failsafe_flags", "offboard_control_signal_lost", 20, 21, 1)),
    ("offboard", "PX4 left offboard", Severity.FAILURE, _after("vehicle_status", "nav_state", 30, 35, 4)),
    ("offboard", "gap in the setpoints", Severity.WARNING, _no_setpoints),
    ("failsafe", "PX4's failsafe acted", Severity.FAILURE, _after("vehicle_status", "failsafe", 20, 25, 1)),
    ("failsafe", "geofence breached", Severity.FAILURE, _after("failsafe_flags", "geofence_breached", 20, 25, 1)),
    (
        "failsafe",
        "manual control signal lost",
        Severity.WARNING,
        _after("failsafe_flags", "manual_control_signal_lost", 20, 25, 1),
    ),
    ("link", "ground station lost", Severity.WARNING, _after("vehicle_status", "gcs_connection_lost", 20, 25, 1)),
    ("link", "messages lost", Severity.WARNING, _after("telemetry_status", "rx_message_lost_rate", 20, 25, 30)),
    ("messages", "PX4 complained in flight", Severity.FAILURE, _complaint),
    ("vibration", "vibration high", Severity.WARNING, _vibrates),
    ("vibration", "accelerometer clipping", Severity.WARNING, _after("vehicle_imu_status", "accel_clipping[2]", 30, 61, 50)),
    ("tracking", "velocity follows late", Severity.WARNING, _lags),
    ("processor", "processor overloaded", Severity.WARNING, _after("cpuload", "load", 20, 30, 0.97)),
    ("log", "the log ends in the air", Severity.FAILURE, _power_lost),
]


@pytest.mark.parametrize(("analyser", "title", "severity", "inject"), FAULTS, ids=[fault[1] for fault in FAULTS])
def test_an_injected_fault_is_found(
    tmp_path: Path, analyser: str, title: str, severity: Severity, inject: Callable[[UlogWriter], None]
) -> None:
    log = clean_flight()
    inject(log)
    found = [one for one in alarms(examine(log.write(tmp_path / "fault.ulg"))) if one.title == title]
    assert [(one.analyser, one.severity) for one in found] == [(analyser, severity)]
    assert found[0].from_s is None or 0.0 <= found[0].from_s <= 60.0


def test_a_fault_on_the_ground_is_no_alarm(tmp_path: Path) -> None:
    log = clean_flight()
    log.messages.append((58.0, 4, "[health_and_arming_checks] Preflight Fail: height estimate not stable"))
    _after("vehicle_gps_position", "fix_type", 57, 60, 0)(log)
    _after("vehicle_local_position", "xy_reset_counter", 57, 61, 9)(log)
    assert alarms(examine(log.write(tmp_path / "ground.ulg"))) == []


@pytest.mark.parametrize("analyser", [one for one in ANALYSERS if one.needs], ids=lambda one: one.name)
def test_a_missing_topic_is_said_and_never_silent(tmp_path: Path, analyser: object) -> None:
    name, needs = analyser.name, analyser.needs  # type: ignore[attr-defined]
    log = clean_flight()
    for topic in needs[-1].split("|"):
        log.topics.pop(topic, None)
    found = [finding for finding in examine(log.write(tmp_path / "missing.ulg")).findings if finding.analyser == name]
    assert [(one.severity, one.title) for one in found] == [(Severity.NOTE, "not known")]
    assert needs[-1].split("|")[0] in found[0].text


def test_the_delay_of_the_response_is_measured(tmp_path: Path) -> None:
    found = [one for one in examine(clean_flight().write(tmp_path / "clean.ulg")).findings if one.analyser == "tracking"]
    assert float(found[0].evidence["delay_s"]) == pytest.approx(DELAY_S, abs=0.06)
    assert float(found[0].evidence["rms_after_delay_m_s"]) < 0.2 * float(found[0].evidence["rms_horizontal_m_s"])


@pytest.mark.skipif(not SHARED.is_dir(), reason="the real logs are not in this clone")
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "battery_brownout",
            {
                ("battery", "flown without a measured battery"),
                ("power", "flown on USB power"),
                ("magnetometer", "magnetic field disturbed"),
                ("vibration", "vibration high"),
            },
        ),
        (
            "gps_interference",
            {("GPS", "no GPS fix for the whole flight"), ("GPS", "GPS interference"), ("power", "5 V rail low")},
        ),
        ("v6c_short_hop", set()),
    ],
)
def test_what_went_wrong_in_real_flights_is_named_and_nothing_else(name: str, expected: set[tuple[str, str]]) -> None:
    assert {(one.analyser, one.title) for one in alarms(examine(SHARED / f"{name}.ulg"))} == expected
