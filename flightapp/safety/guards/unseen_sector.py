"""Motion into directions in which nothing was observed."""

from __future__ import annotations

import math

from flightapp.core.angles import TWO_PI
from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters


class UnseenSectorGuard:
    """Specification: planar speed into an unseen sector [from, to) is at most `unseen_speed_m_s`; the direction is kept."""

    name = "unseen-sector"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._slow_m_s = parameters.unseen_speed_m_s

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        speed = math.hypot(north, east)
        if speed <= self._slow_m_s or len(context.obstacles.unseen) == 0:
            return GuardVerdict(setpoint)
        bearing = math.atan2(east, north)
        for begin, end in context.obstacles.unseen.tolist():
            width = TWO_PI if end - begin >= TWO_PI else (end - begin) % TWO_PI
            if (bearing - begin) % TWO_PI < width:
                scale = self._slow_m_s / speed
                reason = f"nothing was observed towards {math.degrees(bearing) % 360.0:.0f} deg: at most {self._slow_m_s:.1f} m/s"
                return GuardVerdict(with_velocity(setpoint, north * scale, east * scale, down), reason)
        return GuardVerdict(setpoint)
