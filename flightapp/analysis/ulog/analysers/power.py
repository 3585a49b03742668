"""The autopilot's own supply: a sagging 5 V rail is what restarts it in the air."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.spans import Span, spans_of, within

NAME = "power"
RAIL_LOW_V = 4.7
"""PX4 1.16 refuses to arm below (check_avionics_power_low), unless CBRK_SUPPLY_CHK turns that check off."""
RAIL_FAILING_V = 4.5
"""PX4's limit up to 1.15; sensors and receiver begin to fail."""
RAIL_HIGH_V = 5.4
CHECK_OFF = 894281.0


def examine(log: FlightLog) -> list[Finding]:
    topic = log.topic("system_power")
    rail = None if topic is None else topic.column("voltage5v_v")
    flown = log.armed() or (Span(0.0, log.end_s),)
    inside = None if topic is None else within(topic.t_s, flown)
    if topic is None or rail is None or inside is None or not inside.any():
        return [not_known(NAME, "the 5 V rail was not logged while armed")]
    least, most = float(rail[inside].min()), float(rail[inside].max())
    evidence = {"rail_min_v": least, "rail_max_v": most}
    off = " The check that would have kept it on the ground is off (CBRK_SUPPLY_CHK)."
    off = off if log.parameters.get("CBRK_SUPPLY_CHK") == CHECK_OFF else ""
    found = []
    if least < RAIL_LOW_V:
        low = spans_of(topic.t_s, inside & (rail < RAIL_LOW_V))
        severity = Severity.FAILURE if least < RAIL_FAILING_V else Severity.WARNING
        text = f"The autopilot's 5 V rail was at {least:.2f} to {most:.2f} V, below {RAIL_LOW_V:g} V: near a brown-out.{off}"
        found.append(Finding(NAME, severity, "5 V rail low", text, low[0].from_s, low[-1].to_s, evidence))
    elif most > RAIL_HIGH_V:
        text = f"The autopilot's 5 V rail rose to {most:.2f} V, above {RAIL_HIGH_V:g} V."
        found.append(Finding(NAME, Severity.WARNING, "5 V rail high", text, evidence=evidence))
    else:
        text = f"The autopilot's 5 V rail stayed between {least:.2f} and {most:.2f} V: it did not brown out."
        found.append(Finding(NAME, Severity.OK, "5 V rail steady", text, evidence=evidence))
    brick, usb = topic.column("brick_valid"), topic.column("usb_connected")
    if brick is not None and usb is not None:
        alone = spans_of(topic.t_s, within(topic.t_s, log.airborne()) & (brick == 0) & (usb == 1))
        if alone:
            text = f"No power module was valid: the autopilot flew on its USB supply alone, which has no reserve.{off}"
            found.append(Finding(NAME, Severity.WARNING, "flown on USB power", text, alone[0].from_s, alone[-1].to_s))
    return found


ANALYSER = Analyser(NAME, ("system_power",), examine)
