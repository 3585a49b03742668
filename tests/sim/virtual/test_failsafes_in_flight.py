"""Every row of the failsafe table, flown: broken in the terminal phase beside a tree, felt, recorded, answered, no harm done."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from flightapp.config.profile import load_profile
from flightapp.core.types import Decision, Observation
from flightapp.safety.failsafe.table import TABLE, By, Condition, Row, State
from flightapp.sim.autopilot_modes import Mode
from tests.sim.virtual.in_flight import SIM, Flight, clearance_m

MARGIN_S = 0.15
"""From a condition to the recorded state: a control period, a look of the executive, a step of the clock."""
AT_REST_M_S = 0.35
REST_AFTER_S = 3.0
MODE_AFTER_S = 4.5
"""From RETURN or LAND to the autopilot's mode: braking, a heartbeat, the command."""
OVERRUN_S = 0.06


@dataclass(frozen=True, slots=True)
class Injection:
    """How a condition comes about. `recognised_s`: between which times after the injection the app can know."""

    breaking: Callable[[Flight], None]
    felt: Callable[[Flight], bool]
    recognised_s: tuple[float, float] = (0.0, 0.0)


def play_dead(flight: Flight) -> None:
    flight.one.kill()


def break_the_tick(flight: Flight) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("the journal broke")

    flight.one.rooms.journal.own = fail  # type: ignore[assignment, method-assign]


def raise_in_planner(flight: Flight) -> None:
    def fail(observation: Observation, decision: Decision) -> Decision:
        raise ZeroDivisionError("the strategy broke")

    flight.planner.fault = fail


def give_nan(flight: Flight) -> None:
    flight.planner.fault = lambda _, decision: replace(decision, velocity_ned_m_s=np.full(3, np.nan), yaw_rad=math.nan)


def overrun(flight: Flight) -> None:
    def late(_: Observation, decision: Decision) -> Decision:
        flight.fleet.spend(OVERRUN_S)
        return decision

    flight.planner.fault = late


def fill_the_disk(flight: Flight) -> None:
    """The recorder's thread lives in real time: wait until it has met the end of its disk."""
    flight.disk.is_full = True
    deadline_s = time.monotonic() + 20.0
    while flight.one.recorder.error is None and time.monotonic() < deadline_s:
        time.sleep(0.01)


def silence(*names: str) -> Callable[[Flight], None]:
    def act(flight: Flight) -> None:
        for played in (flight.evader, flight.teammate):
            played.is_silent |= played.name in names

    return act


def put_clock_ahead(flight: Flight) -> None:
    flight.evader.clock_ahead_s = 0.5


def switch_off_camera(flight: Flight) -> None:
    assert flight.one.camera is not None
    flight.one.camera.fault = "off"


def commanded(action: str) -> Injection:
    return Injection(lambda flight: flight.command(action), Flight.was_accepted)


def broken(target: str, verb: str, early_s: float = 0.0, late_s: float = 0.0, **fields: object) -> Injection:
    return Injection(lambda flight: flight.fault(target, verb, **fields), Flight.fault_was_felt, (early_s, late_s))


