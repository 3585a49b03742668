"""The adapter over the real MAVSDK against the real mock: links that are not there yet, frames, what goes over the wire."""

from __future__ import annotations

import asyncio
import math
import struct
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.profile import Autopilot
from flightapp.core.clock import SystemClock
from flightapp.core.errors import FlightError
from flightapp.core.geodesy import GeodeticPoint, mission_to_geodetic
from flightapp.core.types import Setpoint
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.px4 import Px4
from tests.runtime import mavlink_relay
from tests.sim.mock_process import free_udp_port, mock_autopilot
from tests.vehicle.tcp_gate import TcpGate

DATUM = GeodeticPoint(47.3977, 8.5456, 488.0)
HOVER = Path(__file__).parents[2] / "missions/hover.toml"
TYPE_MASK_OFFSET = 48


def px4(url: str, system_id: int = 1, timeout_s: float = 10.0, *, forward: bool = False) -> Px4:
    config = Autopilot(connection_url=url, connect_timeout_s=timeout_s)
    return Px4(config, system_id, DATUM, SystemClock(), PoseHistory(), acceleration_feed_forward=forward)


async def until(holds: Callable[[], object], timeout_s: float = 10.0) -> None:
    async with asyncio.timeout(timeout_s):
        while not holds():
            await asyncio.sleep(0.01)


def refused(vehicle: Px4) -> tuple[str, float]:
    """The sentence with which connecting fails, and after how long."""
    began_s = time.monotonic()
    try:
        with pytest.raises(FlightError) as failure:
            asyncio.run(vehicle.connect())
    finally:
        vehicle.close()
    return str(failure.value), time.monotonic() - began_s


def test_a_serial_device_that_is_absent_is_tried_again_until_the_time_is_up(caplog: pytest.LogCaptureFixture) -> None:
    said, after_s = refused(px4("serial:///dev/pixhawk-absent:921600", timeout_s=1.2))
    assert after_s >= 1.2
    for part in ("serial:///dev/pixhawk-absent:921600", "cannot be opened", "within 1.2 s", "dialout", "connection_url"):
        assert part in said
    assert caplog.text.count("trying again") == 1


def test_nobody_at_the_tcp_port_is_said() -> None:
    gate = TcpGate()
    try:
        said, _ = refused(px4(f"tcpout://127.0.0.1:{gate.port}", timeout_s=0.5))
    finally:
        gate.start()
        gate.stop()
    assert f"nothing answers at 127.0.0.1:{gate.port} (Connection refused)" in said


def test_a_silent_link_and_a_foreign_vehicle_are_told_apart(tmp_path: Path) -> None:
    said, _ = refused(px4(f"udpin://127.0.0.1:{free_udp_port()}", timeout_s=0.5))
    assert "heard nothing at all" in said
    with mock_autopilot(tmp_path, "--system-id", "9") as mock:
        said, _ = refused(px4(mock.url, system_id=3, timeout_s=2.5))
    assert "no autopilot with system id 3" in said
    assert "heard system ids [9]" in said


def test_a_tcp_link_that_comes_up_late_is_found(tmp_path: Path) -> None:
    gate = TcpGate()
    gate.start()
    vehicle = px4(f"tcpout://127.0.0.1:{gate.port}", timeout_s=15.0)

    async def story() -> None:
        connecting = asyncio.create_task(vehicle.connect())
        await asyncio.sleep(0.6)  # The first attempt of MAVSDK is refused in this time.
        assert not connecting.done()
        gate.open()
        assert "system 1, autopilot 1." in await connecting
        await until(lambda: vehicle.status().connected and vehicle.motion() is not None)

    try:
        with mock_autopilot(tmp_path, port=gate.mock_port):
            asyncio.run(story())
    finally:
        vehicle.close()
        gate.stop()


