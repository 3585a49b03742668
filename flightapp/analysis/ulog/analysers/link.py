"""The autopilot's links: ground station or companion over MAVLink, and the pilot's transmitter."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.spans import spans_of, total_s, within

NAME = "link"
LOSS_MAX = 5.0
"""Per cent of the messages that never came."""


def examine(log: FlightLog) -> list[Finding]:
    airborne = log.airborne() or log.armed()
    status = log.topic("vehicle_status")
    lost = None if status is None else status.column("gcs_connection_lost")
    if status is None or lost is None or not airborne:
        return [not_known(NAME, "the state of the link was not logged in flight")]
    found = []
    inside = within(status.t_s, airborne)
    when = spans_of(status.t_s, inside & (lost == 1))
    if when and not lost.all():
        text = f"The connection to the ground station was lost for {total_s(when):.1f} s in flight."
        found.append(Finding(NAME, Severity.WARNING, "ground station lost", text, when[0].from_s, when[-1].to_s))
    elif when:
        text = "No ground station was heard in the whole log: a failsafe on its loss cannot act."
        found.append(Finding(NAME, Severity.NOTE, "no ground station", text))
    return [*found, *_losses(log)]


def _losses(log: FlightLog) -> list[Finding]:
    found = []
    for number, topic in enumerate(log.topics.get("telemetry_status", ())):
        rate = topic.column("rx_message_lost_rate")
        inside = within(topic.t_s, log.airborne())
        if rate is None or not inside.any():
            continue
        worst = float(np.nanmax(rate[inside]))
        if worst > LOSS_MAX:
            when = spans_of(topic.t_s, inside & (rate > LOSS_MAX))
            text = f"MAVLink channel {number} lost up to {worst:.0f} % of what was sent to the autopilot."
            evidence = {"lost_max_percent": worst}
            found.append(Finding(NAME, Severity.WARNING, "messages lost", text, when[0].from_s, when[-1].to_s, evidence))
    return found


ANALYSER = Analyser(NAME, ("vehicle_status", "telemetry_status"), examine)
