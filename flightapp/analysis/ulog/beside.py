"""Logs of the autopilots that lie in a run's folder, on the run's own time line."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.analysis.figures import Figure
from flightapp.analysis.findings import Finding, Severity, as_json
from flightapp.analysis.map_data import origin_name, origin_s
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.ulog.alignment import Alignment, Motion, align
from flightapp.analysis.ulog.figures import log_figures
from flightapp.analysis.ulog.flight import ExaminedLog, examine, summary_of
from flightapp.analysis.ulog.gps_time import gps_offset_s
from flightapp.analysis.ulog.sections import entries_table, findings_table, verdict_box
from flightapp.analysis.ulog.timeline import Entry
from flightapp.core.errors import InputError
from flightapp.core.types import Array

SUFFIX = ".ulg"
GPS_TOLERANCE_S = 1.0
"""Fleet time may be this far from GPS time before it is worth a word."""


@dataclass(frozen=True, slots=True)
class LogBeside:
    """One log of the folder. `unreadable` or `unaligned`: why it could not be read, or be put on the run's time line."""

    path: Path
    examined: ExaminedLog | None = None
    vehicle: VehicleRun | None = None
    alignment: Alignment | None = None
    unreadable: str = ""
    unaligned: str = ""

    def on_run(self, t_s: Array) -> Array:
        """Times of the log as fleet time; unchanged where it is not aligned."""
        return t_s if self.alignment is None else np.asarray(self.alignment.to_reference(t_s), dtype=np.float64)


def logs_beside(run: Run) -> tuple[LogBeside, ...]:
    """Every `.ulg` in the run's folder, read, given to its vehicle and aligned. None are looked for beside single recordings."""
    if run.prefix:
        return ()
    return tuple(_beside(run, path) for path in sorted(run.folder.iterdir()) if path.suffix.lower() == SUFFIX)


def _beside(run: Run, path: Path) -> LogBeside:
    try:
        examined = examine(path)
    except InputError as error:
        return LogBeside(path, unreadable=str(error))
    motion = _log_motion(examined)
    if motion is None:
        return LogBeside(path, examined, unaligned="the log holds no velocity")
    named = set(path.stem.replace("_", "-").split("-"))
    candidates = [v for v in run.vehicles if v.name in named] or list(run.vehicles)
    tried = [(vehicle, align(known, motion)) for vehicle in candidates if (known := _own_motion(vehicle)) is not None]
    matched = [(vehicle, found) for vehicle, found in tried if isinstance(found, Alignment)]
    if matched:
        vehicle, alignment = min(matched, key=lambda one: one[1].residual_m_s)
        return LogBeside(path, examined, vehicle, alignment)
    reasons = [found for _, found in tried if isinstance(found, str)]
    why = reasons[0] if len(candidates) == 1 and reasons else "no vehicle of this run moved as it did"
    return LogBeside(path, examined, candidates[0] if len(candidates) == 1 else None, unaligned=why)


def _log_motion(examined: ExaminedLog) -> Motion | None:
    local = examined.log.topic("vehicle_local_position")
    velocity = None if local is None else local.vectors(("vx", "vy", "vz"))
    return None if local is None or velocity is None else _motion(local.t_s, velocity)


def _own_motion(vehicle: VehicleRun) -> Motion | None:
    """Own velocity at the times when it was true."""
    series = vehicle.recording.topic("/own")
    return _motion(series.column("t_s") - series.column("age_s"), series.vectors("velocity_ned_m_s"))


def _motion(t_s: Array, velocity: Array) -> Motion | None:
    good = np.isfinite(t_s) & np.isfinite(velocity).all(axis=1)
    times, first = np.unique(t_s[good], return_index=True)
    return Motion(times, velocity[good][first]) if len(times) > 1 else None


def findings_beside(logs: Sequence[LogBeside]) -> list[Finding]:
    """What the autopilots' logs say, in fleet time; that a log could not be read or aligned is a finding too."""
    found = []
    for log in logs:
        if log.unreadable:
            found.append(Finding("PX4 log", Severity.WARNING, f"{log.path.name} cannot be read", log.unreadable))
        elif log.alignment is None:
            found.append(Finding("PX4 log", Severity.NOTE, f"{log.path.name} is not on the time line", f"{log.unaligned}."))
        else:
            found += [*_moved(log), *_against_gps(log)]
    return found


def _moved(log: LogBeside) -> list[Finding]:
    if log.examined is None:
        return []
    shifted = []
    for one in log.examined.findings:
        ends = [None if t_s is None else float(log.on_run(np.array([t_s]))[0]) for t_s in (one.from_s, one.to_s)]
        shifted.append(replace(one, from_s=ends[0], to_s=ends[1]))
    return shifted


def _against_gps(log: LogBeside) -> list[Finding]:
    gps_s = None if log.examined is None else gps_offset_s(log.examined.log)
    if gps_s is None or log.alignment is None:
        return []
    ahead_s = float(log.on_run(np.array([0.0]))[0]) - gps_s
    severity = Severity.NOTE if abs(ahead_s) > GPS_TOLERANCE_S else Severity.OK
    text = (
        f"Fleet time is {abs(ahead_s):.2f} s {'ahead of' if ahead_s > 0 else 'behind'} GPS time, as the log's receiver tells it."
    )
    return [Finding("clock", severity, "fleet time against GPS", text, evidence={"ahead_s": ahead_s})]


