"""The dynamic window: which speeds and turn rates can be reached within one control period, as a grid."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


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
