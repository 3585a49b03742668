"""Old own state: where the vehicle is, is not known, so it stands."""

from __future__ import annotations

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import standstill
from flightapp.safety.parameters import SafetyParameters


class OwnStateAgeGuard:
    """Specification: own state older than `own_state_age_max_s` (or of unknown age) -> zero velocity, yaw held."""

    name = "own-state-age"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._age_max_s = parameters.own_state_age_max_s

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        if context.own_age_s <= self._age_max_s:
            return GuardVerdict(setpoint)
        reason = f"own state is {context.own_age_s:.2f} s old, limit {self._age_max_s:.2f} s: standing still"
        return GuardVerdict(standstill(context), reason, final=True)
