"""The lanes above the charts: phases, modes and acting guards of every vehicle over the whole run. Every text is escaped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from flightapp.analysis.figures import span_s
from flightapp.analysis.map_data import MODE_COLOURS, origin_s
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.spells import Spell, guard_spells, mode_spells, phase_spells

_PHASE_COLOURS = {
    "preflight": "#6b7885",
    "arm": "#56636f",
    "takeoff": "#3b6ea5",
    "ingress": "#44748f",
    "ready": "#4d7ea8",
    "pursue": "#2f7d5b",
    "return": "#7a6a3a",
    "land": "#5b5f97",
    "released": "#8a5a44",
    "done": "#56636f",
}
_OTHER_COLOUR = "#616e7c"
_GUARD_COLOUR = "#b45f06"
_NAMED_SHARE = 0.05
"""Shorter bars have no room for their name; it is in the tool tip."""


def lanes_html(run: Run) -> str:
    """One block a vehicle; a click is a time (see player.js)."""
    colours: dict[str, str] = {}
    blocks = "".join(_block(run, vehicle, colours) for vehicle in run.vehicles)
    return f'<div class="lanes" id="lanes">{blocks}<div class="cursor"></div></div>'


def _block(run: Run, vehicle: VehicleRun, mode_colours: dict[str, str]) -> str:
    modes, guards = mode_spells(vehicle), guard_spells(vehicle)
    for spell in modes:
        mode_colours.setdefault(spell.name, MODE_COLOURS[len(mode_colours) % len(MODE_COLOURS)])
    lanes = [_lane(run, f"{vehicle.name} phase", phase_spells(vehicle), _PHASE_COLOURS, first=True)]
    if modes:
        lanes.append(_lane(run, f"{vehicle.name} mode", modes, mode_colours))
    for guard in dict.fromkeys(spell.name for spell in guards):
        chosen = [spell for spell in guards if spell.name == guard]
        lanes.append(_lane(run, f"{vehicle.name} {guard}", chosen, {guard: _GUARD_COLOUR}, named=False))
    return "".join(lanes)


def _lane(
    run: Run, name: str, spells: Sequence[Spell], colours: Mapping[str, str], *, first: bool = False, named: bool = True
) -> str:
    bars = "".join(_bar(run, spell, colours.get(spell.name, _OTHER_COLOUR), named) for spell in spells)
    title = escape(name)
    extra = " first" if first else ""
    return f'<div class="lane{extra}"><div class="name" title="{title}">{title}</div><div class="bar">{bars}</div></div>'


def _bar(run: Run, spell: Spell, colour: str, named: bool) -> str:
    zero_s, (from_s, to_s) = origin_s(run), span_s(run)
    start, end = (min(max(t_s - zero_s, from_s), to_s) for t_s in (spell.from_s, spell.to_s))
    if spell.to_s - zero_s < from_s or spell.from_s - zero_s > to_s:
        return ""
    left, width = (start - from_s) / (to_s - from_s), (end - start) / (to_s - from_s)
    told = f"{spell.name}, {spell.from_s - zero_s:.1f} to {spell.to_s - zero_s:.1f} s"
    title = escape(f"{told}: {spell.reason}" if spell.reason else told)
    is_named = named and width > _NAMED_SHARE
    return (
        f'<i class="{"" if is_named else "thin"}" style="left:{100 * left:.3f}%;width:{100 * width:.3f}%;background:{colour}" '
        f'title="{title}">{escape(spell.name) if is_named else ""}</i>'
    )
