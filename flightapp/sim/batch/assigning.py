"""The leader's plan among simulated pursuers: the application's planning core, with the first pursuer as the leader.

The election is not simulated. The plan travels as late as all messages and is lost as often; what is heard stays in force.
"""

from __future__ import annotations

import math
from collections import deque

from flightapp.core.types import Assignment, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.fleet.coordination.core import Coordinator, Voice
from flightapp.fleet.coordination.plan import Plan
from flightapp.fleet.coordination.scene import Pursuer, Scene
from flightapp.sim.batch.noise import uniform
from flightapp.sim.batch.scenario import Scenario

_VOICE = Voice("p1", 1, is_own=True)


class Assigning:
    """One leader's core, and what every pursuer has heard of its plans."""

    def __init__(self, scenario: Scenario, key: int) -> None:
        self._names = [f"p{index + 1}" for index in range(scenario.pursuers.count)]
        self._speed_m_s = scenario.pursuers.speed_max_m_s
        self._key, self._loss = key, scenario.messages.loss_probability
        delay = math.ceil(scenario.messages.delay_s / scenario.control_period_s - 1e-9)
        self._sent: deque[Plan | None] = deque([None] * delay, maxlen=delay + 1)
        self._heard: list[Plan | None] = [None] * len(self._names)
        self._core = Coordinator(scenario.capture.slot_radius_m)

    def assignments(
        self,
        tick: int,
        leader: VehicleState,
        team: tuple[TeamMember, ...],
        target: TargetTrack | None,
        obstacles: ObstacleSet,
    ) -> list[Assignment | None]:
        """Of every pursuer at control period `tick`, from what the leader knows then."""
        plans = self._core.step(leader.t_s, _VOICE, self._scene(leader, team, target, obstacles), ())
        self._sent.append(plans[0] if plans else None)
        arriving = self._sent[0]
        self._heard[0] = self._core.plan
        for i in range(1, len(self._names)):
            if arriving is not None and uniform(self._key, tick, 0, len(self._names) + i) >= self._loss:
                self._heard[i] = arriving
        return [_assignment(plan, name) for plan, name in zip(self._heard, self._names, strict=True)]

    def _scene(
        self, leader: VehicleState, team: tuple[TeamMember, ...], target: TargetTrack | None, obstacles: ObstacleSet
    ) -> Scene | None:
        if target is None:
            return None
        places = [(self._names[0], leader), *((member.name, member.state) for member in team)]
        pursuers = [
            Pursuer(name, float(at.position_ned_m[0]), float(at.position_ned_m[1]), self._speed_m_s) for name, at in places
        ]
        north, east, _ = map(float, target.position_ned_m)
        v_north, v_east, _ = map(float, target.velocity_ned_m_s)
        return Scene(north, east, v_north, v_east, tuple(pursuers), obstacles.discs)


def _assignment(plan: Plan | None, vehicle: str) -> Assignment | None:
    seat = None if plan is None else plan.seat_of(vehicle)
    return None if plan is None or seat is None else Assignment(seat.bearing_rad, plan.arrival_s)
