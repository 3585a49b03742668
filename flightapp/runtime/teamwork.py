"""What one vehicle makes of the others' states: teammates for planner and guards, cut-outs for perception, events of loss.

Who is pursuer and who is evader stands in the mission; what a message says of its sender's role is not believed.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from flightapp.core.types import Array, Decision, TargetTrack, TeamMember, VehicleState
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.roster import Roster, lost_age_s
from flightapp.fleet.shared_state import SharedState
from flightapp.fleet.telling import StateTelling
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.team_rates import state_rates

ACTIVE_PHASES = ("ready", "pursue")
FORGOTTEN_S = 10.0
EXTRAPOLATION_MAX_S = 0.5
CUT_OUT_MARGIN_M = 0.4
LEFT_AGE_MAX_S = 0.2
"""Of the last state of a vehicle whose liveliness token went: a few periods, in which one may be lost without harm."""
LEFT_PERIODS = 2.0
"""The same for who sends rarely."""


class Teamwork:
    """Reads the peers of `rooms.team`; holds only who is known to be silent."""

    def __init__(self, rooms: Rooms) -> None:
        self._rooms = rooms
        self._roles = {vehicle.name: vehicle.role for vehicle in rooms.mission.vehicles}
        self._silent: set[str] = set()
        self._roster = Roster(rooms.team.post)
        self._rates = state_rates(len(rooms.mission.vehicles), rooms.profile, rooms.limits)
        self._telling = StateTelling(rooms.team, self._rates)

    @property
    def silent(self) -> Collection[str]:
        """Vehicles that were heard and are not heard any more."""
        return self._silent

    def evader_state(self) -> SharedState | None:
        """Newest state of the mission's evader, where it is a vehicle of this fleet and was heard."""
        for name, peer in self._rooms.team.peers.items():
            if self._roles[name] == "evader":
                return peer.state
        return None

    def members(self, now_s: float, active_only: bool) -> tuple[TeamMember, ...]:
        """Teammates at `now_s`: pursuers that take part for the planner, every airborne vehicle but the target for safety."""
        members = []
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if state is None or self._roles[name] == "evader" or now_s - state.t_s > FORGOTTEN_S:
                continue
            if not state.airborne or (active_only and state.phase not in ACTIVE_PHASES):
                continue
            age_s = now_s - state.t_s
            velocity = np.array(state.velocity_ned_m_s)
            position = np.array(state.position_ned_m) + velocity * min(age_s, EXTRAPOLATION_MAX_S)
            members.append(
                TeamMember(name, VehicleState(now_s, position, velocity, state.yaw_rad), state.mode, state.eta_s, age_s)
            )
        return tuple(members)

    def link_age_s(self, now_s: float) -> float | None:
        """Since the newest state of any vehicle that is not done yet; None where no such vehicle was heard."""
        states = [peer.state for peer in self._rooms.team.peers.values()]
        ages = [now_s - state.t_s for state in states if state is not None and state.phase != "done"]
        return min(ages) if ages else None

    def cut_outs(self, now_s: float) -> Array:
        """Rows north_m, east_m, radius_m where a teammate is known to be now, which must not become an obstacle."""
        rows = []
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if (
                self._roles[name] == "evader"
                or state is None
                or not state.airborne
                or now_s - state.t_s > self._rooms.profile.safety.team_state_age_max_s
            ):
                continue
            ahead_s = now_s - state.t_s
            rows.append(
                (
                    state.position_ned_m[0] + state.velocity_ned_m_s[0] * ahead_s,
                    state.position_ned_m[1] + state.velocity_ned_m_s[1] * ahead_s,
                    self._rooms.limits.body_radius_m + CUT_OUT_MARGIN_M,
                )
            )
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    def note_silence(self, now_s: float) -> None:
        """An event when a vehicle that was heard falls silent, and when it is heard again."""
        for name in self._roster.poll():
            self._rooms.journal.event("warning", "network", f"{name} is on the fleet's network and not of the mission", peer=name)
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if state is None or state.phase == "done":
                continue
            age_s = now_s - state.t_s
            limit_s = self._silence_max_s(state, left=name in self._roster.left)
            if age_s > limit_s and name not in self._silent:
                self._silent.add(name)
                self._rooms.journal.event("warning", "teammate_lost", f"{name} silent for {age_s:.1f} s", peer=name)
            elif age_s <= limit_s and name in self._silent:
                self._silent.remove(name)
                self._rooms.journal.event("info", "teammate_back", f"{name} is heard again", peer=name)

    def _silence_max_s(self, state: SharedState, *, left: bool) -> float:
        """Age of the newest state of a mate from which on it counts as lost: by when it said that the next one is due."""
        period_s = max(state.due_s, self._rates.period_s)
        return max(LEFT_AGE_MAX_S, LEFT_PERIODS * period_s) if left else lost_age_s(1.0 / period_s)

    def tell(self, state: State, intent: Intent, now_s: float) -> None:
        """Send the own state and intent to those who are to have them now; to be called once a state period."""
        self._telling.tell(state, intent, now_s)

    def describe(
        self,
        now_s: float,
        state: VehicleState,
        *,
        airborne: bool,
        phase: str,
        decision: Decision | None,
        outcome: str | None,
        target: TargetTrack | None,
        clearance_m: float | None,
        guards: tuple[str, ...],
    ) -> tuple[State, Intent]:
        """This vehicle as it describes itself to the others; `decision` only while the planner flies."""
        rooms = self._rooms
        ages = [now_s - peer.state.t_s for peer in rooms.team.peers.values() if peer.state is not None]
        eta_s = None if decision is None else decision.diagnostics.get("eta_s")
        battery = rooms.autopilot.battery()
        goal = None if decision is None else decision.goal_ned_m
        motion = State(
            t_s=state.t_s,
            position_ned_m=_triple(state.position_ned_m),
            velocity_ned_m_s=_triple(state.velocity_ned_m_s),
            yaw_rad=state.yaw_rad,
            airborne=airborne,
            phase=phase,
            outcome=outcome,
        )
        intent = Intent(
            role=rooms.vehicle.role,
            mission=rooms.mission_digest,
            system_id=rooms.vehicle.system_id,
            mode=phase if decision is None else decision.mode,
            goal_ned_m=None if goal is None else _triple(goal),
            arrival_s=now_s + float(eta_s) if isinstance(eta_s, (int, float)) and math.isfinite(eta_s) else None,
            target_distance_m=None if target is None else _planar_distance(state, target),
            clearance_m=clearance_m,
            link_age_s=max(ages) if ages else None,
            guards=guards,
            battery_fraction=None if battery is None else battery.remaining_fraction,
        )
        return motion, intent


def _planar_distance(state: VehicleState, target: TargetTrack) -> float:
    offset = target.position_ned_m - state.position_ned_m
    return math.hypot(float(offset[0]), float(offset[1]))


def _triple(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
