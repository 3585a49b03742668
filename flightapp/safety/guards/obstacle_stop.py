"""Last-resort braking before known obstacles."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.clearance import disc_clearances_m
from flightapp.core.types import Array, Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.heights import blocking
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound
from perception.kernel_cache import njit

TANGENT_SHARES = (0.0, -0.33, 0.33, -0.66, 0.66, -1.0, 1.0)
ACTUAL_WEIGHT = 20.0
"""How much more the actual velocity counts than the wanted one in the choice of a line: it is the one that must be braked."""
LAGGED_WEIGHT = 0.5
"""Where nothing can be braked in time any more, the line is chosen without the lag: that brakes more than it swerves."""
VEHICLE_NEARBY_M = 0.5
MOVING_M_S = 0.2
"""What is said to be slower stands, as far as can be known."""


class ObstacleStopGuard:
    """Specification: for each known disc there is a straight line between the vehicle and the disc (grown by the body radius
    and `obstacle_clearance_min_m`) such that the speed towards that line can be braked before it. A vehicle that is already
    faster than that by some speed is asked for as much less, down to a retreat at the speed at which it closes in: a velocity
    loop answers to its error, so that a setpoint at the bound, or at zero, would brake it ever more gently towards the
    obstacle. It ends as the vehicle slows down; standing always passes, and zero does wherever it stops the vehicle in time.

    Among lines that touch the grown disc the one is taken that the wanted and the actual velocity break least, the actual one
    counting more: it is what must be braked. So a vehicle that passes beside a disc is left alone, however close and fast, and
    one that flies at it is braked, sliding past where it is free: the guard acts later than any planner that keeps a margin.
    A disc that moves by itself is grown by `moving_obstacle_margin_m` more: whoever walks may turn. Discs that come closer are
    met with their closing speed taken off, down to a standstill, and never fled from; discs that move away are given credit only
    where a teammate or the evader is known to be.

    Discs of known height that the vehicle passes above or below (see `heights`) do not count; those of unknown height do at any.
    """

    name = "obstacle-stop"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._parameters = parameters

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:
        discs = context.obstacles.discs
        in_the_way = blocking(context, self._parameters)
        if not in_the_way.all():
            discs = discs[in_the_way]
        if len(discs) == 0:
            return []
        limits, parameters = context.limits, self._parameters
        braking = horizontal_braking(limits, parameters)
        own_north, own_east, _ = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        clearances = disc_clearances_m(context.own.position_ned_m[:2], discs, limits.body_radius_m)
        fastest = max(speed_m_s, math.hypot(v_north, v_east))
        rows = _tangent_bounds(
            np.ascontiguousarray(discs, dtype=np.float64),
            np.ascontiguousarray(clearances, dtype=np.float64),
            _known_vehicles(context),
            np.array([own_north, own_east, v_north, v_east, wish[0], wish[1]]),
            np.array(
                [
                    limits.body_radius_m + parameters.obstacle_clearance_min_m,
                    min(max(0.0, context.obstacles_age_s), parameters.obstacles_age_max_s),
                    context.own_age_s,
                    braking.deceleration_m_s2,
                    braking.lag_s,
                    braking.stop_m(fastest) + fastest * context.own_age_s,
                    parameters.moving_obstacle_margin_m,
                ]
            ),
        )
        return [
            VelocityBound(north, east, bound, self.name, "obstacle", clearance, _braking_text(bound, clearance))
            for north, east, bound, clearance in rows.tolist()
            if bound < speed_m_s
        ]


def _braking_text(bound_m_s: float, clearance_m: float) -> str:
    """What is said of a bound that is no retreat: it ends when the vehicle has slowed down."""
    return f"obstacle {clearance_m:.1f} m away: too fast towards it, braking hard" if bound_m_s < 0.0 else ""


def _known_vehicles(context: SafetyContext) -> Array:
    """Positions (k, 2) of the teammates and the evader."""
    places = [member.state.position_ned_m[:2] for member in context.team]
    if context.target is not None:
        places.append(context.target.position_ned_m[:2])
    return np.array(places, dtype=np.float64).reshape(-1, 2)


@njit("f8(f8,f8,f8)", cache=True)
def _brakeable(distance: float, deceleration: float, lag: float) -> float:
    """`Braking.speed_m_s` for the kernel below."""
    knee = deceleration * lag * lag
    if distance <= 0.0:
        return 0.0
    if distance <= knee:
        return distance / lag
    return math.sqrt(2.0 * deceleration * (distance - 0.5 * knee))


@njit("f8[:,::1](f8[:,::1],f8[::1],f8[:,::1],f8[::1],f8[::1])", cache=True)
def _tangent_bounds(discs: Array, clearances: Array, vehicles: Array, motion: Array, scalars: Array) -> Array:
    """Rows (m, 4) of unit normal (north, east), bound m/s and clearance m, one for each disc within braking distance.

    motion: own position, own velocity, wanted velocity; scalars: growth of the discs m, age of the discs s, age of the own
    state s, deceleration m/s2, lag s, stopping distance m that decides which discs are near, more growth of what moves m.
    """
    grow, age, own_age, deceleration, lag, stop, moving = scalars
    rows = np.empty((len(discs), 4))
    count = 0
    for index in range(len(discs)):
        disc_n, disc_e = discs[index, 3], discs[index, 4]
        if not clearances[index] < stop + grow + moving + (abs(disc_n) + abs(disc_e)) * (1.0 + age):
            continue
        radius = discs[index, 2] + grow
        offset_n = discs[index, 0] + age * disc_n - motion[0]
        offset_e = discs[index, 1] + age * disc_e - motion[1]
        distance = math.hypot(offset_n, offset_e)
        if distance < 1e-6:
            offset_n, offset_e, distance = 1e-6, 0.0, 1e-6
        known = False
        for vehicle in range(len(vehicles)):
            gap_n, gap_e = discs[index, 0] - vehicles[vehicle, 0], discs[index, 1] - vehicles[vehicle, 1]
            known = known or math.hypot(gap_n, gap_e) < discs[index, 2] + VEHICLE_NEARBY_M
        if not known and math.hypot(disc_n, disc_e) > MOVING_M_S:
            radius += moving
        widest = math.acos(min(radius / distance, 1.0))
        least = math.inf
        for share in TANGENT_SHARES:
            cosine, sine = math.cos(share * widest), math.sin(share * widest)
            to_n = (offset_n * cosine - offset_e * sine) / distance
            to_e = (offset_n * sine + offset_e * cosine) / distance
            left = distance * cosine - radius
            opening = to_n * disc_n + to_e * disc_e
            credit = opening if known else min(opening, 0.0)
            closing = to_n * motion[2] + to_e * motion[3] - credit
            after_lag = _brakeable(left - max(closing, 0.0) * (lag + own_age), deceleration, lag)
            bound = max(0.0, after_lag + credit)
            own = to_n * motion[2] + to_e * motion[3]
            own_excess = max(closing - _brakeable(left, deceleration, lag), LAGGED_WEIGHT * (closing - after_lag))
            excess = max(to_n * motion[4] + to_e * motion[5] - bound, ACTUAL_WEIGHT * own_excess)
            if excess < least:
                least = excess
                asked = bound - max(0.0, own - bound)
                rows[count, 0], rows[count, 1], rows[count, 2], rows[count, 3] = to_n, to_e, asked, clearances[index]
        count += 1
    return rows[:count]