def test_two_vehicles_with_origins_far_apart_agree_about_a_place_within_five_centimetres(tmp_path: Path) -> None:
    near = mission_to_geodetic(DATUM, np.array([-300.0, 200.0, 20.0]))
    far = mission_to_geodetic(DATUM, np.array([300.0, 1000.0, -80.0]))
    place = ("--mission", str(HOVER), "--vehicle", "e1", "--start", "12,-7,30", "--no-noise")
    told: list[tuple[float, float, float]] = []

    async def position(url: str, system_id: int) -> None:
        vehicle = px4(url, system_id)
        try:
            await vehicle.connect()
            await until(lambda: vehicle.status().connected and vehicle.motion() is not None)
            motion = vehicle.motion()
            assert motion is not None
            north, east, down = motion.state.position_ned_m.tolist()
            told.append((north, east, down))
        finally:
            vehicle.close()

    for system_id, origin in ((7, near), (8, far)):
        text = f"{origin.latitude_deg},{origin.longitude_deg},{origin.altitude_m}"
        arguments = (*place, "--system-id", str(system_id), f"--origin={text}")
        with mock_autopilot(tmp_path, *arguments, name=f"mock{system_id}") as mock:
            asyncio.run(position(mock.url, system_id))
    assert math.dist(told[0], told[1]) < 0.05
    assert math.dist(told[0], (12.0, -7.0, 0.0)) < 0.05


class WireTap(mavlink_relay.MavlinkRelay):
    """Keeps the last setpoint as it crosses the wire."""

    setpoint: bytes = b""

    def _note_to_mock(self, data: bytes) -> None:
        super()._note_to_mock(data)
        for number, _, payload in mavlink_relay._messages(data):
            if number == mavlink_relay.SET_POSITION_TARGET_LOCAL_NED:
                self.setpoint = payload.ljust(53, b"\0")


def on_the_wire(tmp_path: Path, *, forward: bool, setpoint: Setpoint) -> bytes:
    """The MAVLink payload that `setpoint` becomes."""
    port = free_udp_port()
    tap = WireTap(port)
    tap.start()
    vehicle = px4(f"udpin://127.0.0.1:{port}", forward=forward)

    async def story() -> None:
        await vehicle.connect()
        vehicle.send(setpoint)
        await until(lambda: tap.setpoint)

    try:
        with mock_autopilot(tmp_path, port=tap.mock_port):
            asyncio.run(story())
    finally:
        vehicle.close()
        tap.stop()
    return tap.setpoint


@pytest.mark.parametrize("forward", [False, True])
def test_acceleration_goes_out_only_where_the_profile_wants_it_and_never_with_a_position(tmp_path: Path, forward: bool) -> None:
    wish = Setpoint(np.array([1.0, -2.0, 0.5]), 0.25, np.array([0.5, 0.25, -0.125]))
    payload = on_the_wire(tmp_path, forward=forward, setpoint=wish)
    position, velocity = struct.unpack_from("<3f", payload, 4), struct.unpack_from("<3f", payload, 16)
    acceleration, (yaw_rad,) = struct.unpack_from("<3f", payload, 28), struct.unpack_from("<f", payload, 40)
    (mask,) = struct.unpack_from("<H", payload, TYPE_MASK_OFFSET)
    assert velocity == (1.0, -2.0, 0.5)
    assert yaw_rad == pytest.approx(0.25)
    assert not mask & 0b111000, "velocity is said"
    assert not mask & 0x400, "yaw is said"
    ignored = bool(mask & 0b111 == 0b111)
    assert ignored or all(math.isnan(value) for value in position), "PX4 takes no position from it"
    if forward:
        assert not mask & 0b111000000
        assert acceleration == (0.5, 0.25, -0.125)
    else:
        assert mask & 0b111000000 == 0b111000000


@pytest.mark.parametrize("acceleration", [None, (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0)])
def test_what_is_not_finite_never_reaches_mavsdk(acceleration: tuple[float, float, float] | None) -> None:
    from flightapp.vehicle.setpoints import Setpoints

    class Offboard:
        def __getattr__(self, name: str) -> object:
            raise AssertionError(name)

    setpoints = Setpoints(Offboard(), acceleration_feed_forward=True)  # type: ignore[arg-type]
    velocity = np.array([math.nan if acceleration is None else 0.0, 0.0, 0.0])
    forward = None if acceleration is None else np.array(acceleration)
    with pytest.raises(ValueError, match="not finite"):
        setpoints.send(Setpoint(velocity, 0.0, forward))
