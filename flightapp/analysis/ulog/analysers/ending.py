"""How the log ends: after landing, or in the air, as after a loss of power or a crash; and whether it is whole."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog

NAME = "log"
GAPS_MAX_S = 1.0


def examine(log: FlightLog) -> list[Finding]:
    return [*_ending(log), *_wholeness(log)]


def _ending(log: FlightLog) -> list[Finding]:
    landed, status = log.topic("vehicle_land_detected"), log.topic("vehicle_status")
    down = None if landed is None else landed.column("landed")
    arming = None if status is None else status.column("arming_state")
    if down is None or arming is None:
        return [not_known(f"{NAME} end", "neither landing nor arming was logged")]
    if down[-1] == 0:
        volts = _last_voltage(log)
        cause = "" if volts is None else f" The last battery voltage was {volts:.2f} V."
        text = (
            f"The last sample, {log.end_s:.1f} s after the first, is in the air: loss of power, a crash, or a log cut off.{cause}"
        )
        evidence: dict[str, float | str] = {} if volts is None else {"last_voltage_v": volts}
        return [Finding(NAME, Severity.FAILURE, "the log ends in the air", text, log.end_s, log.end_s, evidence)]
    if not log.airborne():
        return [Finding(NAME, Severity.NOTE, "no flight", "The vehicle never left the ground in this log.")]
    how = "armed" if arming[-1] == 2 else "disarmed"
    return [Finding(NAME, Severity.OK, "ends on the ground", f"The log ends landed and {how}, {log.end_s:.1f} s after it began.")]


def _last_voltage(log: FlightLog) -> float | None:
    battery = log.topic("battery_status")
    voltage = None if battery is None else battery.column("voltage_v")
    return None if voltage is None else float(voltage[-1])


def _wholeness(log: FlightLog) -> list[Finding]:
    found = []
    if log.damaged:
        text = "Bytes in the middle of the file could not be read; what they held is missing here."
        found.append(Finding(NAME, Severity.WARNING, "the file is damaged", text))
    lost_s = sum(log.gaps_s)
    if lost_s > 0.0:
        severity = Severity.WARNING if lost_s > GAPS_MAX_S else Severity.NOTE
        text = f"The logger missed {lost_s:.2f} s in {len(log.gaps_s)} drop-outs (a slow SD card, as a rule)."
        found.append(Finding(NAME, severity, "drop-outs of the logger", text, evidence={"missed_s": lost_s}))
    return found


ANALYSER = Analyser(NAME, ("vehicle_land_detected", "vehicle_status"), examine)
