"""The way of an evader around obstacles and out of the pursuers' reach, in one compiled kernel.

The wish is turned by the repulsion of obstacles, then replaced by the velocity nearest to it from which the vehicle can still
stop before every obstacle and every pursuer.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.ac2f.potential_field import MANOEUVRE_S, _choose, _repulsion
from flightapp.planning.ac2f.records import Record
from flightapp.planning.ac2f.scene import GRACE_M, _inflate
from flightapp.planning.compiled import compiled
from flightapp.planning.evasion.parameters import AvoidingParameters
from flightapp.planning.plane import Point, planar

SCENE_COLUMNS = 6
STANDING_M_S = 1e-6

GIVEN = (
    "field_gain_m2",
    "field_influence_m",
    "field_repulsion_max",
    "pursuer_distance_m",
    "obstacle_range_m",
    "reaction_s",
)
DERIVED = ("inflation_m", "braking_m_s2", "speed_max_m_s")
AVOIDANCE = np.dtype([(name, "f8") for name in GIVEN + DERIVED], align=True)
AVOIDANCE_TYPE = numba.types.Array(numba.from_dtype(AVOIDANCE), 1, "C")
FLOAT = numba.float64
ROWS = FLOAT[:, ::1]


@compiled("void(f8[::1],f8[:,::1],f8,f8,f8,f8,f8)")
def _turn(wish: Array, scene: Array, n: float, e: float, gain_m2: float, influence_m: float, repulsion_max: float) -> None:
    """Turn `wish` (2,) m/s by the repulsion of `scene` at (n, e), at the same speed."""
    speed = math.hypot(wish[0], wish[1])
    if speed < STANDING_M_S:
        return
    push = np.empty(2)
    _repulsion(scene, n, e, gain_m2, influence_m, push)
    force = math.hypot(push[0], push[1])
    scale = repulsion_max / force if force > repulsion_max else 1.0
    north = wish[0] / speed + scale * push[0]
    east = wish[1] / speed + scale * push[1]
    length = math.hypot(north, east)
    if length > STANDING_M_S:
        wish[0] = north * speed / length
        wish[1] = east * speed / length


@compiled("i8(f8[:,::1],i8,f8[:,::1],f8,f8,f8,f8)")
def _add_pursuers(scene: Array, count: int, pursuers: Array, n: float, e: float, distance_min_m: float, range_m: float) -> int:
    """Write the `pursuers` (k, 4) within `range_m` behind the first `count` rows of `scene`; returns the new count."""
    for i in range(pursuers.shape[0]):
        distance = math.hypot(pursuers[i, 0] - n, pursuers[i, 1] - e)
        if distance - distance_min_m <= range_m:
            scene[count, 0] = pursuers[i, 0]
            scene[count, 1] = pursuers[i, 1]
            scene[count, 2] = max(0.0, min(distance_min_m, distance - GRACE_M))
            scene[count, 3] = pursuers[i, 2]
            scene[count, 4] = pursuers[i, 3]
            scene[count, 5] = max(0.0, distance_min_m - distance)
            count += 1
    return count


@compiled(numba.void(AVOIDANCE_TYPE, FLOAT, FLOAT, FLOAT, FLOAT, ROWS, FLOAT, ROWS, ROWS, FLOAT[::1]))
def avoid(
    parameters: Record,
    own_n: float,
    own_e: float,
    base_n: float,
    base_e: float,
    discs: Array,
    age_s: float,
    pursuers: Array,
    scene: Array,
    wish: Array,
) -> None:
    """Make `wish` (2,) m/s one that can be flown from (own_n, own_e) at the velocity (base_n, base_e).

    discs: (n, 7) observed `age_s` ago. pursuers: (k, 4). scene: workspace (>= n + k, 6).
    """
    p = parameters[0]
    count = _inflate(discs, own_n, own_e, age_s, p.inflation_m, p.obstacle_range_m, np.empty((0, 2)), 0.0, 0.0, scene)
    _turn(wish, scene[:count], own_n, own_e, p.field_gain_m2, p.field_influence_m, p.field_repulsion_max)
    count = _add_pursuers(scene, count, pursuers, own_n, own_e, p.pursuer_distance_m, p.obstacle_range_m)
    reach = p.braking_m_s2 * MANOEUVRE_S
    _choose(
        scene[:count],
        own_n,
        own_e,
        wish[0],
        wish[1],
        base_n,
        base_e,
        p.speed_max_m_s,
        reach,
        p.braking_m_s2,
        p.reaction_s,
        wish,
    )


class Avoidance:
    """`avoid` for one vehicle, with its workspace."""

    def __init__(self, limits: Limits, parameters: AvoidingParameters) -> None:
        record = np.zeros(1, AVOIDANCE)
        for name in GIVEN:
            record[name] = getattr(parameters, name)
        record["inflation_m"] = limits.body_radius_m + limits.safety_margin_m
        record["braking_m_s2"] = limits.acceleration_max_m_s2 * parameters.braking_share
        record["speed_max_m_s"] = limits.speed_max_m_s
        self._record = record
        self._scene = np.empty((64, SCENE_COLUMNS))

    def velocity(self, observation: Observation, own: Point, pursuers: Array, wish: Point) -> Point:
        """What of `wish` (m/s) can be flown; pursuers: (k, 4)."""
        obstacles = observation.obstacles
        discs = np.ascontiguousarray(obstacles.discs, dtype=np.float64)
        if len(discs) + len(pursuers) > len(self._scene):
            self._scene = np.empty((2 * (len(discs) + len(pursuers)), SCENE_COLUMNS))
        velocity = np.array(wish)
        age_s = max(0.0, observation.t_s - obstacles.t_s)
        base = planar(observation.own.velocity_ned_m_s)
        avoid(self._record, *own, *base, discs, age_s, pursuers, self._scene, velocity)
        return planar(velocity)
