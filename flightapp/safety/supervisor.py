"""The supervisor: the last word on every setpoint. It knows no planner."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.config.mission import Mission
from flightapp.config.profile import Profile
from flightapp.core.types import Setpoint
from flightapp.safety.api import Guard, SafetyContext, Supervised
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.altitude import AltitudeGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.separation import SeparationGuard
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.guards.spatial import SpatialGuard, breaking, worst
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.guards.staleness import ObstaclesAgeGuard, OwnStateAgeGuard
from flightapp.safety.guards.target_keep_out import TargetKeepOutGuard
from flightapp.safety.guards.unseen_sector import UnseenSectorGuard
from flightapp.safety.guards.yaw_rate import YawRateGuard
from flightapp.safety.velocity_bounds import Planar, VelocityBound, project


class Supervisor:
    """Guards in a fixed order. One instance a vehicle; `check` is called once a control period.

    1. `stops`: a setpoint or own state that cannot be used ends here with zero velocity.
    2. `limits`: speed, sectors, acceleration and jerk, yaw rate: comfort and capability, relative to the setpoint sent last.
    3. `spatial`: fence, teammates, evader, obstacles, solved together, on what the limits left. They come last, so that no
       limit can re-introduce what they forbid; when they brake they may exceed the acceleration and jerk limits, as braking must.
    4. `finals`: the rules that the spatial guards can touch again. Height last, for the same reason; a sector limit again,
       because going round something may turn the velocity into an unseen sector. It only scales the velocity down, which keeps
       every bound that is not a retreat, and it is left out during a retreat.
    """

    def __init__(
        self,
        *,
        stops: Sequence[Guard],
        limits: Sequence[Guard],
        spatial: Sequence[SpatialGuard],
        finals: Sequence[Guard],
        separation: SeparationGuard | None = None,
        unseen: UnseenSectorGuard | None = None,
        speed: SpeedGuard | None = None,
    ) -> None:
        self._stops = tuple(stops)
        self._limits = tuple(limits)
        self._spatial = tuple(spatial)
        self._finals = tuple(finals)
        self._separation = separation
        self._unseen = unseen
        self._speed = SpeedGuard() if speed is None else speed

    def check(self, setpoint: Setpoint, context: SafetyContext) -> Supervised:
        """The setpoint to send, always finite, and the guards that changed it, each with its reason."""
        acting: list[tuple[str, str]] = []
        for guard in self._stops:
            verdict = guard.check(setpoint, context)
            setpoint = verdict.setpoint
            if verdict.reason:
                acting.append((guard.name, verdict.reason))
                if not setpoint.velocity_ned_m_s.any():
                    return Supervised(setpoint, tuple(acting))
        setpoint = _run(self._limits, setpoint, context, acting)
        setpoint, retreating = self._keep_clear(setpoint, context, acting)
        if self._unseen is not None and not retreating:
            setpoint = _run((self._unseen,), setpoint, context, acting)
        return Supervised(_run(self._finals, setpoint, context, acting), tuple(acting))

    def _keep_clear(self, setpoint: Setpoint, context: SafetyContext, acting: list[tuple[str, str]]) -> tuple[Setpoint, bool]:
        """`setpoint` within the bounds of all spatial guards, and whether one of them asks for a retreat."""
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        wish: Planar = (north, east)
        turned = wish if self._separation is None else self._separation.give_way(wish, context)
        speed_max = self._speed.speed_max_m_s(context)
        bounds: list[VelocityBound] = []
        if self._separation is not None:
            bounds += self._separation.bounds(turned, speed_max, context)
        speed = math.hypot(*turned)
        for guard in self._spatial:
            retreat = max((-bound.bound_m_s for bound in bounds), default=0.0)
            bounds += guard.bounds(turned, max(speed, retreat), context)
        retreating = any(bound.bound_m_s < 0.0 for bound in bounds)
        broken = breaking(wish, bounds) or breaking(turned, bounds)
        if not broken:
            return setpoint, retreating
        allowed = project(turned, bounds, speed_max)
        seen: set[str] = set()
        for bound in broken:
            if bound.guard not in seen:
                seen.add(bound.guard)
                acting.append((bound.guard, worst(wish, [other for other in broken if other.guard == bound.guard]).reason()))
        return with_velocity(setpoint, allowed[0], allowed[1], down), retreating


def make_supervisor(mission: Mission, profile: Profile, vehicle_name: str) -> Supervisor:
    """The supervisor of `vehicle_name`; KeyError where the mission has no such vehicle.

    A pursuer keeps apart from the other pursuers and, where `target_keep_out_m` > 0, from the evader. An evader keeps
    apart from the pursuers only with `evader_yields`: its policy decides, and an evader that yields to whoever
    closes in could be herded out of the pursuit.
    """
    vehicle = mission.vehicle(vehicle_name)
    parameters = profile.safety
    volume = mission.flight_volume
    pursuers = [other.name for other in mission.vehicles if other.role == "pursuer" and other.name != vehicle_name]
    yields = vehicle.role == "pursuer" or parameters.evader_yields
    keeps_out = vehicle.role == "pursuer" and parameters.target_keep_out_m > 0.0
    spatial: list[SpatialGuard] = [TargetKeepOutGuard(parameters)] if keeps_out else []
    spatial += [GeofenceGuard(volume.vertices_m, parameters), ObstacleStopGuard(parameters)]
    altitude = AltitudeGuard(volume.height_min_m, volume.height_max_m, parameters)
    unseen = UnseenSectorGuard(parameters)
    speed = SpeedGuard(vehicle.speed_max_m_s)
    return Supervisor(
        stops=(FiniteGuard(), OwnStateAgeGuard(parameters)),
        limits=(speed, ObstaclesAgeGuard(parameters), unseen, AccelerationGuard(parameters), YawRateGuard()),
        spatial=spatial,
        finals=(altitude,),
        separation=SeparationGuard(parameters, pursuers) if yields else None,
        unseen=unseen,
        speed=speed,
    )


def _run(guards: Sequence[Guard], setpoint: Setpoint, context: SafetyContext, acting: list[tuple[str, str]]) -> Setpoint:
    for guard in guards:
        verdict = guard.check(setpoint, context)
        setpoint = verdict.setpoint
        if verdict.reason:
            acting.append((guard.name, verdict.reason))
    return setpoint
