"""What must be true before a vehicle is armed. The full checklist comes later; these are the conditions that kill."""

from __future__ import annotations

import math

from flightapp.core.errors import FlightError
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.rooms import Rooms

BATTERY_MIN_FRACTION = 0.2
START_DISTANCE_MAX_M = 10.0
START_HEIGHT_MAX_M = 5.0
FRAME_AGE_MAX_S = 0.5
OFFBOARD_LOSS_MAX_S = 1.0
RC_OVERRIDE_OFFBOARD_BIT = 2


class Preflight:
    """Checks of one vehicle on the ground."""

    def __init__(self, rooms: Rooms, loop: ControlLoop) -> None:
        self._rooms = rooms
        self._loop = loop

    def missing(self) -> list[str]:
        """What is not ready yet, in words; empty when the vehicle may be armed."""
        rooms = self._rooms
        status = rooms.autopilot.status()
        missing = list(rooms.autopilot.health().missing())
        if status.armed or status.landed_state != "ON_GROUND":
            missing.append(f"disarmed and on the ground (armed {status.armed}, landed state {status.landed_state})")
        missing += self._place()
        battery = rooms.autopilot.battery()
        if battery is not None and battery.remaining_fraction is not None and battery.remaining_fraction < BATTERY_MIN_FRACTION:
            missing.append(f"battery at {battery.remaining_fraction:.0%}, at least {BATTERY_MIN_FRACTION:.0%} is needed")
        return missing + self._camera()

    async def check_parameters(self) -> None:
        """The PX4 parameters that decide who has control when app or pilot act; FlightError names the first wrong one."""
        autopilot = self._rooms.autopilot
        if await autopilot.parameter_int("COM_OBL_RC_ACT") == 0:
            raise FlightError(
                "preflight: COM_OBL_RC_ACT = 0: when the app falls silent the vehicle would drift and sink; "
                "set 4 (land) or 5 (hold)"
            )
        if not await autopilot.parameter_int("COM_RC_OVERRIDE") & RC_OVERRIDE_OFFBOARD_BIT:
            raise FlightError("preflight: COM_RC_OVERRIDE: the pilot's sticks would do nothing in OFFBOARD; set bit 1 (3)")
        loss_s = await autopilot.parameter_float("COM_OF_LOSS_T")
        if loss_s > OFFBOARD_LOSS_MAX_S:
            raise FlightError(
                f"preflight: COM_OF_LOSS_T = {loss_s:g} s: the failsafe must follow silence within {OFFBOARD_LOSS_MAX_S:g} s"
            )

    def _place(self) -> list[str]:
        rooms = self._rooms
        motion = rooms.autopilot.motion()
        if motion is None:
            return ["position"]
        start = rooms.vehicle.start
        north, east, down = (float(value) for value in motion.state.position_ned_m)
        away_m = math.hypot(north - start.north_m, east - start.east_m)
        above_m = -down - start.ground_height_m
        found = []
        if away_m > START_DISTANCE_MAX_M:
            found.append(f"stands {away_m:.0f} m from its start in the mission (at most {START_DISTANCE_MAX_M:g} m)")
        if abs(above_m) > START_HEIGHT_MAX_M:
            found.append(f"stands {above_m:+.0f} m from its start's height in the mission (at most {START_HEIGHT_MAX_M:g} m)")
        return found

    def _camera(self) -> list[str]:
        perception = self._loop.perception
        if perception is None:
            return []
        if perception.failure is not None:
            return [f"depth frames ({perception.failure})"]
        newest = perception.newest
        if newest is None or self._rooms.clock.now_s() - newest.frame_s > FRAME_AGE_MAX_S:
            return ["depth frames"]
        return []
