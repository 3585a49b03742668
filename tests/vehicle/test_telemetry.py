"""What the slots make of what MAVSDK calls them with: a restart of the autopilot, and a second one beside it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from flightapp.core.geodesy import GeodeticPoint
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.telemetry import TelemetrySlots

DATUM = GeodeticPoint(47.3977, 8.5456, 488.0)


class Now:
    def __init__(self) -> None:
        self.t_s = 1000.0

    def now_s(self) -> float:
        return self.t_s


class Autopilot:
    """Calls the slots as MAVSDK does."""

    def __init__(self) -> None:
        self.clock = Now()
        self.slots = TelemetrySlots(1, DATUM, self.clock, PoseHistory())

    def attitude(self, boot_s: float) -> None:
        self.clock.t_s += 0.02
        self.slots._on_attitude(SimpleNamespace(timestamp_us=int(boot_s * 1e6), roll_deg=0.0, pitch_deg=0.0, yaw_deg=90.0), None)

    def origin(self, altitude_m: float) -> None:
        fields = {"latitude": round(DATUM.latitude_deg * 1e7), "longitude": round(DATUM.longitude_deg * 1e7)}
        self._message(self.slots._on_origin, fields | {"altitude": round(altitude_m * 1e3)})

    def position(self, boot_s: float, down_m: float) -> None:
        fields = {"x": 0.0, "y": 0.0, "z": down_m, "vx": 0.0, "vy": 0.0, "vz": 0.0, "time_boot_ms": boot_s * 1e3}
        self._message(self.slots._on_local_position, fields)

    def _message(self, take: object, fields: dict[str, float]) -> None:
        take(SimpleNamespace(system_id=1, component_id=1, fields_json=json.dumps(fields)), None)  # type: ignore[operator]


def test_after_a_restart_no_position_is_believed_until_the_new_origin_is_known() -> None:
    autopilot = Autopilot()
    autopilot.attitude(50.0)
    autopilot.origin(488.0)
    autopilot.position(50.0, -3.0)
    assert autopilot.slots.motion is not None
    autopilot.attitude(0.5)
    autopilot.position(0.5, 0.0)
    assert autopilot.slots.motion is None
    assert not autopilot.slots.origin_known
    autopilot.origin(491.0)
    autopilot.position(0.6, 0.0)
    assert autopilot.slots.motion is not None
    assert autopilot.slots.motion.state.position_ned_m[2] == pytest.approx(-3.0, abs=1e-3)


def test_a_twin_that_appears_in_flight_is_told_once() -> None:
    autopilot = Autopilot()
    for number in range(20):
        autopilot.attitude(100.0 + number * 0.02)
    assert autopilot.slots.take_texts() == []
    for number in range(20):
        autopilot.attitude((100.4 if number % 2 else 7.0) + number * 0.02)
    ((_, severity, text),) = autopilot.slots.take_texts()
    assert severity == "CRITICAL"
    assert "two autopilots with this system id" in text
    assert autopilot.slots.twin(autopilot.clock.now_s())
