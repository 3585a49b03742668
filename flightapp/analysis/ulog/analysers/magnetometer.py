"""Is the field that the magnetometer measures disturbed?"""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.spans import spans_of, total_s, within

NAME = "magnetometer"
SHARE_MAX = 0.05
"""Of the flight; single samples near steel are usual at take-off."""


def examine(log: FlightLog) -> list[Finding]:
    topic = log.topic("estimator_status_flags")
    disturbed = None if topic is None else topic.column("cs_mag_field_disturbed")
    airborne = log.airborne()
    if topic is None or disturbed is None or not airborne:
        return [not_known(NAME, "cs_mag_field_disturbed was not logged in flight")]
    when = spans_of(topic.t_s, within(topic.t_s, airborne) & (disturbed == 1))
    share = total_s(when) / max(total_s(airborne), 1e-9)
    if share <= SHARE_MAX:
        return []
    text = f"The estimator called the magnetic field disturbed for {total_s(when):.1f} s, {share:.0%} of the flight."
    evidence = {"disturbed_s": total_s(when), "disturbed_fraction": share}
    return [Finding(NAME, Severity.WARNING, "magnetic field disturbed", text, when[0].from_s, when[-1].to_s, evidence)]


ANALYSER = Analyser(NAME, ("estimator_status_flags", "vehicle_land_detected"), examine)
