"""Gains of `aadrc-smc` and how they lie in the flat array that its kernels read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from flightapp.control.flat import FlatGains
from flightapp.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Gains(FlatGains):
    """In the order of the kernels' array; the constants below name the places.

    Vectors are limited by their length, in any frame with equal axes. A zero `actuator_s` feeds the observer with the command
    itself; a zero `observer_rad_s` switches it off: position and velocity are then what was measured, the disturbance nothing.
    """

    proportional_1_s2: float = 4.0
    derivative_1_s: float = 4.0
    switching_m_s2: float = 2.0
    """Of the sliding-mode term."""
    layer_m_s: float = 1.0
    """Half width of its boundary layer."""
    observer_rad_s: float = 6.0
    schedule_1_m2: float = 2.0
    """How much the observer's bandwidth grows with the squared innovation."""
    schedule_max: float = 1.5
    disturbance_max_m_s2: float = 4.0
    actuator_s: float = 0.12
    """Time constant of the modelled actuator."""
    acceleration_max_m_s2: float = 6.0
    vertical_max_m_s2: float = math.inf
    """Of the tracking part."""
    correction_max_m_s: float = 6.0
    """Largest velocity added to the reference's to remove an error of position."""
    braking_share: float = 0.5
    """Of the acceleration; the part that the return to the reference counts on."""
    period_s: float = 0.02
    """Nominal time step."""
    release_s: float = 0.0
    """The disturbance is estimated from so long after a start."""
    observes_velocity: float = 0.0
    """1: the observer is corrected by the measured velocity instead of the position."""
    tilt_max_rad: float = math.radians(35.0)
    """Of a multirotor that flies the command: the planar part is shortened until thrust need not lean further."""

    def __post_init__(self) -> None:
        if not 0.0 < self.tilt_max_rad < 0.5 * math.pi:
            raise InputError(f"tilt_max_rad = {self.tilt_max_rad:g}: must lie between 0 and pi/2")
        _check(self, may_be_zero=("switching_m_s2", "schedule_1_m2", "actuator_s", "observer_rad_s", "release_s", *FLAGS))
        if self.observer_rad_s * self.period_s > 1.0:
            raise InputError(
                f"observer_rad_s = {self.observer_rad_s:g}: at most 1 / period_s = {1.0 / self.period_s:g}, "
                "a faster observer cannot be sampled"
            )


FLAGS = ("observes_velocity",)


def _check(gains: object, may_be_zero: tuple[str, ...]) -> None:
    for field in fields(gains):  # type: ignore[arg-type]
        value = getattr(gains, field.name)
        if math.isnan(value) or value < 0.0 or (value == 0.0 and field.name not in may_be_zero):
            least = "0 or more" if field.name in may_be_zero else "greater than 0"
            raise InputError(f"{field.name} = {value}: must be a number, {least}")


(
    PROPORTIONAL,
    DERIVATIVE,
    SWITCHING,
    LAYER,
    OBSERVER,
    SCHEDULE,
    SCHEDULE_MAX,
    DISTURBANCE_MAX,
    ACTUATOR,
    ACCELERATION_MAX,
    VERTICAL_MAX,
    CORRECTION_MAX,
    BRAKING_SHARE,
    PERIOD,
    RELEASE,
    OBSERVES_VELOCITY,
    TILT_MAX,
) = range(17)

DEFAULT = Gains()
CAUTIOUS = Gains(proportional_1_s2=2.25, derivative_1_s=3.0, switching_m_s2=0.0, observer_rad_s=5.0)
IDEAL = Gains(
    proportional_1_s2=16.0,
    derivative_1_s=8.0,
    switching_m_s2=5.0,
    layer_m_s=0.5,
    observer_rad_s=12.0,
    actuator_s=0.0,
    period_s=0.001,
    tilt_max_rad=1.5,
)
"""For the double integrator without lag, in simulation only."""
PRESETS: Mapping[str, Gains] = MappingProxyType({"default": DEFAULT, "cautious": CAUTIOUS, "ideal": IDEAL})
"""Specification 2.6: `default` over PX4 at 10 to 50 Hz, `cautious` for an unknown vehicle's first flights."""


def gains_for(lag_s: float, delay_s: float, period_s: float, acceleration_max_m_s2: float) -> Gains:
    """Gains for another vehicle by the rules of specification 2.6: its lag, its delay, its control period."""
    total_s = lag_s + delay_s + 0.5 * period_s
    bandwidth = min(2.0, 0.5 / total_s)
    return Gains(
        proportional_1_s2=bandwidth * bandwidth,
        derivative_1_s=2.0 * bandwidth,
        switching_m_s2=0.0 if 2.0 * bandwidth + 2.0 >= 1.4 / total_s else 2.0,
        observer_rad_s=3.0 * bandwidth,
        acceleration_max_m_s2=acceleration_max_m_s2,
        period_s=period_s,
    )