INJECTIONS: dict[Condition, Injection] = {
    Condition.PILOT_HAS_CONTROL: Injection(
        lambda flight: flight.one.station.core.pilot_takes(Mode.POSCTL), lambda flight: flight.one.station.core.piloted
    ),
    Condition.DISARMED_IN_FLIGHT: Injection(
        lambda flight: flight.one.station.core.terminate("Kill switch"), lambda flight: not flight.one.station.core.armed
    ),
    # PX4's estimator gives in to a position that disagrees with it after EKF2_NOAID_TOUT (5 s); the guard confirms for 0.2 s.
    Condition.FENCE_OUTSIDE: broken("gps", "wrong", 5.0, 5.6, offset_m=30.0),
    Condition.FENCE_BREACHED: broken("gps", "wrong", 5.0, 5.6, offset_m=8.0),
    Condition.OPERATOR_ABORT: commanded("abort"),
    Condition.OPERATOR_LAND: commanded("land"),
    Condition.OPERATOR_RETURN: commanded("rtl"),
    Condition.OPERATOR_HOLD: commanded("hold"),
    Condition.APP_DEAD: Injection(play_dead, lambda flight: flight.moments[-1].t_s - flight.one.autopilot.sent[-1][0] > 1.0),
    Condition.LOOP_HUNG: Injection(lambda flight: flight.one.hang(), lambda flight: "deadman" in flight.one.error),
    Condition.LOOP_FAILED: Injection(break_the_tick, lambda flight: "journal broke" in (flight.one.loop.failure or "")),
    # The last heartbeat may be a second old when the link breaks.
    Condition.LINK_LOST: broken("link", "off", 2.0, 3.0),
    Condition.STATE_STALE: broken("telemetry", "off", 0.25, 0.35),
    Condition.GPS_BAD: broken("gps", "off", 0.0, 0.25),  # The receiver tells of itself five times a second.
    # The autopilot tells its charge once a second, the guard confirms for 3 s.
    Condition.BATTERY_CRITICAL: broken("battery", "wrong", 3.0, 4.1, remaining=0.09),
    Condition.BATTERY_LOW: broken("battery", "wrong", 3.0, 4.1, remaining=0.19),
    Condition.CAMERA_LOST: Injection(
        switch_off_camera, lambda flight: flight.one.loop.obstacles_age_s(flight.now_s) > 0.5, (0.45, 0.55)
    ),
    Condition.PLANNER_FAILED: Injection(raise_in_planner, lambda flight: flight.one.loop.planner_failure is not None),
    Condition.PLANNER_NOT_FINITE: Injection(give_nan, lambda flight: not flight.one.loop.decision_is_finite),
    Condition.PLANNER_OVERRUN: Injection(
        overrun, lambda flight: flight.one.loop.decision_latency_s > 0.9 * OVERRUN_S, (0.0, 0.2)
    ),
    Condition.TARGET_LOST: Injection(
        silence("e1"), lambda flight: flight.one.loop.target is None or flight.one.loop.target.age_s > 20.0, (0.9, 1.1)
    ),
    Condition.FLEET_SILENT: Injection(
        lambda flight: flight.fleet.network.cut_off.add("p1"), lambda flight: "p1" in flight.fleet.network.cut_off, (0.9, 1.1)
    ),
    Condition.TEAMMATE_SILENT: Injection(silence("p2"), lambda flight: flight.now_s - (state_s(flight, "p2")) > 1.0, (0.9, 1.1)),
    Condition.RECORDING_FAILED: Injection(fill_the_disk, lambda flight: flight.one.recorder.error is not None),
    Condition.CLOCKS_DISAGREE: Injection(
        put_clock_ahead, lambda flight: flight.one.rooms.team.peers["e1"].rejected > 0, (0.0, 0.1)
    ),
}
"""One for each condition: a condition without one fails its test."""
UNRECORDED = (Condition.APP_DEAD, Condition.LOOP_HUNG)
"""Nobody is left who could record."""
ENDS = {State.RETURN: Mode.RTL, State.LAND: Mode.LAND}
OFFBOARD_LOSS_S = 1.0
DEADMAN_S = 0.45


def state_s(flight: Flight, name: str) -> float:
    state = flight.one.rooms.team.peers[name].state
    assert state is not None
    return state.t_s


_FLOWN: dict[Condition, Flight] = {}


@pytest.fixture
def flight(row: Row, tmp_path_factory: pytest.TempPathFactory) -> Flight:
    """The flight of the row's condition: flown once, however many rows it has."""
    condition = row.condition
    if condition not in _FLOWN:
        last = [other for other in TABLE if other.condition is condition][-1]
        injection = INJECTIONS[condition]
        watched_s = injection.recognised_s[1] + last.delay_s + MODE_AFTER_S + 1.0
        flight = Flight(injection.breaking, watched_s, until=comes_to(last))
        _FLOWN[condition] = flight.fly(tmp_path_factory.mktemp(condition))
    return _FLOWN[condition]


def comes_to(row: Row) -> Callable[[Flight], bool]:
    """Whether the flight has come to the mode in which it ends."""
    mode = ENDS.get(row.action) if row.by is By.APP else None
    return lambda flight: flight.one.station.core.mode is mode


