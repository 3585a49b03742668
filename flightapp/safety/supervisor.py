"""The supervisor: the last word on every setpoint. It knows no planner."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flightapp.config.mission import Mission
from flightapp.config.profile import Profile
from flightapp.core.types import Setpoint
from flightapp.safety.api import Action, Demand, Guard, SafetyContext, Supervised, Watch
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.altitude import AltitudeGuard
from flightapp.safety.guards.battery import BatteryGuard
from flightapp.safety.guards.contingency import ContingencyGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.guards.obstacle_height import ObstacleHeightGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.obstacles_age import ObstaclesAgeGuard
from flightapp.safety.guards.own_state_age import OwnStateAgeGuard
from flightapp.safety.guards.separation import SeparationGuard
from flightapp.safety.guards.setpoints import held_yaw_rad, with_velocity
from flightapp.safety.guards.spatial import SpatialGuard, breaking, worst
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.guards.target_age import TargetAgeGuard
from flightapp.safety.guards.target_keep_out import TargetKeepOutGuard
from flightapp.safety.guards.team_link import TeamLinkGuard
from flightapp.safety.guards.unseen_sector import UnseenSectorGuard
from flightapp.safety.guards.yaw_rate import YawRateGuard
from flightapp.safety.usable import usable
from flightapp.safety.velocity_bounds import Planar, VelocityBound, project

NAME = "supervisor"


class Supervisor:
    """Guards in a fixed order; where several act, the strictest wins. One instance a vehicle; `check` is called once a period.

    0. What nobody can count with is read carefully (`usable`); the `watches` say what they ask of the executive.
    1. `stops`: a setpoint that cannot be used becomes zero velocity; without an own state that is the last word.
    2. `limits`: hold beyond the flight volume, top speed, also with old obstacles, a lost link and into unseen sectors.
    3. `spatial`: fence, teammates, evader, obstacles, solved together; with teammates the keep-right rule.
    4. `rates`: acceleration and jerk, yaw rate, relative to the setpoint sent last, towards what 3 allows.
    5. The bounds of 3 again, on what the rates left: no limit can re-introduce what a spatial guard forbids. When they
       brake or retreat here, they may exceed the acceleration and jerk limits, as braking must.
    6. The sector limit again, because going round something may turn the velocity into an unseen sector; it only scales the
       velocity down, which keeps every bound that is not a retreat, and is left out during a retreat.
    7. `finals`: height, above and below obstacles and then in the band, which nothing after the rates touches, for the same
       reason as 5.

    The answer is finite, at most as fast as the limits allow, and always comes: should a guard fail, the vehicle stands and HOLD
    is asked for.
    """

    def __init__(
        self,
        *,
        stops: Sequence[Guard],
        limits: Sequence[Guard],
        spatial: Sequence[SpatialGuard],
        rates: Sequence[Guard],
        finals: Sequence[Guard],
        separation: SeparationGuard | None = None,
        unseen: UnseenSectorGuard | None = None,
        speed: SpeedGuard | None = None,
        watches: Sequence[Watch] = (),
    ) -> None:
        self._stops = tuple(stops)
        self._limits = tuple(limits)
        self._spatial = tuple(spatial)
        self._rates = tuple(rates)
        self._finals = tuple(finals)
        self._separation = separation
        self._unseen = unseen
        self._speed = SpeedGuard() if speed is None else speed
        self._watches = tuple(watches)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> Supervised:
        """The setpoint to send, the guards that changed it or ask for something, each with its reason, and what they ask."""
        try:
            context = usable(context)
            sent, acting = self._sent(setpoint, context)
            demand = self._demand(context, acting)
            if all(map(math.isfinite, (*sent.velocity_ned_m_s.tolist(), sent.yaw_rad))):
                return Supervised(sent, tuple(acting), demand)
            reason = "a guard gave a setpoint that is not finite: standing still"
        except Exception as error:  # The last word is never missing, whatever is wrong with the guards or what they are told.
            reason = f"a guard failed, {type(error).__name__}: {error}: standing still"
        return Supervised(Setpoint(np.zeros(3), _finite_yaw_rad(context)), ((NAME, reason),), Demand(Action.HOLD, NAME, reason))

    def _sent(self, setpoint: Setpoint, context: SafetyContext) -> tuple[Setpoint, list[tuple[str, str]]]:
        acting: list[tuple[str, str]] = []
        for guard in self._stops:
            verdict = guard.check(setpoint, context)
            setpoint = verdict.setpoint
            if verdict.reason:
                acting.append((guard.name, verdict.reason))
            if verdict.final:
                return setpoint, acting
        setpoint = _run(self._limits, setpoint, context, acting)
        wish, bounds = self._bounds(setpoint, context)
        speed_max = self._speed.speed_max_m_s(context)
        setpoint = _within(setpoint, wish, bounds, speed_max, acting)
        setpoint = _run(self._rates, setpoint, context, acting)
        setpoint = _within(setpoint, _planar(setpoint), bounds, speed_max, acting)
        if self._unseen is not None and not any(bound.bound_m_s < 0.0 for bound in bounds):
            setpoint = _run((self._unseen,), setpoint, context, acting)
        return _run(self._finals, setpoint, context, acting), acting

    def _demand(self, context: SafetyContext, acting: list[tuple[str, str]]) -> Demand | None:
        """The strictest demand of all watches, the first of equals; each is named among those who act."""
        demands = [demand for watch in self._watches if (demand := watch.demand(context)) is not None]
        named = {name for name, _ in acting}
        acting += [(demand.guard, demand.reason) for demand in demands if demand.guard not in named]
        return max(demands, key=lambda demand: demand.action, default=None)

    def _bounds(self, setpoint: Setpoint, context: SafetyContext) -> tuple[Planar, list[VelocityBound]]:
        """The planar wish, turned where it must give way, and the bounds of all spatial guards that it can break.

        A retreat may be faster than the wish: where one is asked for, all bounds count up to the top speed.
        """
        wish = _planar(setpoint)
        bounds: list[VelocityBound] = []
        if self._separation is not None:
            rules = self._separation.rules(wish, context)
            backing_off = self._separation.escape(wish, rules, context)
            wish = self._separation.give_way(wish, rules) if backing_off is None else backing_off
            speed_max = self._speed.speed_max_m_s(context)
            bounds = [rule.bound for rule in rules if rule.bound.bound_m_s < speed_max]
        asked = [bound for guard in self._spatial for bound in guard.bounds(wish, math.hypot(*wish), context)]
        if any(bound.bound_m_s < 0.0 for bound in (*bounds, *asked)):
            speed_max = self._speed.speed_max_m_s(context)
            asked = [bound for guard in self._spatial for bound in guard.bounds(wish, speed_max, context)]
        return wish, [*bounds, *asked]


def make_supervisor(mission: Mission, profile: Profile, vehicle_name: str) -> Supervisor:
    """The supervisor of `vehicle_name`; KeyError where the mission has no such vehicle.

    A pursuer keeps apart from the other pursuers and, unless the mission allows contact, from the evader. An evader keeps
    apart from the pursuers only with `evader_yields`: its policy decides, and an evader that yields to whoever
    closes in could be herded out of the pursuit.
    """
    vehicle = mission.vehicle(vehicle_name)
    parameters = profile.safety
    volume = mission.flight_volume
    pursuers = [other.name for other in mission.vehicles if other.role == "pursuer" and other.name != vehicle_name]
    yields = vehicle.role == "pursuer" or parameters.evader_yields
    keeps_out = vehicle.role == "pursuer" and parameters.target_keep_out_m > 0.0 and not mission.target_contact_allowed
    spatial: list[SpatialGuard] = [TargetKeepOutGuard(parameters), TargetAgeGuard(parameters)] if keeps_out else []
    spatial += [GeofenceGuard(volume.vertices_m, parameters), ObstacleStopGuard(parameters)]
    altitude = AltitudeGuard(volume.height_min_m, volume.height_max_m, parameters)
    contingency = ContingencyGuard(
        volume.vertices_m,
        volume.height_max_m,
        contingency_m=volume.contingency_m,
        contingency_height_m=volume.contingency_height_m,
        contingency_vertices_m=volume.contingency_vertices_m,
        outside_action=Action[volume.outside_action.upper()],
    )
    home = (vehicle.start.north_m, vehicle.start.east_m)
    unseen = UnseenSectorGuard(parameters)
    speed = SpeedGuard(vehicle.speed_max_m_s)
    return Supervisor(
        stops=(FiniteGuard(), OwnStateAgeGuard(parameters)),
        limits=(speed, contingency, TeamLinkGuard(parameters), ObstaclesAgeGuard(parameters), unseen),
        spatial=spatial,
        rates=(AccelerationGuard(parameters), YawRateGuard()),
        finals=(ObstacleHeightGuard(parameters), altitude),
        separation=SeparationGuard(parameters, pursuers) if yields else None,
        unseen=unseen,
        speed=speed,
        watches=(contingency, BatteryGuard(home, vehicle.start.ground_height_m, mission.return_height_of(vehicle), parameters)),
    )


def _finite_yaw_rad(context: SafetyContext) -> float:
    """The yaw to hold where nothing in the context may be trusted."""
    try:
        yaw = held_yaw_rad(context)
        return yaw if math.isfinite(yaw) else 0.0
    except Exception:  # As for `check`.
        return 0.0


def _planar(setpoint: Setpoint) -> Planar:
    north, east, _ = setpoint.velocity_ned_m_s.tolist()
    return north, east


def _run(guards: Sequence[Guard], setpoint: Setpoint, context: SafetyContext, acting: list[tuple[str, str]]) -> Setpoint:
    for guard in guards:
        verdict = guard.check(setpoint, context)
        setpoint = verdict.setpoint
        if verdict.reason:
            acting.append((guard.name, verdict.reason))
    return setpoint


def _within(
    setpoint: Setpoint, wish: Planar, bounds: Sequence[VelocityBound], speed_max_m_s: float, acting: list[tuple[str, str]]
) -> Setpoint:
    """`setpoint` with the planar velocity nearest to `wish` that keeps all `bounds`; each guard is named once."""
    before = _planar(setpoint)
    broken = breaking(before, bounds) or breaking(wish, bounds)
    if not broken:
        return setpoint
    named = {name for name, _ in acting}
    new = [guard for guard in dict.fromkeys(bound.guard for bound in broken) if guard not in named]
    acting += [(guard, worst(before, [bound for bound in broken if bound.guard == guard]).reason()) for guard in new]
    north, east = project(wish, bounds, speed_max_m_s)
    return with_velocity(setpoint, north, east, float(setpoint.velocity_ned_m_s[2]))
