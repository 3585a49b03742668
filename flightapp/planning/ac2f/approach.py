"""The way to a slot that moves with the evader: around its keep-out, braking relative to it, its velocity fed forward."""

from __future__ import annotations

import math

import numba

from flightapp.core.bearing import wrapped_rad
from flightapp.core.clearance import way_gap_m
from flightapp.core.compiled import compiled
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.records import PARAMETERS_TYPE, Record

PLANAR_TYPE = numba.types.UniTuple(numba.float64, 2)  # type: ignore[no-untyped-call]
_WAY = numba.types.UniTuple(numba.float64, 3)  # type: ignore[no-untyped-call]
HERE_M = 1e-9
Way = tuple[float, float, float]
"""First direction (unit north, east) and length (m)."""


@compiled(_WAY(PARAMETERS_TYPE, *[numba.float64] * 5))
def way_to_slot(parameters: Record, north: float, east: float, bearing_rad: float, radius_m: float, keep_out_m: float) -> Way:
    """The way from (north, east) to the slot at bearing and radius, both from the evader: straight, or around its keep-out."""
    slot_n = radius_m * math.cos(bearing_rad) - north
    slot_e = radius_m * math.sin(bearing_rad) - east
    length = math.hypot(slot_n, slot_e)
    if length < HERE_M:
        return 0.0, 0.0, 0.0
    distance = math.hypot(north, east)
    if keep_out_m <= 0.0 or distance < HERE_M or way_gap_m(north, east, slot_n, slot_e, keep_out_m) >= -1e-6:
        return slot_n / length, slot_e / length, length
    here_rad = math.atan2(east, north)
    turn = wrapped_rad(bearing_rad - here_rad)
    side = math.copysign(1.0, turn)
    arc = keep_out_m * abs(turn)
    if distance <= keep_out_m:
        p = parameters[0]
        outwards = min(1.0, p.slot_leave_gain * (keep_out_m - distance) / keep_out_m + p.slot_leave_share)
        angle = here_rad + side * math.acos(outwards)
        return math.cos(angle), math.sin(angle), arc + abs(radius_m - distance)
    angle = here_rad + math.pi - side * math.asin(keep_out_m / distance)
    return math.cos(angle), math.sin(angle), max(length, distance - keep_out_m + arc)


@compiled("f8(f8,f8,f8,f8,f8)")
def _room_m_s(direction_n: float, direction_e: float, drift_n: float, drift_e: float, speed_max_m_s: float) -> float:
    """The largest s >= 0 with |drift + s direction| <= speed_max."""
    b = direction_n * drift_n + direction_e * drift_e
    c = drift_n * drift_n + drift_e * drift_e - speed_max_m_s * speed_max_m_s
    return max(0.0, -b + math.sqrt(max(0.0, b * b - c)))


@compiled(PLANAR_TYPE(PARAMETERS_TYPE, *[numba.float64] * 7))
def approach_velocity(
    parameters: Record,
    north: float,
    east: float,
    evader_vn: float,
    evader_ve: float,
    bearing_rad: float,
    radius_m: float,
    keep_out_m: float,
) -> tuple[float, float]:
    """Velocity (m/s) that flies from (north, east), seen from the evader, to the slot at bearing and radius and stays there.

    The evader's velocity plus as much along the way as the approach's gain and braking and the speed limit allow.
    """
    p = parameters[0]
    along_n, along_e, length = way_to_slot(parameters, north, east, bearing_rad, radius_m, keep_out_m)
    wanted = min(p.slot_gain_per_s * length, braking_speed_m_s(length, p.slot_braking_m_s2, p.reaction_s))
    speed = min(wanted, _room_m_s(along_n, along_e, evader_vn, evader_ve, p.speed_max_m_s))
    velocity_n = evader_vn + speed * along_n
    velocity_e = evader_ve + speed * along_e
    total = math.hypot(velocity_n, velocity_e)
    scale = min(1.0, p.speed_max_m_s / total) if total > 0.0 else 1.0
    return velocity_n * scale, velocity_e * scale


@compiled(PLANAR_TYPE(PARAMETERS_TYPE, *[numba.float64] * 4))
def contact_velocity(parameters: Record, north: float, east: float, evader_vn: float, evader_ve: float) -> tuple[float, float]:
    """Velocity (m/s) that meets the evader, (north, east) m away, whose own velocity is fed forward.

    As much along the line of sight as the speed limit allows, which far away is the straight course to the intercept; near,
    the closing speed comes down, so that an evader that turns away is followed and not flown past.
    """
    p = parameters[0]
    distance = math.hypot(north, east)
    if distance < HERE_M:
        return evader_vn, evader_ve
    along_n = north / distance
    along_e = east / distance
    braking_m_s2 = p.contact_braking_share * p.acceleration_max_m_s2
    wanted = math.sqrt(p.contact_closing_m_s * p.contact_closing_m_s + 2.0 * braking_m_s2 * distance)
    speed = min(wanted, _room_m_s(along_n, along_e, evader_vn, evader_ve, p.speed_max_m_s))
    velocity_n = evader_vn + speed * along_n
    velocity_e = evader_ve + speed * along_e
    total = math.hypot(velocity_n, velocity_e)
    scale = min(1.0, p.speed_max_m_s / total) if total > 0.0 else 1.0
    return velocity_n * scale, velocity_e * scale
