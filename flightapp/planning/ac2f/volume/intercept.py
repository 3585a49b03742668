"""When a vehicle that is limited in planar speed and, separately, in climb and sink rate can meet a place that moves.

A multirotor is not equally fast in all directions, so a ball of reachable places would promise it the planar speed upwards. It
reaches a cylinder: a disc of radius speed x time, as high as its climb and sink rates allow. The place is met as soon as both
the planar and the vertical condition hold. Each holds in one interval of time, so the answer is closed: the later of the two
beginnings, if neither interval has ended by then.
"""

from __future__ import annotations

import math

Interval = tuple[float, float]
NEVER: Interval = (math.inf, -math.inf)
SAME_SPEED = 1e-9
"""As `ac2f.arrival`, m2/s2."""


def planar_interval_s(offset_m: tuple[float, float], velocity_m_s: tuple[float, float], speed_m_s: float) -> Interval:
    """While |offset + velocity t| <= speed t: from, to (inf: for good)."""
    a = velocity_m_s[0] * velocity_m_s[0] + velocity_m_s[1] * velocity_m_s[1] - speed_m_s * speed_m_s
    b = offset_m[0] * velocity_m_s[0] + offset_m[1] * velocity_m_s[1]
    c = offset_m[0] * offset_m[0] + offset_m[1] * offset_m[1]
    if c == 0.0:
        return (0.0, math.inf) if a <= 0.0 else (0.0, 0.0)
    if abs(a) < SAME_SPEED:
        return (-c / (2.0 * b), math.inf) if b < 0.0 else NEVER
    discriminant = b * b - a * c
    if discriminant < 0.0:
        return NEVER
    root = math.sqrt(discriminant)
    if a < 0.0:
        return (-b - root) / a, math.inf
    return ((-b - root) / a, (-b + root) / a) if b < 0.0 else NEVER


def vertical_interval_s(down_m: float, down_m_s: float, climb_m_s: float, sink_m_s: float) -> Interval:
    """While -climb t <= down + velocity t <= sink t: from, to; `down_m` is how far below the place is now."""
    begin, end = 0.0, math.inf
    for gap_m, closing_m_s in ((down_m, sink_m_s - down_m_s), (-down_m, climb_m_s + down_m_s)):
        if closing_m_s > 0.0:
            begin = max(begin, gap_m / closing_m_s)
        elif gap_m > 0.0:
            return NEVER
        elif closing_m_s < 0.0:
            end = min(end, gap_m / closing_m_s)
    return begin, end


def meeting_time_s(
    offset_ned_m: tuple[float, float, float],
    velocity_ned_m_s: tuple[float, float, float],
    speed_m_s: float,
    climb_m_s: float,
    sink_m_s: float,
) -> float:
    """Earliest time at which the place, now at the offset and moving with the velocity, is met; NaN where it never is.

    At equal heights and without vertical motion this is the planar time of `ac2f.arrival.intercept_time_s`.
    """
    north, east, down = offset_ned_m
    v_north, v_east, v_down = velocity_ned_m_s
    planar = planar_interval_s((north, east), (v_north, v_east), speed_m_s)
    vertical = vertical_interval_s(down, v_down, climb_m_s, sink_m_s)
    begin = max(planar[0], vertical[0])
    return begin if begin <= min(planar[1], vertical[1]) else math.nan
