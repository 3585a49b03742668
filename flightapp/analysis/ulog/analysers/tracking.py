"""How well the velocity that was asked for was flown."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.response import response_of

NAME = "tracking"
ERROR_MAX_M_S = 1.0
DELAY_MAX_S = 1.0
"""Beyond, the velocity loop is not fit to pursue with."""


def examine(log: FlightLog) -> list[Finding]:
    response = response_of(log)
    if response is None:
        return [not_known(NAME, "no velocity setpoint that changed was logged in flight")]
    evidence: dict[str, float | str] = {
        "rms_horizontal_m_s": response.rms_horizontal_m_s,
        "rms_vertical_m_s": response.rms_vertical_m_s,
        "source": response.source,
    }
    delay = "delay not measurable"
    if response.delay_s is not None and response.rms_delayed_m_s is not None:
        delay = f"follows {response.delay_s:.2f} s behind, {response.rms_delayed_m_s:.2f} m/s once that is taken out"
        evidence |= {"delay_s": response.delay_s, "rms_after_delay_m_s": response.rms_delayed_m_s}
    text = (
        f"Velocity against its setpoint ({response.source}): RMS {response.rms_horizontal_m_s:.2f} m/s horizontally, "
        f"{response.rms_vertical_m_s:.2f} m/s vertically; {delay}."
    )
    late = response.delay_s is not None and response.delay_s > DELAY_MAX_S
    poor = (response.rms_delayed_m_s if response.rms_delayed_m_s is not None else response.rms_horizontal_m_s) > ERROR_MAX_M_S
    severity = Severity.WARNING if late or poor else Severity.OK
    title = "velocity follows late" if late else "velocity follows badly" if poor else "velocity follows"
    return [Finding(NAME, severity, title, text, response.span.from_s, response.span.to_s, evidence)]


ANALYSER = Analyser(NAME, ("vehicle_local_position", "trajectory_setpoint|vehicle_local_position_setpoint"), examine)
