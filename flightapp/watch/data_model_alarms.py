"""What a person who watches the fleet must not miss, in one sentence each; the worst first."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from flightapp.fleet.team import COMMAND_AGE_MAX_S
from flightapp.watch.data_model_leader import Leadership
from flightapp.watch.data_model_rows import SHAPING, Link, Row
from flightapp.watch.data_model_thresholds import Thresholds

BAD_OUTCOMES = ("aborted", "fault", "escaped")
ENDING = {"return": "returns", "land": "lands"}


class Level(IntEnum):
    """The stricter the greater."""

    WARNING = 1
    ALARM = 2


@dataclass(frozen=True, slots=True)
class Alarm:
    """`vehicle` None: of the fleet."""

    level: Level
    vehicle: str | None
    text: str


def alarms_of(rows: tuple[Row, ...], leadership: Leadership, digest: str, thresholds: Thresholds) -> tuple[Alarm, ...]:
    """`digest`: of the mission file that the watcher was given."""
    if all(row.link is Link.NEVER for row in rows):
        return (Alarm(Level.ALARM, None, "no vehicle is heard: is it on, and its endpoint among those connected to?"),)
    alarms = [alarm for row in rows for alarm in _of_vehicle(row, digest, thresholds)]
    alarms += _of_links(rows, thresholds) + _of_leadership(leadership)
    return tuple(sorted(alarms, key=lambda alarm: -alarm.level))


def _of_vehicle(row: Row, digest: str, thresholds: Thresholds) -> list[Alarm]:
    state = row.state
    if state is None:
        return [Alarm(Level.WARNING, row.name, f"{row.name} was not heard yet")]
    alarms = []
    if row.link is Link.LOST and row.age_s is not None:
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name} silent for {row.age_s:.0f} s, last {state.phase}"))
    elif row.age_s is not None and (behind_s := state.sent_s - state.t_s) > thresholds.lost_age_s:
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name} has no own position for {behind_s:.1f} s"))
    if state.mission != digest:
        alarms.append(Alarm(Level.WARNING, row.name, f"{row.name} flies another version of the mission file"))
    if row.link in (Link.FRESH, Link.LATE):
        alarms += _of_flight(row, thresholds) + _of_clock(row, thresholds)
    return alarms


def _of_flight(row: Row, thresholds: Thresholds) -> list[Alarm]:
    state, alarms = row.state, []
    assert state is not None
    if state.phase == "released":
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name} is no longer flown by this software: pilot or autopilot has it"))
    if state.outcome in BAD_OUTCOMES:
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name}: {state.outcome}, now in phase {state.phase}"))
    elif state.outcome is None and state.phase in ENDING:
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name} {ENDING[state.phase]} before the pursuit has ended"))
    if state.airborne and state.clearance_m is not None and state.clearance_m < thresholds.clearance_min_m:
        alarms.append(Alarm(Level.ALARM, row.name, f"{row.name} is {state.clearance_m:.1f} m from an obstacle"))
    if (left := state.battery_fraction) is not None and left <= thresholds.battery_reserve_fraction:
        level = Level.ALARM if left <= thresholds.battery_critical_fraction else Level.WARNING
        alarms.append(Alarm(level, row.name, f"{row.name} has {left:.0%} of its battery left"))
    for guard, acting_s in row.guards:
        if acting_s >= thresholds.guard_long_s and guard not in SHAPING:
            alarms.append(Alarm(Level.WARNING, row.name, f"{row.name}: guard {guard} has acted for {acting_s:.0f} s"))
    return alarms


def _of_clock(row: Row, thresholds: Thresholds) -> list[Alarm]:
    if row.offset is None or abs(row.offset.ahead_s) <= thresholds.clock_ahead_max_s:
        return []
    ahead_s = row.offset.ahead_s
    text = f"the clock of {row.name} is {abs(ahead_s):.1f} s {'ahead of' if ahead_s > 0.0 else 'behind'} this machine's"
    if abs(ahead_s) > COMMAND_AGE_MAX_S:
        return [Alarm(Level.ALARM, row.name, f"{text}: it will refuse hold and resume")]
    return [Alarm(Level.WARNING, row.name, text)]


def _of_links(rows: tuple[Row, ...], thresholds: Thresholds) -> list[Alarm]:
    """Who does not hear a teammate that is heard here: the sides of a link can fail one by one."""
    if any(row.link is not Link.FRESH or row.state is None or row.state.phase == "done" for row in rows):
        return []
    return [
        Alarm(Level.ALARM, row.name, f"{row.name} has not heard one of the others for {row.state.link_age_s:.1f} s")
        for row in rows
        if row.state is not None
        and row.state.link_age_s is not None
        and row.state.link_age_s > thresholds.lost_age_of_s(row.state)  # What it tells slowly, it is told slowly: one team.
    ]


def _of_leadership(leadership: Leadership) -> list[Alarm]:
    if len(leadership.claimants) > 1:
        return [Alarm(Level.WARNING, None, f"several say that they lead: {', '.join(leadership.claimants)}")]
    if leadership.is_voted and leadership.leader is None:
        return [Alarm(Level.WARNING, None, f"nobody leads (term {leadership.term}): the pursuers keep what was decided last")]
    return []
