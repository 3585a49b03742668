"""Minimum-jerk motions to rest, for a vehicle that is commanded by its jerk (section III-D of the paper, without its solver).

Each leads from the present position, velocity and acceleration to a goal in some time, in closed form. One that has all control
points of its Bernstein form in the safety cell, and those of its derivatives within the limits, does so all the way. That the
next cell still contains the rest of it is not proven: the room is reduced by what stopping takes, and the last resort is the
motion from before, which ends at rest, or braking.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Limits
from flightapp.planning.encirclement.situation import Situation
from flightapp.planning.plane import Point

DURATIONS_S: Array = np.linspace(0.4, 4.0, 19)
"""Of the motions that are tried."""
REACH_SHARE = 0.6
"""The farthest rest that is reached at no more than top speed: this share of top speed times the longest duration."""
PULLS: Array = np.append(1.0, 1.0 - 0.9 * 0.75 ** np.arange(11.0, -1.0, -1.0))
"""Shares of the way to the goal, no farther than reached, tried from the longest.

Renewed every period, the motion to the share p is flown at p times top speed; from that speed the share p + (1 - p) / 3 can be
reached, so the next is less than that: steps as even as on the way to near goals would end the acceleration early.
"""
SAMPLES: Array = np.linspace(0.0625, 0.9375, 8)
"""Where a motion's distance to the goal is looked at, as shares of its duration."""
NEW, KEPT, BRAKING = "new", "kept", "braking"

_TO_BERNSTEIN = {
    degree: np.array(
        [[math.comb(i, k) / math.comb(degree, k) if k <= i else 0.0 for k in range(degree + 1)] for i in range(degree + 1)]
    )
    for degree in (2, 3, 4, 5)
}


@dataclass(frozen=True, slots=True)
class Primitive:
    """position(t) = sum of powers[k] t^k for t in [0, duration_s] after `t_s`, and rest from then on."""

    t_s: float
    duration_s: float
    powers: Array
    """(6, 2): m/s^k, (north, east)."""

    def at(self, t_s: float, derivative: int = 0) -> Array:
        """Position (2,) or a derivative of it at the time `t_s`; at rest from the end on."""
        passed = t_s - self.t_s
        if passed >= self.duration_s:
            passed = self.duration_s
            if derivative > 0:
                return np.zeros(2)
        powers = derived(self.powers, derivative)
        found: Array = (passed ** np.arange(len(powers))) @ powers
        return found


def derived(powers: Array, times: int) -> Array:
    """Powers (k, ...) of the derivative."""
    for _ in range(times):
        factors = np.arange(1, len(powers)).reshape(-1, *[1] * (powers.ndim - 1))
        powers = powers[1:] * factors
    return powers


def to_rest(position: Array, velocity: Array, acceleration: Array, goals: Array, durations_s: Array) -> Array:
    """Powers (6, d, g, 2) of the motions of least squared jerk to rest at `goals` (g, 2) in `durations_s` (d,)."""
    time = durations_s[:, None, None]
    place = goals[None] - position - velocity * time - 0.5 * acceleration * time**2
    speed = np.broadcast_to(-velocity - acceleration * time, place.shape)
    change = np.broadcast_to(-acceleration, place.shape)
    fifth = (720.0 * place - 360.0 * time * speed + 60.0 * time**2 * change) / time**5
    fourth = (-360.0 * time * place + 168.0 * time**2 * speed - 24.0 * time**3 * change) / time**5
    third = (60.0 * time**2 * place - 24.0 * time**3 * speed + 3.0 * time**4 * change) / time**5
    start = [np.broadcast_to(value, place.shape) for value in (position, velocity, 0.5 * acceleration)]
    return np.stack([*start, third / 6.0, fourth / 24.0, fifth / 120.0])


def mean_squared_jerk(powers: Array, durations_s: Array) -> Array:
    """(d, g) of motions (6, d, g, 2), over their duration."""
    jerk, fourth, fifth = 6.0 * powers[3], 24.0 * powers[4], 120.0 * powers[5]
    time = durations_s[:, None, None]
    total = jerk**2 + fourth * jerk * time + fourth**2 * time**2 / 3.0 + fifth * jerk * time**2 / 3.0
    total = total + fifth * fourth * time**3 / 4.0 + fifth**2 * time**4 / 20.0
    found: Array = total.sum(axis=-1)
    return found


def control_points(powers: Array, durations_s: Array) -> Array:
    """(k, d, g, 2) in the Bernstein form over the duration of polynomials (k, d, g, 2): their hull contains the whole curve."""
    degree = len(powers) - 1
    scaled = powers * durations_s[None, :, None, None] ** np.arange(degree + 1)[:, None, None, None]
    found: Array = np.tensordot(_TO_BERNSTEIN[degree], scaled, axes=1)
    return found


