"""report.html: one file that tells a run to a pilot in a minute, and works without a network."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

import orjson
from plotly.offline import get_plotlyjs

from flightapp.analysis.comparison import comparison_section, differences
from flightapp.analysis.export import table_of, write_csv, write_parquet
from flightapp.analysis.figures import Figure, chart_figures, not_recorded
from flightapp.analysis.findings import of_json
from flightapp.analysis.findings_section import findings_section, log_findings
from flightapp.analysis.lanes import lanes_html
from flightapp.analysis.map_data import origin_name, origin_s
from flightapp.analysis.map_section import map_section
from flightapp.analysis.outcome import pursuit_start_s
from flightapp.analysis.picture import save_picture
from flightapp.analysis.playback import ghost_name, playback_of
from flightapp.analysis.run import Run, load_run
from flightapp.analysis.signals import Signal, signals_of
from flightapp.analysis.style import scripts, style
from flightapp.analysis.summary import Summary, save_summary, summarise, write_whole
from flightapp.analysis.tables import events_section, figures_table, recordings_table, vehicles_table
from flightapp.analysis.ulog.beside import LogBeside, logs_beside, sections_beside, summaries_beside
from flightapp.analysis.verdict import verdict_of
from flightapp.core.errors import InputError

_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'"
"""The browser itself refuses whatever would come from a network."""


@dataclass(frozen=True, slots=True)
class Compared:
    """Another run, shown as a ghost."""

    name: str
    run: Run
    summary: Summary


def report(
    run_paths: Sequence[Path], *, compare: Sequence[Path] = (), as_csv: bool = False, as_parquet: bool = False
) -> tuple[Summary, Path]:
    """Write summary.json, map.png and report.html for one run folder, or for single recordings (`.mcap`) beside the first.

    compare: other runs, each a folder or a recording. as_csv, as_parquet: write all series beside the report too.
    Returns the summary and the path of report.html. InputError if there is nothing to read.
    """
    run = load_run(run_paths)
    compared = _compared(compare)
    logs = logs_beside(run)
    summary = summarise(run) | {"autopilot_logs": summaries_beside(logs)}
    if compared:
        summary |= {"compared": differences(summary, {one.name: one.summary for one in compared})}
    signals = signals_of(run)
    try:
        _export(run, signals, as_csv=as_csv, as_parquet=as_parquet)
        save_summary(run, summary)
        save_picture(run)
        return summary, save_report(run, summary, logs, compared, signals)
    except OSError as error:
        raise InputError(f"{run.folder}: the report cannot be written: {error.strerror}; copy the run to where it can") from None


def write_report(run: Path) -> Path:
    """Write `report.html` into the run folder; InputError if it holds no readable recording."""
    loaded = load_run([run])
    return save_report(loaded, summarise(loaded))


def save_report(
    run: Run,
    summary: Summary,
    logs: Sequence[LogBeside] = (),
    compared: Sequence[Compared] = (),
    signals: Sequence[Signal] | None = None,
) -> Path:
    """Write the page where it belongs, with the autopilots' logs of the folder; whole or not at all."""
    path = run.output("report.html")
    write_whole(path, _page(run, summary, logs, compared, signals_of(run) if signals is None else signals).encode())
    return path


def _compared(paths: Sequence[Path]) -> list[Compared]:
    compared = []
    for number, path in enumerate(paths):
        run = load_run([path])
        compared.append(Compared(ghost_name(number, run), run, summarise(run)))
    return compared


def _export(run: Run, signals: Sequence[Signal], *, as_csv: bool, as_parquet: bool) -> None:
    if not (as_csv or as_parquet):
        return
    table = table_of(run, signals)
    if as_csv:
        write_csv(run, table)
    if as_parquet:
        write_parquet(run, table)


def _page(run: Run, summary: Summary, logs: Sequence[LogBeside], compared: Sequence[Compared], signals: Sequence[Signal]) -> str:
    title = f"{summary['mission'] or run.folder.name}"
    charts = chart_figures(run, signals)
    figures = [(f"chart{number}", figure) for number, (_, figure) in enumerate(charts)]
    log_sections, log_figures = sections_beside(run, logs)
    shared = [name for name, _ in figures] + _aligned(logs, log_figures)
    findings = [*(of_json(one) for one in summary["findings"]), *log_findings(logs)]
    body = f"""
<header><h1>{escape(title)}</h1><p class="sub">{escape(_subtitle(run, summary))}</p></header>
{_verdict(summary)}
{findings_section(findings, origin_s(run))}
{comparison_section(summary, {one.name: one.summary for one in compared}, _remarks(run, compared))}
{map_section(run, [one.run for one in compared], lanes_html(run))}
<div class="columns"><section id="figures-of-run"><h2>Figures</h2>{figures_table(summary)}</section>
<section id="vehicles"><h2>Vehicles</h2>{vehicles_table(summary)}</section></div>
<section id="over-time"><h2>Over time</h2>{_time_note(run, summary, signals)}<div class="charts">{_plots(charts)}</div></section>
{events_section(run)}
{log_sections}
<section id="recordings"><h2>Recordings</h2>{recordings_table(summary)}</section>"""
    playback = playback_of(run, [one.run for one in compared])
    return document(title, body, [*figures, *log_figures], shared=shared, playback=playback)


