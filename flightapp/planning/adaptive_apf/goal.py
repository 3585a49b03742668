"""Where the vehicle wants to be: at the target or at its place around it, ahead of a target that moves, outside of bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.space.distance import signed_distance_and_gradient

PROJECTIONS = 10


@dataclass(frozen=True, slots=True)
class Goal:
    """aim: where to fly (3,); the target's place and velocity as last known, moved to the present; age of that."""

    aim_ned_m: Array
    target_ned_m: Array
    velocity_ned_m_s: Array
    t_s: float
    age_s: float


def goal_of(observation: Observation, parameters: AdaptiveApfParameters, limits: Limits, before: Goal | None) -> Goal | None:
    """Of this moment; without a usable track the last known place, until the target counts as lost."""
    track, own = observation.target, observation.own
    if track is None or not (np.isfinite(track.position_ned_m).all() and np.isfinite(track.velocity_ned_m_s).all()):
        if before is None or before.age_s + observation.t_s - before.t_s > parameters.target_lost_s:
            return None
        age_s = before.age_s + observation.t_s - before.t_s
        return Goal(before.target_ned_m, before.target_ned_m, np.zeros(3), observation.t_s, age_s)
    if track.age_s > parameters.target_lost_s:
        return None
    ahead_s = min(max(0.0, observation.t_s - track.t_s), parameters.prediction_max_s)
    velocity = track.velocity_ned_m_s if track.age_s <= parameters.target_stale_s else np.zeros(3)
    target = track.position_ned_m + ahead_s * velocity
    aim = target
    if parameters.holds:
        aim = target + parameters.capture.slot_radius_m * _side(observation, target)
    if parameters.lead:
        aim = aim + velocity * lead_s(aim - own.position_ned_m, velocity, limits.speed_max_m_s, parameters.lead_max_s)
    return Goal(aim, target, velocity, observation.t_s, max(0.0, track.age_s))


def _side(observation: Observation, target: Array) -> Array:
    """Unit vector (3,) in the plane from the target to the own place around it: as assigned, else the present one."""
    if observation.assignment is not None:
        bearing = observation.assignment.bearing_rad
    else:
        away = observation.own.position_ned_m - target
        bearing = math.atan2(away[1], away[0])
    return np.array((math.cos(bearing), math.sin(bearing), 0.0))


def lead_s(offset: Array, velocity: Array, speed_m_s: float, longest_s: float) -> float:
    """Until something at `offset` (3,) that flies with `velocity` can be met at `speed_m_s`; `longest_s` where that is later."""
    a = speed_m_s * speed_m_s - float(velocity @ velocity)
    b, c = float(offset @ velocity), float(offset @ offset)
    if abs(a) < 1e-9:
        meet = -c / (2.0 * b) if b < -1e-9 else longest_s
    else:
        root = b * b + a * c
        if root < 0.0:
            return longest_s
        meet = (b + math.sqrt(root)) / a
        if meet < 0.0:
            return longest_s
    return min(longest_s, max(0.0, meet))


def out_of_bodies(bodies: Array, place: Array, kept_m: float, farthest_m: float) -> tuple[Array | None, bool]:
    """The `place` (3,), moved out of bodies along their gradients until `kept_m` from all, and whether it was moved.

    None where that leads too far.
    """
    moved = place
    for _ in range(PROJECTIONS):
        gap, *away = signed_distance_and_gradient(bodies, *numbers(moved), 0.0)
        if gap >= kept_m - 1e-9:
            return moved, moved is not place
        moved = moved + (kept_m - gap) * np.array(away)
        if float(np.linalg.norm(moved - place)) > farthest_m:
            break
    return None, False


def numbers(vector: Array) -> tuple[float, float, float]:
    """A vector (3,) as kernels take it."""
    return float(vector[0]), float(vector[1]), float(vector[2])
