"""The way of an evader around obstacles and out of the pursuers' reach, in one compiled kernel.

The wish is turned by the repulsion of obstacles, then replaced by the velocity nearest to it from which the vehicle can still
stop before every obstacle and every pursuer.
"""

from __future__ import annotations

import numba
import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.ac2f.field import deflected
from flightapp.planning.ac2f.records import NUMBER, ROWS, Record
from flightapp.planning.ac2f.safe_velocity import PAIR_TYPE, Braking, safe_velocity
from flightapp.planning.ac2f.scene import SCENE_COLUMNS, add_vehicle, inflate
from flightapp.planning.evasion.parameters import AvoidingParameters
from flightapp.planning.plane import Point, planar

GAP_MIN_M = 0.1
"""The field counts a smaller gap as this."""

PLAIN = Braking(0.0, 0.0)
"""For its defaults: an evader has no costs of its own."""

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


@compiled(PAIR_TYPE(AVOIDANCE_TYPE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, ROWS, NUMBER, ROWS, ROWS))
def avoid(
    parameters: Record,
    own_n: float,
    own_e: float,
    base_n: float,
    base_e: float,
    wish_n: float,
    wish_e: float,
    discs: Array,
    age_s: float,
    pursuers: Array,
    scene: Array,
) -> Point:
    """What of the wish (m/s) can be flown from (own_n, own_e) at the velocity (base_n, base_e).

    discs: (n, 7) observed `age_s` ago. pursuers: (k, 4). scene: workspace (>= n + k, 6).
    """
    p = parameters[0]
    gain_m2, influence_m, cap = p.field_gain_m2, p.field_influence_m, p.field_repulsion_max
    count = inflate(discs, own_n, own_e, age_s, p.inflation_m, p.obstacle_range_m, np.empty((0, 2)), 0.0, 0.0, scene)
    wish_n, wish_e = deflected(scene[:count], own_n, own_e, wish_n, wish_e, gain_m2, influence_m, cap, GAP_MIN_M)
    for i in range(pursuers.shape[0]):
        count = add_vehicle(scene, count, pursuers[i], own_n, own_e, p.pursuer_distance_m, p.obstacle_range_m)
    braking = Braking(
        p.braking_m_s2,
        p.reaction_s,
        PLAIN.manoeuvre_s,
        PLAIN.leaving_gain_per_s,
        PLAIN.leaving_speed_max_m_s,
        PLAIN.excess_cost,
        PLAIN.reached_excess_cost,
        PLAIN.across_cost,
        PLAIN.change_cost,
    )
    return safe_velocity(scene[:count], own_n, own_e, wish_n, wish_e, base_n, base_e, p.speed_max_m_s, braking)


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
        age_s = max(0.0, observation.t_s - obstacles.t_s)
        base = planar(observation.own.velocity_ned_m_s)
        return avoid(self._record, *own, *base, *wish, discs, age_s, pursuers, self._scene)
