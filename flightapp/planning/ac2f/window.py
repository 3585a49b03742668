"""The dynamic window: which speeds and turn rates can be reached within one control period."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array, Limits
from flightapp.planning.compiled import compiled


@compiled("void(f8,f8,f8,f8,f8,i8,f8[::1],f8[::1])")
def _fill(
    low_m_s: float,
    high_m_s: float,
    turn_low: float,
    turn_high: float,
    sideways_m_s2: float,
    turn_samples: int,
    speeds: Array,
    turns: Array,
) -> None:
    speed_samples = speeds.shape[0] // turn_samples
    speed_step = (high_m_s - low_m_s) / (speed_samples - 1)
    turn_step = (turn_high - turn_low) / (turn_samples - 1)
    for i in range(speed_samples):
        speed = high_m_s if i == speed_samples - 1 else i * speed_step + low_m_s
        limit = sideways_m_s2 / max(speed, 1e-6)
        for j in range(turn_samples):
            turn = turn_high if j == turn_samples - 1 else j * turn_step + turn_low
            speeds[i * turn_samples + j] = speed
            turns[i * turn_samples + j] = min(max(turn, -limit), limit)


class Window:
    """A grid of speeds and turn rates in buffers of its own: `speeds` (n,) m/s and `turns` (n,) rad/s, speed by speed."""

    def __init__(self, limits: Limits, period_s: float, speed_samples: int, turn_samples: int) -> None:
        self._limits = limits
        self._period_s = period_s
        self._turn_samples = turn_samples
        self.speeds = np.zeros(speed_samples * turn_samples)
        self.turns = np.zeros(speed_samples * turn_samples)

    def sample(self, speed_m_s: float, turn_rad_s: float, speed_limit_m_s: float) -> None:
        """Cover what is reached from `speed_m_s` and `turn_rad_s` within the limits, slowed down to `speed_limit_m_s`."""
        limits = self._limits
        reach = limits.acceleration_max_m_s2 * self._period_s
        low = min(max(0.0, speed_m_s - reach), limits.speed_max_m_s)
        high = min(speed_m_s + reach, limits.speed_max_m_s)
        high = min(high, max(low, speed_limit_m_s))
        turn_reach = limits.yaw_acceleration_max_rad_s2 * self._period_s
        turn_low = max(-limits.yaw_rate_max_rad_s, turn_rad_s - turn_reach)
        turn_high = min(limits.yaw_rate_max_rad_s, turn_rad_s + turn_reach)
        _fill(low, high, turn_low, turn_high, limits.acceleration_max_m_s2, self._turn_samples, self.speeds, self.turns)


@compiled("void(f8,f8,f8,f8,f8,i8,i8,f8[::1],f8[::1])")
def sample_window(
    low_m_s: float,
    high_m_s: float,
    turn_low: float,
    turn_high: float,
    sideways_m_s2: float,
    speed_samples: int,
    turn_samples: int,
    speeds: Array,
    turns: Array,
) -> None:
    """Fill speeds, turns (speed_samples * turn_samples,) with a grid, turn rate by turn rate.

    A turn rate that would need more than `sideways_m_s2` across the course is reduced to what does not.
    """
    speed_step = (high_m_s - low_m_s) / (speed_samples - 1)
    turn_step = (turn_high - turn_low) / (turn_samples - 1)
    for j in range(turn_samples):
        turn = turn_high if j == turn_samples - 1 else j * turn_step + turn_low
        for i in range(speed_samples):
            speed = high_m_s if i == speed_samples - 1 else i * speed_step + low_m_s
            limit = sideways_m_s2 / (speed if speed > 1e-6 else 1e-6)
            clipped = turn if turn > -limit else -limit
            speeds[j * speed_samples + i] = speed
            turns[j * speed_samples + i] = clipped if clipped < limit else limit
