"""The report of one PX4 log alone: a page that works offline, a summary, and a few lines for the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

import orjson

from flightapp.analysis.findings import Severity
from flightapp.analysis.page import document
from flightapp.analysis.summary import write_whole
from flightapp.analysis.ulog.figures import log_figures
from flightapp.analysis.ulog.flight import ExaminedLog, examine, software_of, summary_of
from flightapp.analysis.ulog.gps_time import gps_offset_s
from flightapp.analysis.ulog.sections import entries_table, findings_table, verdict_box
from flightapp.analysis.ulog.spans import total_s
from flightapp.core.errors import InputError

SUFFIX = ".ulg"
X_TITLE = "time since the log began, s"


@dataclass(frozen=True, slots=True)
class LogReport:
    """What was written, and what it says."""

    summary: dict[str, Any]
    page: Path
    examined: ExaminedLog

    def text(self) -> str:
        """For the terminal: the verdict, then every warning, failure and note, the worst first."""
        told = sorted((one for one in self.examined.findings if one.severity > Severity.OK), key=lambda one: -one.severity)
        lines = [f"{one.severity.name.lower():8} {one.analyser}: {one.title}. {one.text}" for one in told]
        looked = sum(one.severity == Severity.OK for one in self.examined.findings)
        lines = [f"verdict: {self.examined.headline}", *lines, f"ok       {looked} findings without complaint"]
        return "\n".join([*lines, f"report:  {self.page}"])


def report_log(path: Path, folder: Path | None = None) -> LogReport:
    """Write FLIGHT-report.html and FLIGHT-summary.json beside the log, or into `folder`; InputError if that cannot be done."""
    examined = examine(path)
    target = path.parent if folder is None else folder
    page = target / f"{path.stem}-report.html"
    summary = summary_of(examined)
    try:
        target.mkdir(parents=True, exist_ok=True)
        content = orjson.dumps(summary, option=orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY)
        write_whole(target / f"{path.stem}-summary.json", content + b"\n")
        write_whole(page, _page(examined).encode())
    except OSError as error:
        raise InputError(f"{target}: the report cannot be written: {error.strerror}; name a folder with --output") from None
    return LogReport(summary, page, examined)


def _page(examined: ExaminedLog) -> str:
    log = examined.log
    charts = log_figures(log, list(examined.findings), X_TITLE, lambda t_s: t_s)
    plots = "".join(
        f'<section class="chart"><h3>{escape(title)}</h3><div id="ulog{number}"></div></section>'
        for number, (title, _) in enumerate(charts)
    )
    body = f"""
<header><div><h1>{escape(log.path.name)}</h1><p class="sub">{escape(_subtitle(examined))}</p></div></header>
{verdict_box(examined)}
<section><h2>Findings</h2>{findings_table(examined.findings)}</section>
<section><h2>Over time</h2><p class="note">Shaded: where a warning or a failure was found.</p>
<div class="charts">{plots}</div></section>
<section><h2>Events</h2>{entries_table(examined.entries)}</section>"""
    return document(log.path.name, body, [(f"ulog{number}", figure) for number, (_, figure) in enumerate(charts)])


def _subtitle(examined: ExaminedLog) -> str:
    log = examined.log
    began = gps_offset_s(log)
    parts = [
        "PX4 log",
        *([] if began is None else [datetime.fromtimestamp(began, UTC).strftime("%d %B %Y, %H:%M:%S UTC, by GPS")]),
        *(name for name in (software_of(log), log.information.get("ver_hw")) if name),
        f"{log.end_s:.0f} s, {total_s(log.airborne()):.0f} s in the air",
    ]
    return ". ".join(parts)
