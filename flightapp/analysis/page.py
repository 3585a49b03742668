"""report.html: one file that tells a run to a pilot in a minute, and works without a network."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

import orjson
from plotly.offline import get_plotlyjs

from flightapp.analysis.figures import Figure, chart_figures, map_figure
from flightapp.analysis.map_data import origin_name, origin_s
from flightapp.analysis.picture import save_picture
from flightapp.analysis.run import Run, load_run
from flightapp.analysis.style import STYLE
from flightapp.analysis.summary import Summary, save_summary, summarise, write_whole
from flightapp.analysis.tables import events_table, figures_table, recordings_table, vehicles_table
from flightapp.analysis.ulog.beside import LogBeside, logs_beside, sections_beside, summaries_beside
from flightapp.analysis.verdict import verdict_of


def report(run_paths: Sequence[Path]) -> tuple[Summary, Path]:
    """Write summary.json, map.png and report.html for one run folder, or for single recordings (`.mcap`) beside the first.

    Returns the summary and the path of report.html. InputError if there is nothing to read.
    """
    run = load_run(run_paths)
    logs = logs_beside(run)
    summary = summarise(run) | {"autopilot_logs": summaries_beside(logs)}
    save_summary(run, summary)
    save_picture(run)
    return summary, save_report(run, summary, logs)


def write_report(run: Path) -> Path:
    """Write `report.html` into the run folder; InputError if it holds no readable recording."""
    loaded = load_run([run])
    return save_report(loaded, summarise(loaded))


def save_report(run: Run, summary: Summary, logs: Sequence[LogBeside] = ()) -> Path:
    """Write the page where it belongs, with the autopilots' logs of the folder; whole or not at all."""
    path = run.output("report.html")
    write_whole(path, _page(run, summary, logs).encode())
    return path


def _page(run: Run, summary: Summary, logs: Sequence[LogBeside]) -> str:
    title = f"{summary['mission'] or run.folder.name}"
    charts = chart_figures(run)
    figures = [("map", map_figure(run)), *((f"chart{number}", figure) for number, (_, figure) in enumerate(charts))]
    plots = "".join(
        f'<section class="chart"><h3>{escape(name)}</h3><div id="chart{number}"></div></section>'
        for number, (name, _) in enumerate(charts)
    )
    log_sections, log_figures = sections_beside(run, logs)
    figures += log_figures
    body = f"""
<header><div><h1>{escape(title)}</h1><p class="sub">{escape(_subtitle(run, summary))}</p></div></header>
{_verdict(summary)}
<div class="columns"><section><h2>Figures</h2>{figures_table(summary)}</section>
<section><h2>Vehicles</h2>{vehicles_table(summary)}</section></div>
<section><h2>Map</h2><p class="note">{escape(_map_note(run))}</p><div id="map"></div></section>
<section><h2>Over time</h2><p class="note">{_time_note(run, summary)}</p><div class="charts">{plots}</div></section>
<section><h2>Events</h2>{events_table(run)}</section>
{log_sections}
<section><h2>Recordings</h2>{recordings_table(summary)}</section>"""
    return document(title, body, figures)


def document(title: str, body: str, figures: Sequence[tuple[str, Figure]]) -> str:
    """A page that needs nothing else: `body` is HTML, every figure is drawn into the element of its id."""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}</style><script>{get_plotlyjs()}</script></head><body><main>{body}</main>"
        f"<script>{_script(figures)}</script></body></html>\n"
    )


def _script(figures: Sequence[tuple[str, Figure]]) -> str:
    """Draws every figure. Inside a script no recorded text may look like markup."""
    data = orjson.dumps(dict(figures)).decode().replace("<", "\\u003c")
    return (
        f"const figures = {data};"
        "for (const [id, figure] of Object.entries(figures))"
        " Plotly.newPlot(id, figure.data, figure.layout,"
        " {responsive: true, displaylogo: false, displayModeBar: id === 'map'});"
    )


def _verdict(summary: dict[str, Any]) -> str:
    verdict = verdict_of(summary)
    reasons = "".join(f"<li>{escape(reason)}</li>" for reason in verdict.reasons)
    below = f"<ul>{reasons}</ul>" if reasons else " No limit was broken." if verdict.level == "good" else ""
    return f'<div class="verdict {verdict.level}"><strong>{escape(verdict.headline)}.</strong>{below}</div>'


def _subtitle(run: Run, summary: Summary) -> str:
    began = datetime.fromtimestamp(origin_s(run), UTC).strftime("%d %B %Y, %H:%M:%S UTC")
    parts = [f"{origin_name(run).capitalize()} began {began}"]
    if run.mission is not None and run.mission.description:
        parts.insert(0, run.mission.description)
    if summary["seed"] is not None:
        parts.append(f"seed {summary['seed']}")
    return ". ".join(parts)


def _time_note(run: Run, summary: Summary) -> str:
    capture = "" if summary["capture_time_s"] is None else " The dotted vertical line marks the capture."
    return f"From take-off to the end of the recordings; zero is the start of the {origin_name(run)}.{capture}"


def _map_note(run: Run) -> str:
    sources = {vehicle.track.source for vehicle in run.vehicles if vehicle.track is not None}
    states = "True states of the simulation." if sources == {"truth"} else "States as the vehicles knew them."
    return f"North up. {states} Pursuers are coloured by mode. Drag to zoom, double-click to reset."
