"""From a seed to a plan: which mission, which faults, when."""

from __future__ import annotations

import random

from flightapp.config.mission import Mission, Vehicle
from flightapp.sim.fault_campaign.kinds import KINDS, Kind, Range
from flightapp.sim.fault_campaign.missions import vary
from flightapp.sim.fault_campaign.plan import Injection, Moment, Plan

FAULTS_MAX = 3
EVADER_SHARE = 0.15
"""Share of the faults that hit the evader; the others hit a pursuer."""
DELAYS_S: dict[Moment, Range] = {
    Moment.START: (0.0, 4.0),
    Moment.TAKEOFF: (0.0, 4.0),
    Moment.PURSUIT: (0.0, 12.0),
    Moment.TERMINAL: (0.0, 4.0),
    Moment.OBSTACLE: (0.0, 0.5),
    Moment.WAY_HOME: (0.0, 10.0),
}
WEIGHTS: dict[Moment, float] = {
    Moment.START: 0.05,
    Moment.TAKEOFF: 0.1,
    Moment.PURSUIT: 0.2,
    Moment.TERMINAL: 0.4,
    Moment.OBSTACLE: 0.15,
    Moment.WAY_HOME: 0.1,
}


def draw(seed: int, mission: Mission, *, varies: bool) -> Plan:
    """The plan of `seed`; `varies`: the mission itself is changed by the seed too."""
    source = random.Random(f"fault campaign {seed}")
    flown = vary(mission, source) if varies else mission
    injections: list[Injection] = []
    taken: set[tuple[str, str]] = set()
    for _ in range(source.randint(1, FAULTS_MAX)):
        vehicle = _vehicle(source, flown)
        name = source.choice([name for name, kind in KINDS.items() if vehicle.camera or not kind.needs_camera])
        if (name, vehicle.name) not in taken:
            taken.add((name, vehicle.name))
            injections.append(_injection(source, name, KINDS[name], vehicle))
    return Plan(seed, flown, tuple(injections))


def _vehicle(source: random.Random, mission: Mission) -> Vehicle:
    evaders = [one for one in mission.vehicles if one.role == "evader"]
    pursuers = [one for one in mission.vehicles if one.role == "pursuer"]
    some = evaders if evaders and (not pursuers or source.random() < EVADER_SHARE) else pursuers
    return source.choice(some)


def _injection(source: random.Random, name: str, kind: Kind, vehicle: Vehicle) -> Injection:
    moment = Moment.START if kind.from_start else source.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
    delay_s = 0.0 if kind.from_start else source.uniform(*DELAYS_S[moment])
    duration_s = None if kind.duration_s is None else source.uniform(*kind.duration_s)
    fields = tuple((field, source.uniform(*limits)) for field, limits in kind.ranges)
    return Injection(name, vehicle.name, moment, delay_s, duration_s, fields)