def summaries_beside(logs: Sequence[LogBeside]) -> list[dict[str, Any]]:
    """For summary.json: one entry a log. Its own times are in s since it began; `findings` are in fleet time where aligned."""
    summaries: list[dict[str, Any]] = []
    for log in logs:
        if log.examined is None:
            summaries.append({"file": log.path.name, "error": log.unreadable})
            continue
        told = summary_of(log.examined) | {"vehicle": None if log.vehicle is None else log.vehicle.name, "error": None}
        if log.alignment is not None:
            told |= {"findings": [as_json(finding) for finding in (*_moved(log), *_against_gps(log))]}
        summaries.append(told | {"alignment": _alignment_as_json(log)})
    return summaries


def _alignment_as_json(log: LogBeside) -> dict[str, Any]:
    found = log.alignment
    if found is None:
        return {"known": False, "why": log.unaligned}
    return {
        "known": True,
        "offset_s": found.offset_s,
        "offset_sigma_s": found.offset_sigma_s,
        "drift_ppm": found.drift_ppm if found.drift_sigma_ppm is not None else None,
        "drift_sigma_ppm": found.drift_sigma_ppm,
        "overlap_s": found.overlap_s,
        "correlation": found.correlation,
        "residual_m_s": found.residual_m_s,
    }


def sections_beside(run: Run, logs: Sequence[LogBeside]) -> tuple[str, list[tuple[str, Figure]]]:
    """(HTML, figures with the ids of their places in it): one section a log, on the page's time line."""
    sections: list[str] = []
    figures: list[tuple[str, Figure]] = []
    for number, log in enumerate(logs):
        name = escape(log.path.name)
        if log.examined is None:
            sections.append(f'<section><h2>Autopilot log {name}</h2><p class="note">{escape(log.unreadable)}</p></section>')
            continue
        zero_s = origin_s(run) if log.alignment is not None else 0.0
        findings = [_relative(one, zero_s) for one in (*_moved(log), *_against_gps(log))]
        line = "log" if log.alignment is None else origin_name(run)
        shift = functools.partial(_on_page, log, zero_s)
        charts = log_figures(log.examined.log, findings, f"time since the {line} began, s", shift)
        places = [(f"ulog{number}-{index}", title, figure) for index, (title, figure) in enumerate(charts)]
        figures += [(place, figure) for place, _, figure in places]
        plots = "".join(
            f'<section class="chart"><h3>{escape(title)}</h3><div id="{place}"></div></section>' for place, title, _ in places
        )
        sections.append(
            f'<section><h2>Autopilot log {name}</h2><p class="note">{escape(_told(log))}</p>{verdict_box(log.examined)}'
            f"<h3>Findings</h3>{findings_table(findings)}"
            f"<h3>Events, of the autopilot and ours</h3>{entries_table(_entries(log, zero_s))}"
            f'<div class="charts">{plots}</div></section>'
        )
    return "".join(sections), figures


def _on_page(log: LogBeside, zero_s: float, t_s: Array) -> Array:
    return log.on_run(t_s) - zero_s


def _relative(finding: Finding, zero_s: float) -> Finding:
    ends = [None if t_s is None else t_s - zero_s for t_s in (finding.from_s, finding.to_s)]
    return replace(finding, from_s=ends[0], to_s=ends[1])


def _told(log: LogBeside) -> str:
    found = log.alignment
    if found is None or log.vehicle is None:
        return f"Its times count from its own beginning: {log.unaligned}."
    drift = "" if found.drift_sigma_ppm is None else f", drift {found.drift_ppm:.0f} ± {found.drift_sigma_ppm:.0f} ppm"
    return (
        f"Of {log.vehicle.name}. Its clock was aligned by the velocity that both recorded over {found.overlap_s:.0f} s: to "
        f"± {1e3 * found.offset_sigma_s:.1f} ms{drift}, {found.residual_m_s:.2f} m/s left; the telemetry's delay is in it."
    )


def _entries(log: LogBeside, zero_s: float) -> list[Entry]:
    """Both sides' events in one order, where the clocks are aligned."""
    if log.examined is None:
        return []
    entries = [replace(one, t_s=float(log.on_run(np.array([one.t_s]))[0]) - zero_s) for one in log.examined.entries]
    if log.alignment is None or log.vehicle is None:
        return entries
    entries = [replace(one, name=f"PX4 {one.name}") for one in entries]
    events, phases = log.vehicle.recording.topic("/event"), log.vehicle.recording.topic("/phase")
    for t_s, level, text in zip(events.t_s.tolist(), events.texts("level"), events.texts("text"), strict=True):
        entries.append(Entry(t_s - zero_s, level, "flightapp", text))
    for t_s, phase, reason in zip(phases.t_s.tolist(), phases.texts("phase"), phases.texts("reason"), strict=True):
        entries.append(Entry(t_s - zero_s, "phase", "flightapp phase", f"{phase}: {reason}" if reason else phase))
    return sorted(entries, key=lambda entry: entry.t_s)
