"""One observation, digested: where all are now and the scene around, by the same kernels as AC2F's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.recollection import DISCS, blank_recollection
from flightapp.planning.ac2f.records import VIEW, blank_memory, parameter_record
from flightapp.planning.ac2f.scene import SCENE_COLUMNS
from flightapp.planning.ac2f.surroundings import MEMBER_COLUMNS, TRAIL_COLUMNS, look, trail_samples
from flightapp.planning.hunting.parameters import HuntingParameters

STANDING_M_S = 0.05
FACING_AHEAD_RAD = 0.5
"""How far ahead of the nose a vehicle that turns where it stands may be told to look."""
NOWHERE = np.zeros(2)


@dataclass(frozen=True, slots=True)
class View:
    """What is known at one moment; mission frame, planar."""

    t_s: float
    own_m: tuple[float, float]
    ahead_m: tuple[float, float]
    """Where the lag of the velocity loop puts the vehicle."""
    base_m_s: tuple[float, float]
    """Velocity from which the window opens."""
    course_rad: float
    """Of that velocity; of the nose where it stands."""
    target_m: tuple[float, float]
    target_m_s: tuple[float, float]
    target_age_s: float
    """NaN: no target."""
    team: Array  # (k, 4) north, east, v_north, v_east of teammates that were heard lately
    scene: Array  # (m, 6) inflated discs, see ac2f.scene: obstacles, then vehicles
    obstacles: int
    """Rows of the scene that are obstacles."""
    depth_m: float
    """How deep the vehicle is inside the worst inflation."""
    clearance_m: float
    team_complete: bool

    @property
    def speed_m_s(self) -> float:
        return math.hypot(*self.base_m_s)

    @property
    def distance_m(self) -> float:
        return math.dist(self.own_m, self.target_m)


class Sight:
    """The view and what it remembers: static discs, and where other vehicles were."""

    def __init__(self, parameters: HuntingParameters, limits: Limits, range_m: float, apart_m: float, keep_out_m: float) -> None:
        """apart_m: between the centres of teammates; keep_out_m: from the target's centre, 0 where contact is wanted."""
        self.lag_m = parameters.lagging_margin * parameters.response_lag_s * limits.speed_max_m_s
        """Kept from obstacles on top of the safety margin."""
        self._lags = parameters.response_lag_s > 0.0
        given = Ac2fParameters(
            capture=parameters.capture,
            control_period_s=parameters.control_period_s,
            command_blend=parameters.command_blend,
            response_lag_s=parameters.response_lag_s,
            team_stale_s=parameters.team_stale_s,
            target_stale_s=parameters.target_stale_s,
            target_lost_s=parameters.target_lost_s,
            obstacle_range_m=range_m,
            rejection_radius_m=limits.body_radius_m + limits.safety_margin_m + self.lag_m,
            disc_memory_s=parameters.disc_memory_s,
            vehicle_radius_max_m=parameters.vehicle_radius_max_m,
            team_separation_m=apart_m,
        )
        self._record = parameter_record(given, limits)
        self._record["evader_distance_m"] = keep_out_m
        self._record["slot_radius_m"] = math.inf  # the ring's chord is in apart_m already
        self._trail_samples = trail_samples(given)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._memory = blank_memory()
        self._recollection = blank_recollection()
        self._members = np.zeros((0, MEMBER_COLUMNS))
        self._trail = np.zeros((self._trail_samples, TRAIL_COLUMNS))
        self._scene = np.zeros((0, SCENE_COLUMNS))
        self._view = np.zeros(1, VIEW)
        self._facing_rad: float | None = None

    def commanded(self, north_m_s: float, east_m_s: float, yaw_rad: float) -> None:
        """Keep the command of this step."""
        self._facing_rad = yaw_rad
        self._memory["has_command"], self._memory["command_n"], self._memory["command_e"] = 1, north_m_s, east_m_s

    def look(self, observation: Observation) -> View:
        """The view of this moment."""
        own, target, obstacles, count = observation.own, observation.target, observation.obstacles, len(observation.team)
        self._make_room(count, len(obstacles.discs))
        for row, member in enumerate(observation.team):
            north, east, _ = member.state.position_ned_m.tolist()
            v_north, v_east, _ = member.state.velocity_ned_m_s.tolist()
            self._members[row] = north, east, v_north, v_east, member.state.t_s, member.age_s, math.nan
        team, etas = np.empty((count, 4)), np.empty(count)
        look(
            self._record, self._memory, _plain(own.position_ned_m), _plain(own.velocity_ned_m_s), own.yaw_rad, observation.t_s,
            self._members, NOWHERE if target is None else _plain(target.position_ned_m),
            NOWHERE if target is None else _plain(target.velocity_ned_m_s), 0.0 if target is None else target.t_s,
            math.nan if target is None else target.age_s, _plain(obstacles.discs), obstacles.t_s, _plain(obstacles.unseen), team,
            etas, self._recollection, self._scene, self._trail, self._view,
        )  # fmt: skip
        view = self._view[0]
        base = float(view["base_n"]), float(view["base_e"])
        course = math.atan2(base[1], base[0]) if math.hypot(*base) > STANDING_M_S else self._nose_rad(own.yaw_rad)
        return View(
            observation.t_s,
            (float(view["own_n"]), float(view["own_e"])),
            (float(view["ahead_n"]), float(view["ahead_e"])),
            base,
            course,
            (float(view["target_n"]), float(view["target_e"])),
            (float(view["target_vn"]), float(view["target_ve"])),
            math.nan if target is None else target.age_s,
            team[: int(view["team_count"])],
            self._scene[: int(view["scene_count"])],
            int(view["obstacle_count"]),
            float(view["depth_m"]),
            float(view["clearance_m"]),
            bool(view["team_complete"]),
        )

    def _nose_rad(self, yaw_rad: float) -> float:
        """Of one that stands: where it is turning to. From where its nose is now, a control period's turn is a setpoint so near
        that an autopilot hardly turns."""
        if not self._lags or self._facing_rad is None:
            return yaw_rad
        ahead = wrap_pi(self._facing_rad - yaw_rad)
        return wrap_pi(yaw_rad + max(-FACING_AHEAD_RAD, min(FACING_AHEAD_RAD, ahead)))

    def _make_room(self, teammates: int, discs: int) -> None:
        if teammates != len(self._members):
            self._members = np.zeros((teammates, MEMBER_COLUMNS))
            missing = self._trail_samples * (teammates + 1) - len(self._trail)
            if missing > 0:
                self._trail = np.concatenate((self._trail, np.zeros((missing, TRAIL_COLUMNS))))
        if discs + DISCS + teammates + 1 > len(self._scene):
            self._scene = np.zeros((2 * discs + DISCS + teammates + 1, SCENE_COLUMNS))


def _plain(value: Array) -> Array:
    """As the kernels take it: float64, row by row, writable."""
    return np.require(value, np.float64, ("C", "W"))
