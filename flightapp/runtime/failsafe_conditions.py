"""Which conditions of the failsafe table hold now, read from the rooms and the control loop. Reads only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flightapp.fleet.admission import FUTURE_TOLERANCE_S
from flightapp.fleet.peers import Peer
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.rooms import Rooms
from flightapp.safety.api import Action, Demand
from flightapp.safety.failsafe.table import Condition
from flightapp.vehicle.autopilot import vouches_for_position

TARGET_AGE_MAX_S = 1.0
"""News of the evader that is older is a prediction."""


@dataclass(frozen=True, slots=True)
class Control:
    """What the executive knows of who has control. `is_own_mode`: the reported mode is one that the app asked for."""

    has_control: bool
    is_own_mode: bool
    is_pursuing: bool


def conditions_of(rooms: Rooms, loop: ControlLoop, control: Control, now_s: float) -> Iterator[Condition]:
    """Every condition that holds at `now_s`, operators' wishes excepted."""
    yield from _of_control(rooms, loop, control)
    if control.has_control:
        yield from _of_vehicle(rooms, loop, now_s)
    if control.is_pursuing:
        yield from _of_pursuit(rooms, loop, now_s)


def _of_control(rooms: Rooms, loop: ControlLoop, control: Control) -> Iterator[Condition]:
    armed = rooms.autopilot.status().armed
    if control.has_control and armed and not control.is_own_mode:
        yield Condition.PILOT_HAS_CONTROL
    if loop.in_offboard and not armed:
        yield Condition.DISARMED_IN_FLIGHT


def _of_vehicle(rooms: Rooms, loop: ControlLoop, now_s: float) -> Iterator[Condition]:
    if not rooms.autopilot.status().connected:
        yield Condition.LINK_LOST
    if loop.failure is not None:
        yield Condition.LOOP_FAILED
    if loop.guidance is not Guidance.NONE:
        if is_own_state_stale(rooms, now_s):
            yield Condition.STATE_STALE
        if not vouches_for_position(rooms.autopilot):
            yield Condition.GPS_BAD
        if loop.demand is not None:
            yield _of_demand(loop.demand)
    if rooms.journal.recording_error is not None:
        yield Condition.RECORDING_FAILED


def is_own_state_stale(rooms: Rooms, now_s: float) -> bool:
    """Whether where the vehicle is, is not known any more."""
    motion = rooms.autopilot.motion()
    return motion is None or now_s - motion.arrived_s > rooms.profile.safety.own_state_age_max_s


def _of_demand(demand: Demand) -> Condition:
    """The guards' demands: the fence's and the battery's."""
    if demand.guard == "contingency":
        return Condition.FENCE_BREACHED if demand.action is Action.HOLD else Condition.FENCE_OUTSIDE
    return Condition.BATTERY_LOW if demand.action <= Action.RETURN else Condition.BATTERY_CRITICAL


def _of_pursuit(rooms: Rooms, loop: ControlLoop, now_s: float) -> Iterator[Condition]:
    safety = rooms.profile.safety
    if loop.planner_failure is not None:
        yield Condition.PLANNER_FAILED
    if not loop.decision_is_finite:
        yield Condition.PLANNER_NOT_FINITE
    if loop.decision_latency_s > 1.0 / rooms.profile.control.rate_min_hz:
        yield Condition.PLANNER_OVERRUN
    if loop.perception is not None and (
        loop.perception.failure is not None or loop.obstacles_age_s(now_s) > safety.obstacles_age_max_s
    ):
        yield Condition.CAMERA_LOST
    if rooms.vehicle.role == "pursuer" and (loop.target is None or loop.target.age_s > TARGET_AGE_MAX_S):
        yield Condition.TARGET_LOST
    peers = list(rooms.team.peers.values())
    silent = {name for name, peer in rooms.team.peers.items() if _silence_s(peer, now_s) > safety.team_state_age_max_s}
    if any(rooms.mission.vehicle(name).role == "pursuer" for name in silent):
        yield Condition.TEAMMATE_SILENT
    if peers and len(silent) == len(peers):
        yield Condition.FLEET_SILENT
    if any(peer.ahead_s > FUTURE_TOLERANCE_S for peer in peers):
        yield Condition.CLOCKS_DISAGREE


def _silence_s(peer: Peer, now_s: float) -> float:
    """Since the last state of a vehicle that still flies; one that has said that it is done may be silent."""
    state = peer.state
    if state is None or state.phase == "done":
        return 0.0
    return now_s - state.t_s
