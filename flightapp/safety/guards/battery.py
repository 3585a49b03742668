"""Battery and the way home."""

from __future__ import annotations

import math
from collections import deque

from flightapp.safety.api import Action, Demand, SafetyContext
from flightapp.safety.duration import Duration
from flightapp.safety.parameters import SafetyParameters

CONFIRMED_S = 3.0
"""A dip of the voltage under load asks for nothing."""
SAMPLE_PERIOD_S = 1.0
WINDOW_SAMPLES = 61
MEASURED_AFTER_S = 30.0
DRAIN_MAX_FACTOR = 4.0
"""A drain beyond this many times the configured one is a jump of the gauge and not a drain."""


class BatteryGuard:
    """Specification. The way home takes distance / `return_speed_m_s`, the climb to the return height at the climb rate limit,
    and the descent from there to the ground at home at `landing_speed_m_s`. It costs that time times the drain: that of a full
    battery over `endurance_s`, or what was measured over the last 30 to 60 s of flight where that is faster.

    - Left less than the way home and `battery_reserve_fraction`, for 3 s: RETURN is asked for.
    - Left less than `battery_critical_fraction`, or than the way home alone, for 3 s: LAND is asked for.

    A demand is never taken back, only raised: a battery that recovers without load has not been charged. A battery that the
    autopilot does not report asks for nothing. Home is a place of the mission frame, heights are metres above the datum.
    """

    name = "battery"

    def __init__(
        self, home_m: tuple[float, float], ground_height_m: float, return_height_m: float, parameters: SafetyParameters
    ) -> None:
        self._home_m, self._ground_m, self._return_m = home_m, ground_height_m, return_height_m
        self._parameters = parameters
        self._samples: deque[tuple[float, float]] = deque(maxlen=WINDOW_SAMPLES)
        self._short, self._critical = Duration(), Duration()
        self._asked: Demand | None = None

    def demand(self, context: SafetyContext) -> Demand | None:
        left = context.battery_fraction
        if left is None:
            return self._asked
        self._note(context.t_s, left)
        needed = self.way_home_s(context) * self._drain_1_s()
        if not math.isfinite(needed):
            return self._asked
        parameters = self._parameters
        short = left < needed + parameters.battery_reserve_fraction
        critical = left < max(needed, parameters.battery_critical_fraction)
        text = f"{100 * left:.0f} % left, the way home takes {100 * needed:.0f} %"
        if self._short.of(short, context.dt_s) >= CONFIRMED_S:
            self._raise(Action.RETURN, f"{text} and {100 * parameters.battery_reserve_fraction:.0f} % must remain")
        if self._critical.of(critical, context.dt_s) >= CONFIRMED_S:
            self._raise(Action.LAND, f"{text}, below {100 * parameters.battery_critical_fraction:.0f} % it lands")
        return self._asked

    def way_home_s(self, context: SafetyContext) -> float:
        """How long the return takes from here, s."""
        north, east, down = map(float, context.own.position_ned_m)
        highest = max(-down, self._return_m)
        distance = math.hypot(north - self._home_m[0], east - self._home_m[1])
        climb_s = (highest + down) / context.limits.climb_rate_max_m_s
        descent_s = max(0.0, highest - self._ground_m) / self._parameters.landing_speed_m_s
        return distance / self._parameters.return_speed_m_s + climb_s + descent_s

    def _raise(self, action: Action, reason: str) -> None:
        if self._asked is None or action > self._asked.action:
            self._asked = Demand(action, self.name, reason)

    def _note(self, t_s: float, left: float) -> None:
        if self._samples and t_s < self._samples[-1][0]:
            self._samples.clear()
        if not self._samples or t_s - self._samples[-1][0] >= SAMPLE_PERIOD_S:
            self._samples.append((t_s, left))

    def _drain_1_s(self) -> float:
        configured = 1.0 / self._parameters.endurance_s
        if len(self._samples) < 2:
            return configured
        (began_s, before), (t_s, left) = self._samples[0], self._samples[-1]
        if not t_s - began_s >= MEASURED_AFTER_S:
            return configured
        return min(max(configured, (before - left) / (t_s - began_s)), DRAIN_MAX_FACTOR * configured)