def test_every_condition_can_be_brought_about() -> None:
    assert set(INJECTIONS) == set(Condition)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row.condition}-{row.action.name}")
def test_the_row_is_flown(row: Row, flight: Flight) -> None:
    assert math.isfinite(flight.broken_s), "the worst moment never came"
    assert INJECTIONS[row.condition].felt(flight)
    acted_s = flight.broken_s
    if row.condition not in UNRECORDED:
        acted_s = recorded_s(row, flight)
        early_s, late_s = (flight.broken_s + row.delay_s + time_s for time_s in INJECTIONS[row.condition].recognised_s)
        assert early_s - 0.01 <= acted_s <= late_s + MARGIN_S
    assert_done(row, flight, acted_s)
    assert_no_harm(row, flight)


def recorded_s(row: Row, flight: Flight) -> float:
    """When the row's event was recorded; said in the log where nothing can be recorded any more."""
    if row.condition is Condition.RECORDING_FAILED:
        told = f"failsafe: {row.action.name} because of {row.condition}"
        return next(t_s for t_s, line in flight.lines if line.startswith(told))
    for event in flight.events("failsafe"):
        data = event["data"]
        if (data["state"], data.get("condition")) == (row.action.name, row.condition):
            assert data["by"] == row.by
            return float(event["t_s"])
    texts = [event["text"] for event in flight.events("failsafe")]
    raise AssertionError(f"no event of {row.condition} {row.action.name}: {texts}")


def assert_done(row: Row, flight: Flight, acted_s: float) -> None:
    """What the vehicle does then."""
    if row.by is not By.APP:
        setpoints_end_s = {Condition.LOOP_HUNG: DEADMAN_S}.get(row.condition, 0.0)
        assert flight.mode_since_s(Mode.LAND, flight.broken_s) <= flight.broken_s + setpoints_end_s + OFFBOARD_LOSS_S + 0.1
    elif row.action is State.DEGRADED:
        assert flight.moment_at(acted_s + 0.1).phase == "pursue"
    elif row.action is State.HOLD:
        until_s = next_row_s(row, flight)
        for moment in flight.since(acted_s + REST_AFTER_S):
            assert moment.t_s > until_s or moment.speed_m_s < hold_speed_m_s(row)
    elif row.action is State.PILOT:
        assert not [t_s for t_s, _ in flight.one.autopilot.sent if t_s > acted_s]
        assert not [t_s for t_s, _ in flight.one.autopilot.commanded if t_s > flight.broken_s]
    elif row.action in ENDS:
        mode = ENDS[row.action]
        assert flight.mode_since_s(mode, acted_s) <= acted_s + MODE_AFTER_S
        assert flight.moments[-1].mode is mode


def hold_speed_m_s(row: Row) -> float:
    """A vehicle beyond the fence is pushed back meanwhile."""
    return 1.2 if row.condition is Condition.FENCE_BREACHED else AT_REST_M_S


def next_row_s(row: Row, flight: Flight) -> float:
    later = [other for other in TABLE if other.condition is row.condition and other.delay_s > row.delay_s]
    return recorded_s(later[0], flight) if later else math.inf


def assert_no_harm(row: Row, flight: Flight) -> None:
    limits = load_profile(SIM).limits
    volume = flight.fleet.mission.flight_volume
    reach = 12.0 + volume.contingency_m
    for moment in flight.moments:
        north, east, down = moment.position_ned_m
        assert max(abs(north), abs(east)) < reach
        assert -down < volume.height_max_m + volume.contingency_height_m
        if row.condition is not Condition.DISARMED_IN_FLIGHT:  # It falls.
            assert clearance_m(moment) > 0.0
        assert math.dist(moment.position_ned_m[:2], flight.teammate.position_ned_m[:2]) > 1.5
    for _, setpoint in flight.one.autopilot.sent:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        assert math.hypot(north, east) <= limits.speed_max_m_s + 1e-6
        assert abs(down) <= limits.climb_rate_max_m_s + 1e-6
