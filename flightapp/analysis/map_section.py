"""The part of the page that plays the run: map, layers with their legend, states, lanes. Every text is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from flightapp.analysis.run import Run
from flightapp.analysis.signals import true_evader

_LAYERS = (
    ("tracks", "way flown; thick: the last 8 s", "var(--soft)", "solid"),
    ("estimate", "target estimate (cross) and its 2 σ", "var(--soft)", "dotted"),
    ("discs", "obstacle discs known then", "var(--disc)", "solid"),
    ("circles", "Apollonius circles", "var(--circle)", "dashed"),
    ("arrows", "setpoint (1 s of it) and goal (square)", "var(--soft)", "solid"),
)
_LINES = (
    ("boundary", "protected boundary"),
    ("fence", "fence"),
    ("stone", "surveyed obstacle"),
    ("known", "known obstacle; dashed: way as planned"),
)


def map_section(run: Run, ghosts: Sequence[Run], lanes: str) -> str:
    """`lanes`: HTML of the time lines."""
    layers = list(_LAYERS) + ([("ghosts", "compared runs", "var(--ghost)", "dashed")] if ghosts else [])
    boxes = "".join(
        f'<label><input type="checkbox" data-layer="{layer}" checked>'
        f'<span class="swatch" style="border-color:{colour};border-top-style:{kind}"></span>{escape(text)}</label>'
        for layer, text, colour, kind in layers
    )
    lines = "".join(
        f'<label><span class="swatch" style="border-color:var(--{name})"></span>{escape(text)}</label>' for name, text in _LINES
    )
    return (
        f'<section id="map-section"><h2>Map and time</h2><p class="note">{escape(_note(run))}</p>'
        f'<div class="play"><canvas id="map" role="img" aria-label="Map of the run at the time of the slider"></canvas>'
        f'<div><div class="layers">{boxes}{lines}</div><div class="states" id="states"></div></div></div>{lanes}</section>'
    )


def _note(run: Run) -> str:
    sources = {vehicle.track.source for vehicle in run.vehicles if vehicle.track is not None}
    states = "True states of the simulation." if sources == {"truth"} else "States as the vehicles knew them."
    evader = "" if true_evader(run) is not None else " The evader's true way is not known."
    flown = {vehicle.name for vehicle in run.vehicles}
    missing = [] if run.mission is None else [one.name for one in run.mission.vehicles if one.name not in flown]
    absent = f" There is no recording of {', '.join(missing)}." if missing else ""
    return f"North up. {states}{evader}{absent} Drag to move, wheel to zoom, double-click to reset; space plays, arrow keys step."
