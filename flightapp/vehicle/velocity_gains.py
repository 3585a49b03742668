"""The gains of PX4's own velocity loop, as the vehicle has them: a controller over that loop must know what it does by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.core.errors import FlightError
from flightapp.vehicle.autopilot import Autopilot

PLANAR, VERTICAL = "MPC_XY_VEL_P_ACC", "MPC_Z_VEL_P_ACC"
PLAUSIBLE_MAX_1_S = 30.0
"""PX4 allows 5 in the plane and 15 in height."""


@dataclass(frozen=True, slots=True)
class VelocityGains:
    """Acceleration per velocity error, 1/s."""

    planar_1_s: float
    vertical_1_s: float


async def read_velocity_gains(autopilot: Autopilot, otherwise: VelocityGains) -> tuple[VelocityGains, str]:
    """What the autopilot answers, and a sentence about it; `otherwise` counts for what it does not answer usefully.

    On the ground only, like every reading of parameters.
    """
    counted: list[float] = []
    told: list[str] = []
    for name, assumed in ((PLANAR, otherwise.planar_1_s), (VERTICAL, otherwise.vertical_1_s)):
        try:
            value = await autopilot.parameter(name, is_integer=False)
        except FlightError as error:
            value, why = None, str(error)
        else:
            why = "not answered" if value is None else f"answered {value:g}"
        usable = is_usable(value)
        counted.append(value if usable and value is not None else assumed)
        told.append(f"{name} {counted[-1]:g}" if usable else f"{name} {assumed:g} as in the profile ({why})")
    return VelocityGains(counted[0], counted[1]), "velocity loop: " + ", ".join(told)


def is_usable(value: float | None) -> bool:
    """Whether `value` can be a gain of a velocity loop."""
    return value is not None and math.isfinite(value) and 0.0 < value <= PLAUSIBLE_MAX_1_S
