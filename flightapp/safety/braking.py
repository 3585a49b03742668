"""How fast a vehicle may close on something that it must not reach."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.core.types import Limits
from flightapp.safety.parameters import SafetyParameters


@dataclass(frozen=True, slots=True)
class Braking:
    """Deceleration that can be counted on (m/s2) and the time (s) that passes before a setpoint takes effect.

    The allowed closing speed at distance d is d / lag near the border (an exponential stop that a vehicle with this lag can
    follow without overshoot) and sqrt(2 a (d - a lag^2 / 2)) farther away; both meet with equal slope at d = a lag^2. Callers
    subtract from d the way covered during the lag (`reach_m`), which is what makes the stop free of oscillation.
    """

    deceleration_m_s2: float
    lag_s: float

    def speed_m_s(self, distance_m: float) -> float:
        """Largest closing speed that can be braked within `distance_m`; zero where nothing is left."""
        if distance_m <= 0.0:
            return 0.0
        knee = self.deceleration_m_s2 * self.lag_s * self.lag_s
        if distance_m <= knee:
            return distance_m / self.lag_s
        return math.sqrt(2.0 * self.deceleration_m_s2 * (distance_m - 0.5 * knee))

    def reach_m(self, closing_m_s: float, age_s: float = 0.0) -> float:
        """Way covered at `closing_m_s` before a setpoint takes effect, with a state that is `age_s` old; zero when opening."""
        return max(0.0, closing_m_s) * (self.lag_s + age_s)

    def kept_m_s(self, inside_m: float, closing_m_s: float, margin_m: float, push_back_m_s: float, age_s: float = 0.0) -> float:
        """Largest speed towards a border that is `inside_m` ahead (negative: behind, the vehicle is outside).

        Braking ends `margin_m` before the border. Nearer than half of that, and outside, the result is negative: a push
        back of at most `push_back_m_s`, damped by the motion inwards. It never grows as `inside_m` falls.
        """
        left = inside_m - margin_m - self.reach_m(closing_m_s, age_s)
        if left > 0.0:
            return self.speed_m_s(left)
        short = 0.5 * margin_m - inside_m + self.lag_s * min(0.0, closing_m_s)
        return -min(push_back_m_s, max(0.0, short) / (2.0 * self.lag_s))

    def stop_m(self, speed_m_s: float) -> float:
        """Distance beyond which a closing speed of `speed_m_s` is not limited at all, the way during the lag included."""
        tail = 0.5 * self.deceleration_m_s2 * self.lag_s * self.lag_s
        return speed_m_s * self.lag_s + tail + speed_m_s * speed_m_s / (2.0 * self.deceleration_m_s2)


def horizontal_braking(limits: Limits, parameters: SafetyParameters) -> Braking:
    """Braking in the plane."""
    return Braking(parameters.braking_fraction * limits.acceleration_max_m_s2, parameters.response_lag_s)


def vertical_braking(parameters: SafetyParameters) -> Braking:
    """Braking of climb and descent."""
    return Braking(parameters.braking_fraction * parameters.vertical_acceleration_m_s2, parameters.response_lag_s)
