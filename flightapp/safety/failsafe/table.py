"""The failsafe table: condition, action, delay, who acts, may the pilot override. Read it in one sitting; change it with care.

A condition has one row, or several that escalate. A row takes effect when its condition has lasted `delay_s`; of the rows in
effect the most severe wins (see `machine`). The order of `State` is the order of severity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum


class State(IntEnum):
    """What the vehicle does, by rising severity."""

    NORMAL = 0
    """The mission."""
    DEGRADED = 1
    """The mission goes on, the supervisor's guards keep more room or less speed."""
    HOLD = 2
    """Brake under the guards and stay."""
    RETURN = 3
    """Brake, then the autopilot's return mode."""
    LAND = 4
    """Brake, then the autopilot's land mode."""
    TERMINATE = 5
    """The autopilot's flight termination: motors off, parachute where there is one."""
    PILOT = 6
    """A person or the autopilot's own failsafe has control: no setpoint, no mode change."""


class By(StrEnum):
    """Who performs an action."""

    APP = "app"
    DEADMAN = "deadman"
    """The parent process kills the vehicle process, so that setpoints end and the autopilot's own failsafe follows."""
    AUTOPILOT = "autopilot"
    """PX4's own failsafe, as its parameters say; preflight checks them."""


class Condition(StrEnum):
    """Something that is wrong, or that a person wants; `HOW` says how each is recognised."""

    PILOT_HAS_CONTROL = "pilot_has_control"
    DISARMED_IN_FLIGHT = "disarmed_in_flight"
    FENCE_OUTSIDE = "fence_outside"
    FENCE_BREACHED = "fence_breached"
    OPERATOR_ABORT = "operator_abort"
    OPERATOR_LAND = "operator_land"
    OPERATOR_RETURN = "operator_return"
    OPERATOR_HOLD = "operator_hold"
    APP_DEAD = "app_dead"
    LOOP_HUNG = "loop_hung"
    LOOP_FAILED = "loop_failed"
    LINK_LOST = "link_lost"
    STATE_STALE = "state_stale"
    GPS_BAD = "gps_bad"
    BATTERY_CRITICAL = "battery_critical"
    BATTERY_LOW = "battery_low"
    CAMERA_LOST = "camera_lost"
    PLANNER_FAILED = "planner_failed"
    PLANNER_NOT_FINITE = "planner_not_finite"
    PLANNER_OVERRUN = "planner_overrun"
    TARGET_LOST = "target_lost"
    FLEET_SILENT = "fleet_silent"
    TEAMMATE_SILENT = "teammate_silent"
    RECORDING_FAILED = "recording_failed"
    CLOCKS_DISAGREE = "clocks_disagree"