def document(
    title: str,
    body: str,
    figures: Sequence[tuple[str, Figure]],
    *,
    shared: Collection[str] | None = None,
    playback: dict[str, Any] | None = None,
) -> str:
    """A page that needs nothing else: `body` is HTML, every figure is drawn into the element of its id.

    shared: figures on one time line (all, without a word); playback: what the map plays, see `playback`.
    """
    on_one_line = [name for name, _ in figures if shared is None or name in shared]
    data = _data("figures", {"figures": dict(figures), "shared": on_one_line})
    data += "" if playback is None else _data("playback", playback)
    time_bar = "" if playback is None else _TIME_BAR
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{style()}</style><script>{get_plotlyjs()}</script></head><body><main>{body}"
        f"<footer>Made by flightapp report. This file needs no network.</footer>{time_bar}</main>"
        f"{data}<script>{scripts()}</script></body></html>\n"
    )


_SPEEDS = (0.25, 0.5, 1, 2, 5, 20, 60)
_OPTIONS = "".join(f'<option value="{speed:g}"{" selected" * (speed == 1)}>{speed:g}×</option>' for speed in _SPEEDS)
_TIME_BAR = (
    '<div class="bar-of-time"><button type="button" id="play" title="Space">Play</button>'
    f'<select id="speed" aria-label="Speed of playing">{_OPTIONS}</select>'
    '<input type="range" id="slider" aria-label="Time" title="Arrow keys step 0.2 s, with Shift 2 s">'
    '<output id="time"></output></div>'
)


def _data(name: str, content: object) -> str:
    """A block that scripts read. No recorded text may look like markup in it."""
    text = orjson.dumps(content, option=orjson.OPT_SERIALIZE_NUMPY).decode().replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{text}</script>'


def _plots(charts: Sequence[tuple[str, Figure]]) -> str:
    return "".join(
        f'<section class="chart"><h3>{escape(name)}</h3><div id="chart{number}"></div></section>'
        for number, (name, _) in enumerate(charts)
    )


def _aligned(logs: Sequence[LogBeside], figures: Sequence[tuple[str, Figure]]) -> list[str]:
    """Figures of logs that are on the run's time line."""
    prefixes = tuple(f"ulog{number}-" for number, log in enumerate(logs) if log.alignment is not None)
    return [name for name, _ in figures if name.startswith(prefixes)] if prefixes else []


def _remarks(run: Run, compared: Sequence[Compared]) -> list[str]:
    runs = {"this run": run} | {one.name: one.run for one in compared}
    without = [name for name, one in runs.items() if pursuit_start_s(one) is None]
    told = ["In brackets: the difference to this run. On the map the others are ghosts, aligned where each pursuit began."]
    return told + [f"{name} has no pursuit: it is aligned where its recording began." for name in without]


def _verdict(summary: dict[str, Any]) -> str:
    verdict = verdict_of(summary)
    reasons = "".join(f"<li>{escape(reason)}</li>" for reason in verdict.reasons)
    below = f"<ul>{reasons}</ul>" if reasons else " No limit was broken." if verdict.level == "good" else ""
    return f'<div class="verdict {verdict.level}" id="verdict"><strong>{escape(verdict.headline)}.</strong>{below}</div>'


def _subtitle(run: Run, summary: Summary) -> str:
    began = datetime.fromtimestamp(origin_s(run), UTC).strftime("%d %B %Y, %H:%M:%S UTC")
    parts = [f"{origin_name(run).capitalize()} began {began}"]
    if run.mission is not None and run.mission.description:
        parts.insert(0, run.mission.description)
    if summary["seed"] is not None:
        parts.append(f"seed {summary['seed']}")
    return ". ".join(parts)


def _time_note(run: Run, summary: Summary, signals: Sequence[Signal]) -> str:
    capture = "" if summary["capture_time_s"] is None else " The dotted vertical line marks the capture."
    missing = not_recorded(signals)
    left_out = f" Not recorded: {escape(', '.join(missing).lower())}." if missing else ""
    return (
        f'<p class="note">Zero is the start of the {origin_name(run)}. The blue line is the time of the map. '
        f"Drag to zoom all charts, double-click to reset, click for a time.{capture}{left_out}</p>"
    )
