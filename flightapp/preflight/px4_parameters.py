"""The PX4 parameters that a pursuit needs, with the reason beside each. The one table for checking and for writing them.

A rule says what values are right and which one to write where it is not. Names and meanings: PX4 parameter reference, v1.12
to v1.16; a parameter that a version does not have is skipped, and where its predecessor counts that stands in the table too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.preflight.facts import Parameters

OFFBOARD_LOSS_MAX_S = 1.0
OFFBOARD_OVERRIDE_BIT = 2
OFFBOARD_EXCEPTION_BIT = 4
LOSS_ACTIONS = {3: "return", 4: "land", 5: "hold"}
FENCE_ACTIONS_THAT_HELP = (2, 3, 5)
"""GF_ACTION: hold, return, land. 0 nothing, 1 warning, 4 terminate."""


@dataclass(frozen=True, slots=True)
class Needed:
    """One rule for this mission and profile. `is_right` judges a value, `write` is the value to set, `wanted` says it."""

    name: str
    is_integer: bool
    is_right: Callable[[float], bool]
    write: float
    wanted: str
    reason: str
    must: bool = True
    """False: a wrong value is a warning only."""
    is_everywhere: bool = True
    """False: not every version since 1.12 has it."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A parameter as it is, and whether it is right; `value` None: this autopilot does not have it."""

    needed: Needed
    value: float | None

    @property
    def is_right(self) -> bool:
        return not self.needed.is_everywhere if self.value is None else self.needed.is_right(self.value)


def needed_parameters(mission: Mission, profile: Profile, vehicle: Vehicle) -> tuple[Needed, ...]:
    """The table. Limits must let the vehicle fly what planner and guards count on."""
    limits = profile.limits
    reach_m, height_m = _farthest(mission, vehicle)
    yaw_rate_deg_s = math.degrees(limits.yaw_rate_max_rad_s)
    transmitter = profile.autopilot.pilot_transmitter
    return (
        Needed("MAV_SYS_ID", True, lambda v: v == vehicle.system_id, vehicle.system_id, f"{vehicle.system_id}", "who is who"),
        _at_most("COM_OF_LOSS_T", OFFBOARD_LOSS_MAX_S, "the failsafe must follow the silence of the app at once"),
        Needed(
            "COM_OBL_RC_ACT",
            True,
            lambda v: int(v) in LOSS_ACTIONS,
            4,
            "3 return, 4 land or 5 hold",
            "with 0 to 2 a vehicle whose app fell silent drifts and sinks",
        ),
        Needed(
            "COM_OBL_ACT",
            True,
            lambda v: int(v) in (0, 1, 2),
            0,
            "0 land, 1 hold or 2 return",
            "before v1.14: the same for a vehicle without a transmitter",
            is_everywhere=False,
        ),
        Needed(
            "COM_RC_OVERRIDE",
            True,
            lambda v: bool(int(v) & OFFBOARD_OVERRIDE_BIT),
            3,
            "bit 1 set (3)",
            "the pilot's sticks must end OFFBOARD",
            must=transmitter,
        ),
        _exception_rule(transmitter),
        Needed("SYS_FAILURE_EN", True, lambda v: v == 0, 0, "0", "no failure may be injected over MAVLink in a real flight"),
        Needed(
            "GF_ACTION",
            True,
            lambda v: int(v) in FENCE_ACTIONS_THAT_HELP,
            3,
            "2 hold, 3 return or 5 land",
            "the autopilot's own fence is the last net when the app is gone",
            must=False,
        ),
        _fence_distance("GF_MAX_HOR_DIST", reach_m),
        _fence_distance("GF_MAX_VER_DIST", height_m),
        _at_least("MPC_XY_VEL_MAX", limits.speed_max_m_s, "m/s", "planner and guards count on the profile's speed"),
        _at_least("MPC_ACC_HOR_MAX", limits.acceleration_max_m_s2, "m/s2", "guards count on it when they brake"),
        _at_least("MPC_ACC_HOR", limits.acceleration_max_m_s2, "m/s2", "velocity setpoints are followed no faster", must=False),
        _at_least("MPC_JERK_MAX", limits.jerk_max_m_s3, "m/s3", "a lower one delays braking", must=False),
        _at_least("MPC_Z_VEL_MAX_UP", limits.climb_rate_max_m_s, "m/s", "the altitude loop counts on it"),
        _at_least("MPC_Z_VEL_MAX_DN", limits.sink_rate_max_m_s, "m/s", "the altitude loop counts on it", must=False),
        _at_least("MPC_YAWRAUTO_MAX", yaw_rate_deg_s, "deg/s", "the camera must look where the vehicle flies", must=False),
        Needed("COM_LOW_BAT_ACT", True, lambda v: int(v) >= 2, 3, "2 land or 3 return, then land", "the app may be gone by then"),
    )


def findings(needed: tuple[Needed, ...], parameters: Parameters) -> list[Finding]:
    """Each rule with the value found; rules whose parameter was not read yet are left out."""
    return [Finding(rule, parameters[rule.name]) for rule in needed if rule.name in parameters]


def _at_least(name: str, bound: float, unit: str, reason: str, must: bool = True) -> Needed:
    value = math.ceil(bound * 10.0) / 10.0
    return Needed(name, False, lambda v: v >= bound - 1e-3, value, f"at least {bound:.3g} {unit}", reason, must)


def _at_most(name: str, bound: float, reason: str) -> Needed:
    return Needed(name, False, lambda v: v <= bound + 1e-6, bound, f"at most {bound:g} s", reason)


def _fence_distance(name: str, distance_m: float) -> Needed:
    """0 switches the check off; anything else must let the mission fly."""
    value = math.ceil(distance_m)
    reason = "the autopilot's fence must contain the whole flight and contingency volume, seen from the start"
    return Needed(name, False, lambda v: v <= 0.0 or v >= distance_m, value, f"0 or at least {value} m", reason)


def _exception_rule(transmitter: bool) -> Needed:
    if transmitter:
        return Needed(
            "COM_RCL_EXCEPT",
            True,
            lambda v: not int(v) & OFFBOARD_EXCEPTION_BIT,
            0,
            "bit 2 clear (0)",
            "a vehicle whose pilot cannot take over must not go on pursuing",
        )
    return Needed(
        "COM_RCL_EXCEPT",
        True,
        lambda v: bool(int(v) & OFFBOARD_EXCEPTION_BIT),
        4,
        "bit 2 set (4)",
        "autopilot.pilot_transmitter = false: without it OFFBOARD ends at once for want of a transmitter",
    )


def _farthest(mission: Mission, vehicle: Vehicle) -> tuple[float, float]:
    """Largest horizontal distance and height above the start that the contingency volume contains, m."""
    volume, start = mission.flight_volume, vehicle.start
    corners, more_m = volume.contingency_vertices_m, 0.0
    if corners is None:
        corners, more_m = volume.vertices_m, volume.contingency_m
    reach_m = max(math.hypot(north - start.north_m, east - start.east_m) for north, east in corners) + more_m
    top_m = max(volume.height_max_m + volume.contingency_height_m, mission.return_height_of(vehicle))
    return reach_m, top_m - start.ground_height_m
