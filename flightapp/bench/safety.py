"""The supervisor's check of one setpoint, with 40 discs and three teammates."""

from __future__ import annotations

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import DISCS, PERIOD_S, circling, evader, ring, teammates
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.types import Limits, Setpoint
from flightapp.safety.api import SafetyContext
from flightapp.safety.supervisor import make_supervisor

TEAMMATES = ("bench-1", "bench-2", "bench-3")


def supervisor_measurement(mission: Mission, profile: Profile, vehicle: Vehicle, limits: Limits, seconds: float) -> Measurement:
    """One check with its context."""
    others = tuple(vehicle.model_copy(update={"name": name}) for name in TEAMMATES)
    crowded = mission.model_copy(update={"vehicles": (*mission.vehicles, *others)})
    supervisor = make_supervisor(crowded, profile, vehicle.name)

    def situation(k: int) -> tuple[Setpoint, SafetyContext]:
        own = circling(k)
        previous = Setpoint(own.velocity_ned_m_s, own.yaw_rad)
        context = SafetyContext(
            t_s=own.t_s,
            dt_s=PERIOD_S,
            name=vehicle.name,
            own=own,
            own_age_s=0.02,
            team=teammates(own, TEAMMATES),
            target=evader(own, 9.0),
            obstacles=ring(own),
            obstacles_age_s=0.05,
            previous=previous,
            limits=limits,
            team_link_age_s=0.05,
            battery_fraction=0.8,
        )
        return Setpoint(own.velocity_ned_m_s * 1.5, own.yaw_rad + 0.05), context

    name = f"supervisor, check with {DISCS} discs"
    return measure(Work(name, situation, lambda given: supervisor.check(*given)), seconds)
