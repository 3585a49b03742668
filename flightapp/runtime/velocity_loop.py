"""The controller over the autopilot's velocity loop learns that loop's gains: once, before the first setpoint."""

from __future__ import annotations

from flightapp.runtime.rooms import Rooms
from flightapp.vehicle.velocity_gains import VelocityGains, read_velocity_gains

EVENT = "velocity-loop"


async def learn_velocity_gains(rooms: Rooms) -> None:
    """Nothing to do where the loop is alone. What counts is recorded, so that a replay counts on the same."""
    if rooms.tracker is None:
        return
    assumed = rooms.profile.control.tracking
    otherwise = VelocityGains(assumed.velocity_gain_1_s, assumed.vertical_gain_1_s)
    gains, text = await read_velocity_gains(rooms.autopilot, otherwise)
    rooms.tracker.fly_over(gains)
    rooms.journal.event("info", EVENT, text, planar_1_s=gains.planar_1_s, vertical_1_s=gains.vertical_1_s)