HOW: dict[Condition, str] = {
    Condition.PILOT_HAS_CONTROL: "armed, in a flight mode that the app did not ask for",
    Condition.DISARMED_IN_FLIGHT: "disarmed while in OFFBOARD",
    Condition.FENCE_OUTSIDE: "outside the contingency volume",
    Condition.FENCE_BREACHED: "outside the flight volume, inside the contingency volume",
    Condition.OPERATOR_ABORT: "command 'abort' of an operator",
    Condition.OPERATOR_LAND: "command 'land' of an operator, or a termination signal",
    Condition.OPERATOR_RETURN: "command 'rtl' of an operator",
    Condition.OPERATOR_HOLD: "command 'hold' of an operator, until 'resume'",
    Condition.APP_DEAD: "the vehicle process has ended or was killed",
    Condition.LOOP_HUNG: "no heartbeat of the control loop within control.deadman_timeout_s",
    Condition.LOOP_FAILED: "an exception in a tick of the control loop",
    Condition.LINK_LOST: "no heartbeat of the autopilot for 3 s",
    Condition.STATE_STALE: "own state older than safety.own_state_age_max_s",
    Condition.GPS_BAD: "no satellite fix, or the autopilot reports its position as bad",
    Condition.BATTERY_CRITICAL: "charge below what a landing needs",
    Condition.BATTERY_LOW: "charge or time left below what the way home and its reserve need",
    Condition.CAMERA_LOST: "no obstacle picture within safety.obstacles_age_max_s",
    Condition.PLANNER_FAILED: "the planner raised an exception",
    Condition.PLANNER_NOT_FINITE: "the planner's decision contains a number that is none",
    Condition.PLANNER_OVERRUN: "a decision takes longer than a control period",
    Condition.TARGET_LOST: "no news of the evader",
    Condition.FLEET_SILENT: "no other vehicle of the fleet is heard",
    Condition.TEAMMATE_SILENT: "a teammate is not heard within safety.team_state_age_max_s",
    Condition.RECORDING_FAILED: "the recorder cannot write: disk full or gone",
    Condition.CLOCKS_DISAGREE: "a teammate's states are stamped in the future",
}


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table."""

    condition: Condition
    delay_s: float
    """The condition must have lasted this long."""
    action: State
    why: str
    by: By = By.APP
    pilot_may_override: bool = True


PERSONS = frozenset(
    (
        Condition.PILOT_HAS_CONTROL,
        Condition.OPERATOR_ABORT,
        Condition.OPERATOR_LAND,
        Condition.OPERATOR_RETURN,
        Condition.OPERATOR_HOLD,
    )
)
"""What a person wants, as against what is broken."""
WISHES = PERSONS - {Condition.PILOT_HAS_CONTROL, Condition.OPERATOR_HOLD}
"""Wishes for which the app takes control again from a pilot who took it before."""

TABLE: tuple[Row, ...] = (
    Row(Condition.PILOT_HAS_CONTROL, 0.0, State.PILOT, "a person is never fought"),
    Row(Condition.DISARMED_IN_FLIGHT, 0.0, State.PILOT, "nothing that the app sends can help"),
    Row(Condition.FENCE_OUTSIDE, 0.0, State.LAND, "every metre further is outside the cleared volume"),
    Row(Condition.FENCE_BREACHED, 0.0, State.HOLD, "the fence guard pushes back into the flight volume"),
    Row(Condition.OPERATOR_ABORT, 0.0, State.LAND, "a person wants every vehicle down"),
    Row(Condition.OPERATOR_LAND, 0.0, State.LAND, "a person wants this vehicle down"),
    Row(Condition.OPERATOR_RETURN, 0.0, State.RETURN, "a person wants this vehicle home"),
    Row(Condition.OPERATOR_HOLD, 0.0, State.HOLD, "a person wants to look first"),
    Row(Condition.APP_DEAD, 0.0, State.LAND, "setpoints end; COM_OF_LOSS_T, then COM_OBL_RC_ACT", By.AUTOPILOT),
    Row(Condition.LOOP_HUNG, 0.0, State.LAND, "MAVSDK would repeat the last setpoint for ever", By.DEADMAN),
    Row(Condition.LOOP_FAILED, 0.0, State.LAND, "the app does not know what else is broken"),
    Row(Condition.LINK_LOST, 0.0, State.LAND, "no command arrives: end the setpoints, COM_OBL_RC_ACT follows", By.AUTOPILOT),
    Row(Condition.STATE_STALE, 0.0, State.HOLD, "without an own state no guard can judge: zero velocity"),
    Row(Condition.STATE_STALE, 3.0, State.LAND, "a vehicle that does not know where it is must come down"),
    Row(Condition.GPS_BAD, 0.0, State.HOLD, "velocity control drifts with a bad position"),
    Row(Condition.GPS_BAD, 2.0, State.LAND, "the autopilot's return would fly by the same bad position"),
    Row(Condition.BATTERY_CRITICAL, 0.0, State.LAND, "the way home is longer than the charge lasts"),
    Row(Condition.BATTERY_LOW, 1.0, State.RETURN, "enough is left for the way home and no more"),
    Row(Condition.CAMERA_LOST, 0.0, State.DEGRADED, "guards: slow at once, standstill after three times the age"),
    Row(Condition.CAMERA_LOST, 1.5, State.HOLD, "the way ahead is not known any more"),
    Row(Condition.CAMERA_LOST, 10.0, State.RETURN, "it does not come back; the return height is above the obstacles"),
    Row(Condition.PLANNER_FAILED, 0.0, State.RETURN, "no strategy is left; the way home needs none"),
    Row(Condition.PLANNER_NOT_FINITE, 0.0, State.HOLD, "the finite guard brakes; the next decision may be good again"),
    Row(Condition.PLANNER_NOT_FINITE, 0.5, State.RETURN, "the planner does not recover"),
    Row(Condition.PLANNER_OVERRUN, 0.0, State.DEGRADED, "one late decision is flown at the last setpoint"),
    Row(Condition.PLANNER_OVERRUN, 1.0, State.RETURN, "a planner that is always late flies on old pictures"),
    Row(Condition.TARGET_LOST, 1.0, State.DEGRADED, "the planner searches along the prediction"),
    Row(Condition.TARGET_LOST, 30.0, State.RETURN, "there is nothing left to pursue"),
    Row(Condition.TEAMMATE_SILENT, 0.0, State.DEGRADED, "its separation grows with the age of its last state"),
    Row(Condition.FLEET_SILENT, 2.0, State.HOLD, "no operator and no teammate can reach this vehicle"),
    Row(Condition.FLEET_SILENT, 10.0, State.RETURN, "the network does not come back"),
    Row(Condition.RECORDING_FAILED, 0.0, State.DEGRADED, "the flight is safe, but its record is not"),
    Row(Condition.RECORDING_FAILED, 10.0, State.RETURN, "a test flight without a record is not worth its risk"),
    Row(Condition.CLOCKS_DISAGREE, 0.0, State.HOLD, "the ages of shared states are wrong"),
    Row(Condition.CLOCKS_DISAGREE, 5.0, State.RETURN, "they do not agree again"),
)


def table_for(outside_action: State) -> tuple[Row, ...]:
    """The table with what the mission does outside the contingency volume.

    A pilot who has taken over is not terminated by this app either: outside the fence PX4's own geofence (GF_ACTION) judges them.
    """
    return tuple(replace(row, action=outside_action) if row.condition is Condition.FENCE_OUTSIDE else row for row in TABLE)