class Primitives:
    """The motion that one vehicle follows, renewed every period."""

    def __init__(self, limits: Limits, jerk_weight: float, goal_weight: float) -> None:
        self._limits, self._jerk_weight, self._goal_weight = limits, jerk_weight, goal_weight
        self.reset()

    def reset(self) -> None:
        """At rest."""
        self.current: Primitive | None = None

    def step(self, situation: Situation, goal: Point) -> tuple[Array, Array, str]:
        """Velocity (2,) and acceleration (2,) at the end of this period, and where they come from: NEW, KEPT or BRAKING."""
        position, velocity = np.array(situation.own), np.array(situation.velocity)
        acceleration = np.zeros(2) if self.current is None else self.current.at(situation.t_s, 2)
        planes = _with_stopping_room(situation, self._limits)
        found = self._best(situation.t_s, position, velocity, acceleration, np.array(goal), planes)
        source = NEW
        if found is None:
            found, source = self.current, KEPT
            if found is None or not self._stays(found, situation, planes):
                found, source = self._braking(situation, position, velocity, acceleration), BRAKING
        self.current = found
        end_s = situation.t_s + situation.period_s
        return found.at(end_s, 1), found.at(end_s, 2), source

    def _best(
        self, t_s: float, position: Array, velocity: Array, acceleration: Array, goal: Array, planes: Array
    ) -> Primitive | None:
        """The cheapest motion that is allowed, of those that lead farthest; None where none is."""
        reach_m = REACH_SHARE * self._limits.speed_max_m_s * float(DURATIONS_S[-1])
        way = goal - position
        way *= min(1.0, reach_m / max(float(np.hypot(*way)), 1e-9))
        goals = position + PULLS[:, None] * way
        powers = to_rest(position, velocity, acceleration, goals, DURATIONS_S)
        allowed = self._allowed(powers, DURATIONS_S, position, planes)
        if not allowed.any():
            return None
        pull = int(allowed.any(axis=0).argmax())
        rows = np.flatnonzero(allowed[:, pull])
        some, durations = powers[:, rows, pull : pull + 1], DURATIONS_S[rows]
        passed = durations[:, None] * SAMPLES
        places = sum(some[k][:, 0, None, :] * passed[..., None] ** k for k in range(6)) - goal
        cost = self._jerk_weight * mean_squared_jerk(some, durations)[:, 0]
        cost = cost + self._goal_weight * (places**2).sum(axis=-1).mean(axis=1)
        best = int(cost.argmin())
        return Primitive(t_s, float(durations[best]), some[:, best, 0])

    def _allowed(self, powers: Array, durations_s: Array, position: Array, planes: Array) -> Array:
        """(d, g): within the limits and the planes all the way."""
        limits = self._limits
        allowed = np.ones(powers.shape[1:3], dtype=bool)
        most = (limits.speed_max_m_s, limits.acceleration_max_m_s2, limits.jerk_max_m_s3)
        for derivative, limit in enumerate(most, 1):
            points = control_points(derived(powers, derivative), durations_s)[1 if derivative < 3 else 0 :]
            allowed &= (np.hypot(points[..., 0], points[..., 1]) <= limit + 1e-9).all(axis=0)
        if len(planes):
            way = control_points(powers, durations_s)[1:] - position
            allowed &= (np.tensordot(way, planes[:, :2].T, axes=1) <= planes[:, 2] + 1e-9).all(axis=(0, 3))
        return allowed

    def _stays(self, primitive: Primitive, situation: Situation, planes: Array) -> bool:
        """Whether the rest of a motion keeps to the planes."""
        rest = np.linspace(situation.t_s, max(situation.t_s, primitive.t_s + primitive.duration_s), 9)
        way = np.array([primitive.at(float(t_s)) for t_s in rest]) - np.array(situation.own)
        return bool((way @ planes[:, :2].T <= planes[:, 2] + 1e-6).all())

    def _braking(self, situation: Situation, position: Array, velocity: Array, acceleration: Array) -> Primitive:
        """To rest as fast as the acceleration allows."""
        speed = float(np.hypot(*velocity))
        duration = max(2.0 * situation.period_s, 1.875 * speed / self._limits.acceleration_max_m_s2)
        goal = position + 0.5 * duration * velocity
        powers = to_rest(position, velocity, acceleration, goal[None], np.array([duration]))
        return Primitive(situation.t_s, duration, powers[:, 0, 0])


def _with_stopping_room(situation: Situation, limits: Limits) -> Array:
    """The planes (p, 3), each with less room by what stopping takes at the present speed towards it.

    No less than none: beyond a plane the vehicle may not go deeper, and its goal is where it should be.
    """
    planes = situation.planes[: situation.plane_count].copy()
    towards = np.maximum(0.0, planes[:, :2] @ np.array(situation.velocity))
    stopping = towards**2 / (2.0 * limits.acceleration_max_m_s2) + towards * limits.acceleration_max_m_s2 / limits.jerk_max_m_s3
    planes[:, 2] = np.maximum(planes[:, 2] - stopping, 0.0)
    return planes
