"""No setpoint beyond the vehicle's limits."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Limits
from flightapp.sim.fault_campaign.trace import Finding, SentSetpoint, Trace, VehicleTrace

PAUSE_S = 0.5
"""After a gap the guards start anew, from the own velocity and yaw."""
PERIOD_MAX_S = 0.2
"""A longer period counts as this long."""
SLACK = 1.02
SLACK_M_S = 0.01
SLACK_RAD = 0.005
MAY_BRAKE_HARDER = frozenset(
    {
        "finite",
        "own-state-age",
        "supervisor",
        "contingency",
        "geofence",
        "altitude",
        "separation",
        "obstacle-stop",
        "target-keep-out",
        "target-age",
        "unseen-sector",
    }
)
"""Guards that act after the acceleration limit, or instead of it: as documented there, what they ask for may exceed it."""


def limits(trace: Trace) -> Iterator[Finding]:
    """Every setpoint that the app sends is finite, at most as fast as the limits in the plane and in height, turns at most at
    the yaw rate limit, and changes at most at the acceleration limit, braking and what the spatial guards force excepted.
    """
    for one in trace.vehicles.values():
        yield from _of(one)


def _of(one: VehicleTrace) -> Iterator[Finding]:
    speed_max = min(one.limits.speed_max_m_s, one.vehicle.speed_max_m_s or math.inf)
    before: SentSetpoint | None = None
    for sent in one.setpoints:
        texts = [*_speeds(sent, speed_max, one.limits)]
        if before is not None and 0.0 < sent.t_s - before.t_s <= PAUSE_S:
            texts += _changes(one, before, sent)
        for text in texts:
            yield Finding(one.name, sent.t_s, text)
        if texts:  # One finding tells; what follows from it would only repeat it.
            return
        before = sent


def _speeds(sent: SentSetpoint, speed_max_m_s: float, limits: Limits) -> Iterator[str]:
    north, east, down = sent.velocity_ned_m_s
    if not math.isfinite(north + east + down + sent.yaw_rad):
        yield "a setpoint that is not finite"
    if math.hypot(north, east) > speed_max_m_s * SLACK:
        yield f"setpoint of {math.hypot(north, east):.2f} m/s, limit {speed_max_m_s:g} m/s"
    if -down > limits.climb_rate_max_m_s * SLACK:
        yield f"climb rate of {-down:.2f} m/s, limit {limits.climb_rate_max_m_s:g} m/s"
    if down > limits.sink_rate_max_m_s * SLACK:
        yield f"sink rate of {down:.2f} m/s, limit {limits.sink_rate_max_m_s:g} m/s"


def _changes(one: VehicleTrace, before: SentSetpoint, sent: SentSetpoint) -> Iterator[str]:
    dt = min(sent.t_s - before.t_s, PERIOD_MAX_S)
    turn = abs(wrap_pi(sent.yaw_rad - before.yaw_rad))
    if turn > one.limits.yaw_rate_max_rad_s * dt * SLACK + SLACK_RAD:
        yield f"turn of {math.degrees(turn / dt):.0f} deg/s, limit {math.degrees(one.limits.yaw_rate_max_rad_s):.0f} deg/s"
    if sent.guards is None or MAY_BRAKE_HARDER.intersection(sent.guards):
        return
    change = gained_m_s(before, sent)
    if change > one.limits.acceleration_max_m_s2 * dt * SLACK + SLACK_M_S:
        yield f"setpoint changes by {change / dt:.1f} m/s2, limit {one.limits.acceleration_max_m_s2:g} m/s2"


def gained_m_s(before: SentSetpoint, sent: SentSetpoint) -> float:
    """Planar change of the velocity, without what braking along the velocity before takes away."""
    old_north, old_east, _ = before.velocity_ned_m_s
    north, east, _ = sent.velocity_ned_m_s
    speed2 = old_north * old_north + old_east * old_east
    share = 1.0 if speed2 < 1e-9 else min(1.0, max(0.0, (old_north * north + old_east * east) / speed2))
    return math.hypot(north - share * old_north, east - share * old_east)
