"""Loss of the link to the whole fleet."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters


class TeamLinkGuard:
    """Specification: when no other vehicle of the fleet was heard for `team_link_age_max_s` (or for a time that is not known),
    the planar speed is at most `team_link_speed_m_s`, same direction: everyone else may be anywhere, and does not hear of this
    vehicle either. One teammate that is silent among others is the separation's matter: it widens the distance to keep.
    What the mission makes of a lost link is for the failsafe table.
    """

    name = "team-link"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._age_max_s = parameters.team_link_age_max_s
        self._speed_max_m_s = parameters.team_link_speed_m_s

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        age = context.team_link_age_s
        if age is None or age <= self._age_max_s:
            return GuardVerdict(setpoint)
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        speed = math.hypot(north, east)
        if speed <= self._speed_max_m_s:
            return GuardVerdict(setpoint)
        scale = self._speed_max_m_s / speed
        reason = f"nobody of the fleet was heard for {age:.1f} s: at most {self._speed_max_m_s:.1f} m/s"
        return GuardVerdict(with_velocity(setpoint, north * scale, east * scale, down), reason)
