"""Offboard: did the stream of setpoints hold, and who ended it?"""

from __future__ import annotations

import itertools

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog import modes
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.spans import Span, spans_of, total_s, within

NAME = "offboard"
LOSS_DEFAULT_S = 1.0
"""COM_OF_LOSS_T"""
GAP_WARN_S = 0.5


def examine(log: FlightLog) -> list[Finding]:
    flown = log.in_mode(modes.OFFBOARD)
    if not flown:
        return [Finding(NAME, Severity.OK, "not flown in offboard", "This log has no time in offboard mode.")]
    return [*_signal(log, flown), *_taken(log)] or [_held(log, flown)]


def _signal(log: FlightLog, flown: tuple[Span, ...]) -> list[Finding]:
    flags = log.topic("failsafe_flags")
    lost = None if flags is None else flags.column("offboard_control_signal_lost")
    when = [] if flags is None or lost is None else spans_of(flags.t_s, within(flags.t_s, flown) & (lost == 1))
    if when:
        text = f"PX4 missed the offboard signal for {total_s(when):.1f} s while in offboard mode."
        return [Finding(NAME, Severity.FAILURE, "offboard signal lost", text, when[0].from_s, when[-1].to_s)]
    gap = _longest_gap(log, flown)
    if gap is None:
        return [not_known(f"{NAME} stream", "offboard_control_mode was not logged")]
    limit_s = log.parameters.get("COM_OF_LOSS_T", LOSS_DEFAULT_S)
    if gap.length_s <= min(GAP_WARN_S, limit_s):
        return []
    severity = Severity.FAILURE if gap.length_s > limit_s else Severity.WARNING
    text = f"Nothing was received for {gap.length_s:.2f} s; PX4 acts after {limit_s:g} s (COM_OF_LOSS_T)."
    return [Finding(NAME, severity, "gap in the setpoints", text, gap.from_s, gap.to_s, {"gap_s": gap.length_s})]


def _longest_gap(log: FlightLog, flown: tuple[Span, ...]) -> Span | None:
    """As far as the log's own rate, 10 Hz as a rule, can tell."""
    topic = log.topic("offboard_control_mode")
    if topic is None:
        return None
    gaps = [Span(0.0, 0.0)]
    for span in flown:
        times = np.unique(np.clip(topic.t_s[within(topic.t_s, [span])], span.from_s, span.to_s))
        times = np.concatenate((times, [span.to_s])) if span.to_s >= log.end_s else times
        gaps += [Span(float(a), float(b)) for a, b in itertools.pairwise(times)]
    return max(gaps, key=lambda gap: gap.length_s)


def _taken(log: FlightLog) -> list[Finding]:
    """Left in the air although nobody asked for another mode."""
    status = log.topic("vehicle_status")
    wanted = None if status is None else status.column("nav_state_user_intention")
    state = None if status is None else status.column("nav_state")
    if status is None or wanted is None or state is None:
        return [not_known(f"{NAME} end", "the mode that the pilot asked for was not logged")]
    taken = spans_of(status.t_s, (wanted == modes.OFFBOARD) & (state != modes.OFFBOARD) & within(status.t_s, log.airborne()))
    if not taken:
        return []
    index = int(np.searchsorted(status.t_s, taken[0].from_s))
    name = modes.mode_name(int(state[index]))
    text = f"PX4 left offboard for {name} by itself, for {total_s(taken):.1f} s."
    return [Finding(NAME, Severity.FAILURE, "PX4 left offboard", text, taken[0].from_s, taken[-1].to_s, {"mode": name})]


def _held(log: FlightLog, flown: tuple[Span, ...]) -> Finding:
    gap = _longest_gap(log, flown)
    longest = "" if gap is None else f"; longest gap as logged {gap.length_s:.2f} s"
    text = f"{total_s(flown):.1f} s in offboard without a loss of the signal{longest}."
    return Finding(NAME, Severity.OK, "offboard held", text, flown[0].from_s, flown[-1].to_s)


ANALYSER = Analyser(NAME, ("vehicle_status", "failsafe_flags|offboard_control_mode"), examine)
