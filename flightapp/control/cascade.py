"""PX4's position and velocity loops as a baseline, with its own default gains (PX4 1.16: MPC_XY_P 0.95, _VEL_P_ACC 1.8, ...)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.control.flat import FlatGains
from flightapp.control.law import DECIDES, known, shortened
from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@dataclass(frozen=True, slots=True)
class CascadeGains(FlatGains):
    """PX4's parameters; the vertical axis has its own, as there. In the order of the kernel's array."""

    position_1_s: float = 0.95
    velocity_1_s: float = 1.8
    integral_1_s2: float = 0.4
    damping: float = 0.2
    position_vertical_1_s: float = 1.0
    velocity_vertical_1_s: float = 4.0
    integral_vertical_1_s2: float = 2.0
    acceleration_max_m_s2: float = 6.0
    speed_max_m_s: float = 12.0
    feed_forward: float = 1.0


SUM, LAST_VELOCITY, SLOPE, STARTED, WANTED, ERROR = 0, 3, 6, 9, 10, 13
STATE_SIZE = 16
SLOPE_FILTER_S = 0.03
"""Of the derivative: MPC_VELD_LP, 5 Hz."""


@compiled(DECIDES)
def decide_cascade(
    state: Array,
    gains: Array,
    dt_s: float,
    position: Array,
    velocity: Array,
    reference: Array,
    avoidance: Array,
    command: Array,
) -> None:
    """PX4's two loops: velocity by the error of position, acceleration by the error of velocity; the interface is `DECIDES`."""
    if state[STARTED] == 0.0:
        state[STARTED] = 1.0
        for k in range(3):
            state[LAST_VELOCITY + k] = velocity[k]
    squared = 0.0
    for k in range(3):
        gain = gains[4] if k == 2 else gains[0]
        command[k] = reference[3 + k] + gain * (reference[k] - position[k])
        squared += command[k] ** 2
    scale = min(1.0, gains[8] / math.sqrt(squared)) if squared > 0.0 else 1.0
    blend = 1.0 - math.exp(-dt_s / SLOPE_FILTER_S)
    for k in range(3):
        state[SLOPE + k] += blend * ((velocity[k] - state[LAST_VELOCITY + k]) / dt_s - state[SLOPE + k])
        state[LAST_VELOCITY + k] = velocity[k]
        state[ERROR + k] = scale * command[k] - velocity[k]
        wanted = (gains[5] if k == 2 else gains[1]) * state[ERROR + k] + state[SUM + k] - gains[3] * state[SLOPE + k]
        state[WANTED + k] = known(wanted + gains[9] * reference[6 + k] + avoidance[k])
    if not shortened(state[WANTED:ERROR], command, gains[7]):
        for k in range(3):
            state[SUM + k] += dt_s * (gains[6] if k == 2 else gains[2]) * state[ERROR + k]
