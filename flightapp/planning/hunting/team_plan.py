"""The hunt as the fleet's leader plans it: base point, ring and slots in a plan that travels."""

from __future__ import annotations

import math

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Limits
from flightapp.fleet.coordination.plan import Meeting, Plan, Seat
from flightapp.fleet.coordination.scene import Scene
from flightapp.fleet.coordination.team_plan import Draft
from flightapp.planning.api import Given
from flightapp.planning.hunting.build import parameters_of
from flightapp.planning.hunting.hunt import Hunt, Hunter, Place, plan_hunt, rules_of
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.prediction import TrackHistory

MOVING_SHARE = 0.05
"""Of its assumed top speed: slower, the target's course means nothing."""


class HuntingTeamPlan:
    """Every vehicle keeps the target's track, so that whoever is elected goes on at once."""

    def __init__(self, parameters: HuntingParameters, limits: Limits) -> None:
        self.period_s = parameters.plan_period_s
        self.leaderless_s = parameters.leaderless_s if parameters.consensus else math.inf
        self._rules = rules_of(parameters, limits)
        self._history = TrackHistory()
        self._course_rad: float | None = None

    def note(self, now_s: float, scene: Scene) -> None:
        self._history.note(now_s, (scene.north_m, scene.east_m), now_s)
        if math.hypot(scene.v_north_m_s, scene.v_east_m_s) > MOVING_SHARE * self._rules.target_speed_max_m_s:
            self._course_rad = math.atan2(scene.v_east_m_s, scene.v_north_m_s)

    def draft(self, now_s: float, scene: Scene, before: Plan | None) -> Draft:
        pursuers = sorted(scene.pursuers, key=lambda pursuer: pursuer.name)
        hunters = tuple(
            Hunter(one.name, (one.north_m, one.east_m), one.heading_rad, one.speed_m_s, one.speed_max_m_s) for one in pursuers
        )
        hunt = plan_hunt(
            now_s,
            (scene.north_m, scene.east_m),
            self._target_course_rad(scene),
            self._history.fit(now_s),
            hunters,
            scene.discs,
            self._rules,
            None if before is None else hunt_of(before),
        )
        return draft_of(hunt)

    def _target_course_rad(self, scene: Scene) -> float:
        """Of its motion; before it moved the bearing from the team's middle to it."""
        if self._course_rad is not None:
            return self._course_rad
        count = len(scene.pursuers)
        north = scene.north_m - sum(one.north_m for one in scene.pursuers) / count
        east = scene.east_m - sum(one.east_m for one in scene.pursuers) / count
        return math.atan2(east, north)


def draft_of(hunt: Hunt) -> Draft:
    """The plan to send."""
    seats = tuple(
        Seat(name, wrap_pi(place.bearing_rad), *place.place_m, place.alone_s, place.slot) for name, place in hunt.places.items()
    )
    heading = wrap_pi(hunt.heading_rad)
    at = Meeting(*hunt.base_m, heading, hunt.radius_m, hunt.meeting_s, hunt.slots, hunt.closing, hunt.reachable)
    return Draft(seats, at)


def hunt_of(plan: Plan) -> Hunt | None:
    """The hunt that a plan tells of, this leader's or another's; None for plans of another kind."""
    at = plan.meeting
    if at is None:
        return None
    places = {seat.vehicle: Place(seat.bearing_rad, (seat.north_m, seat.east_m), seat.alone_s, seat.slot) for seat in plan.seats}
    return Hunt((at.north_m, at.east_m), at.radius_m, at.heading_rad, at.t_s, at.slots, at.closing, at.reachable, places)


def build_team_plan(name: str, limits: Limits, given: Given) -> HuntingTeamPlan:
    """As the registry asks for it, with the parameters of the strategy."""
    return HuntingTeamPlan(parameters_of(name, given), limits)
