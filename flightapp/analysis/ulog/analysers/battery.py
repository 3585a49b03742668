"""Battery: is it measured at all, does it sag, was it flown empty?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Mask, Span, spans_of, within
from flightapp.core.types import Array

NAME = "battery"
ABSENT_V = 1.0
"""No battery that flies has less: nothing is connected to the sensor."""
CELL_LOW_V, CELL_EMPTY_V = 3.3, 3.0
"""Of a lithium cell under load: time to land, and damage with loss of thrust."""
LASTING_S = 1.0
"""Shorter sags are the motors' transients."""
_WARNINGS = {1: "low", 2: "critical", 3: "emergency", 4: "failed"}


def examine(log: FlightLog) -> list[Finding]:
    topic = log.topic("battery_status")
    voltage = None if topic is None else topic.column("voltage_v")
    flown = log.armed() or (Span(0.0, log.end_s),)
    inside = None if topic is None else within(topic.t_s, flown)
    if topic is None or voltage is None or inside is None or not inside.any():
        return [not_known(NAME, "no voltage was logged while armed")]
    if float(np.nanmax(voltage[inside])) < ABSENT_V:
        return [_not_measured(log, topic, voltage[inside], flown), *_settings(log)]
    found = [*_sag(topic, voltage, inside), *_remaining(log, topic, inside), *_warned(topic, inside), *_settings(log)]
    return [*found, _as_measured(topic, voltage, inside)]


def _not_measured(log: FlightLog, topic: Topic, voltage: Array, flown: tuple[Span, ...]) -> Finding:
    cells = topic.column("cell_count")
    named = "" if cells is None else f" although a pack of {cells[0]:.0f} cells is configured"
    power = log.topic("system_power")
    rail = None if power is None else power.column("voltage5v_v")
    supply = (
        "" if rail is None else f" The autopilot itself was supplied ({rail.min():.2f} to {rail.max():.2f} V on its 5 V rail)."
    )
    return Finding(
        NAME,
        Severity.FAILURE,
        "flown without a measured battery",
        f"The battery sensor reads {voltage.min():.2f} to {voltage.max():.2f} V for the whole flight{named}: no power module "
        f"is connected, or it is not set up. It looks like a brown-out but is none: a low "
        f"battery could not be noticed, and no battery failsafe could act.{supply}",
        flown[0].from_s,
        flown[-1].to_s,
        {"voltage_min_v": float(voltage.min()), "voltage_max_v": float(voltage.max())},
    )


def _sag(topic: Topic, voltage: Array, inside: Mask) -> list[Finding]:
    cells = topic.column("cell_count")
    if cells is None or cells[0] < 1:
        return [not_known(f"{NAME} cells", "the number of cells is not configured")]
    cell_v = voltage / cells[0]
    for severity, limit_v, word in ((Severity.FAILURE, CELL_EMPTY_V, "brown-out"), (Severity.WARNING, CELL_LOW_V, "sag")):
        low = spans_of(topic.t_s, inside & (cell_v < limit_v), least_s=LASTING_S)
        if low:
            least_v = float(cell_v[inside].min())
            text = f"The voltage fell to {least_v:.2f} V a cell, below {limit_v:g} V for {sum(s.length_s for s in low):.1f} s."
            evidence = {"cell_voltage_min_v": least_v, "voltage_min_v": float(voltage[inside].min()), "limit_v": limit_v}
            return [Finding(NAME, severity, f"battery {word}", text, low[0].from_s, low[-1].to_s, evidence)]
    return []


def _remaining(log: FlightLog, topic: Topic, inside: Mask) -> list[Finding]:
    remaining = topic.column("remaining")
    if remaining is None:
        return [not_known(f"{NAME} charge", "the remaining charge was not logged")]
    least = float(remaining[inside].min())
    for severity, name, word in ((Severity.FAILURE, "BAT_CRIT_THR", "critical"), (Severity.WARNING, "BAT_LOW_THR", "low")):
        limit = log.parameters.get(name, 0.0)
        if 0.0 <= least < limit:
            low = spans_of(topic.t_s, inside & (remaining < limit))
            text = f"The remaining charge fell to {least:.0%}, below {limit:.0%} ({name})."
            return [
                Finding(NAME, severity, f"charge {word}", text, low[0].from_s, low[-1].to_s, {"remaining_fraction_min": least})
            ]
    return []


def _warned(topic: Topic, inside: Mask) -> list[Finding]:
    warning = topic.column("warning")
    if warning is None or not warning[inside].any():
        return []
    level = int(warning[inside].max())
    when = spans_of(topic.t_s, inside & (warning > 0))
    severity = Severity.FAILURE if level >= 2 else Severity.WARNING
    text = f"PX4 called the battery {_WARNINGS.get(level, f'state {level}')} in flight."
    return [Finding(NAME, severity, "PX4's battery warning", text, when[0].from_s, when[-1].to_s, {"warning": float(level)})]


def _settings(log: FlightLog) -> list[Finding]:
    """A failsafe that is switched off is worth a word, whatever the battery did."""
    low, action = log.parameters.get("BAT_LOW_THR"), log.parameters.get("COM_LOW_BAT_ACT")
    if low == 0.0:
        return [Finding(NAME, Severity.NOTE, "battery warnings are off", "BAT_LOW_THR is 0: PX4 never warns of a low battery.")]
    if action == 0.0:
        text = "COM_LOW_BAT_ACT is 0: PX4 only warns of a low battery, it neither returns nor lands."
        return [Finding(NAME, Severity.NOTE, "no battery failsafe", text)]
    return []


def _as_measured(topic: Topic, voltage: Array, inside: Mask) -> Finding:
    remaining = topic.column("remaining")
    last = "" if remaining is None else f", {remaining[inside][-1]:.0%} left at the end"
    text = f"{voltage[inside].min():.2f} to {voltage[inside].max():.2f} V while armed{last}."
    return Finding(NAME, Severity.OK, "as measured", text, evidence={"voltage_min_v": float(voltage[inside].min())})


ANALYSER = Analyser(NAME, ("battery_status",), examine)
