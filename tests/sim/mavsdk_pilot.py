"""A thin wrapper of the real MAVSDK for tests: connect, keep the newest telemetry, wait for conditions."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

import mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.offboard import Offboard, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, Telemetry

from tests.sim.mock_process import wait_until


class Pilot:
    """One connected vehicle and its newest telemetry."""

    def __init__(self, system: Any) -> None:
        self.system = system
        self.action = Action(system)
        self.offboard = Offboard(system)
        self.telemetry = Telemetry(system)
        self.param = Param(system)
        self.newest: dict[str, Any] = {}
        self.status_texts: list[str] = []
        telemetry = self.telemetry
        for name in (
            "armed",
            "flight_mode",
            "in_air",
            "position_velocity_ned",
            "position",
            "health",
            "battery",
            "attitude_euler",
        ):
            getattr(telemetry, f"subscribe_{name}")(lambda value, _, name=name: self.newest.__setitem__(name, value))
        telemetry.subscribe_status_text(lambda value, _: self.status_texts.append(str(value.text)))

    def wait_ready(self) -> None:
        self.wait(lambda: "position_velocity_ned" in self.newest and self.newest.get("health"), 5.0, "telemetry")
        self.wait(
            lambda: self.newest["health"].is_armable and self.newest["health"].is_home_position_ok, 5.0, "vehicle ready to arm"
        )

    def wait(self, holds: Any, deadline_s: float, what: str) -> Any:
        return wait_until(holds, deadline_s, what)

    def wait_mode(self, mode: FlightMode, deadline_s: float = 5.0) -> None:
        self.wait(lambda: self.newest.get("flight_mode") == mode, deadline_s, f"mode {mode!r}")

    def arm_and_take_off(self, height_m: float) -> None:
        self.wait_ready()
        self.action.arm()
        self.action.takeoff()
        self.wait(lambda: self.height_m > height_m - 0.3, 10.0, f"height {height_m} m")
        self.wait_mode(FlightMode.HOLD)

    def start_offboard(self, north: float = 0.0, east: float = 0.0, down: float = 0.0, yaw_deg: float = 0.0) -> None:
        self.offboard.set_velocity_ned(VelocityNedYaw(north, east, down, yaw_deg))
        self.offboard.start()
        self.wait_mode(FlightMode.OFFBOARD)

    @property
    def height_m(self) -> float:
        """Height over home."""
        position = self.newest.get("position")
        return 0.0 if position is None else float(position.relative_altitude_m)


@contextlib.contextmanager
def connected(url: str, system_id: int = 1, timeout_s: float = 8.0) -> Iterator[Pilot]:
    """A MAVSDK instance on `url`, connected to the vehicle there."""
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.COMPANION_COMPUTER)
    configuration.system_id, configuration.component_id = system_id, 191
    instance = mavsdk.Mavsdk(configuration)
    found: list[Any] = []
    ready = threading.Event()

    def on_found(system: Any) -> None:
        found.append(system)
        ready.set()

    try:
        instance.add_any_connection_with_handle(url)
        instance.first_autopilot_async(timeout_s, on_found)
        assert ready.wait(timeout_s + 1.0), "MAVSDK found no autopilot"
        assert found[0] is not None, "MAVSDK found no autopilot"
        yield Pilot(found[0])
    finally:
        instance.destroy()
