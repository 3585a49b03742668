"""Lock step: every recorded control period through a planner and today's supervisor.

Each period is given what was recorded, the setpoint before included, so that a difference does not grow by itself; only what
planner and supervisor remember of their own goes on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from flightapp.core.types import Decision
from flightapp.planning.api import Planner
from flightapp.recording.observation import Given
from flightapp.replay.flight import Flight, Tick
from flightapp.runtime.composition import build_tracker, limits_of
from flightapp.runtime.hover import Hover, wish_of
from flightapp.safety.api import SafetyContext, Supervised
from flightapp.safety.feed_forward import with_feed_forward
from flightapp.safety.supervisor import make_supervisor


@dataclass(frozen=True, slots=True)
class Decided:
    """What is decided today in one period. `failure` is what the planner raised; empty while it works."""

    decision: Decision | None
    failure: str
    supervised: Supervised


def decide(flight: Flight, planner: Planner) -> Iterator[tuple[Tick, Decided]]:
    """Every period of `flight` that has been recorded whole, with what is decided in it now."""
    vehicle, profile, mission = flight.vehicle, flight.profile, flight.mission
    limits = limits_of(vehicle, profile)
    supervisor = make_supervisor(mission, profile, vehicle.name)
    gain_1_s = profile.control.altitude_gain_1_s
    hover = Hover(mission.height_of(vehicle), limits.climb_rate_max_m_s, gain_1_s, limits.sink_rate_max_m_s)
    feed_forward = profile.control.acceleration_feed_forward
    tracker = build_tracker(mission, vehicle, profile)
    if tracker is not None and flight.velocity_gains is not None:
        tracker.fly_over(flight.velocity_gains)
    for tick in flight.ticks:
        if tick.given is None:
            continue
        if tick.starts_pursuit:
            planner.reset()
            if tracker is not None:
                tracker.begin()
        given = tick.given
        if tracker is not None:
            tracker.watch(given.observation.own, given.observation.dt_s)
        decision, failure = _asked(planner, given) if tick.planned else (None, "")
        if decision is not None and not tick.held:
            wish = wish_of(decision, hover, given.observation.own, feed_forward=feed_forward)
            hover.restart()
            if tracker is not None:
                wish = tracker.wish(wish)
        else:
            standing = hover.setpoint(given.observation.own, given.observation.own.yaw_rad)
            wish = standing if tick.sent is None or tick.flown_by_planner else tick.sent.wish
        context = SafetyContext(
            t_s=given.observation.t_s,
            dt_s=given.observation.dt_s,
            name=vehicle.name,
            own=given.observation.own,
            own_age_s=given.own_age_s,
            team=given.team,
            target=given.observation.target,
            obstacles=given.obstacles,
            obstacles_age_s=given.observation.t_s - given.obstacles.t_s,
            previous=tick.previous,
            limits=limits,
            team_link_age_s=given.team_link_age_s,
            battery_fraction=given.battery_fraction,
            heights_trusted=given.heights_trusted,
        )
        supervised = supervisor.check(wish, context)
        if tracker is not None:
            sent = with_feed_forward(supervised.setpoint, tracker.forward(supervised.setpoint), limits, profile.safety)
            supervised = replace(supervised, setpoint=sent)
        yield tick, Decided(decision, failure, supervised)
        if tracker is not None and tick.sent is not None:
            tracker.note(tick.sent.setpoint)


def _asked(planner: Planner, given: Given) -> tuple[Decision | None, str]:
    try:
        return planner.step(given.observation), ""
    except Exception as error:  # As in flight: whatever a planner raises is its failure, and the vehicle hovers.
        return None, f"{type(error).__name__}: {error}"
