"""Stretches of time in which one thing held: phases, modes, guards that changed a setpoint."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from flightapp.analysis.run import VehicleRun

_GUARD_GAP_S = 0.3
"""A guard that acts again so soon never stopped, to the eye."""
_SHARE_OF_RUN = 1.0 / 400
"""Likewise, in a long run, within what is a few pixels of the time line."""


@dataclass(frozen=True, slots=True)
class Spell:
    """`name` held from `from_s` to `to_s`, fleet time; `reason` is the first that was told."""

    name: str
    from_s: float
    to_s: float
    reason: str = ""


def phase_spells(vehicle: VehicleRun) -> list[Spell]:
    """The mission's phases."""
    starts = [*vehicle.phases.starts, (vehicle.phases.end_s, "")]
    return [Spell(name, from_s, max(to_s, from_s)) for (from_s, name), (to_s, _) in itertools.pairwise(starts)]


def mode_spells(vehicle: VehicleRun) -> list[Spell]:
    """The planner's modes; after its last decision there is none."""
    series = vehicle.recording.topic("/decision")
    spells: list[Spell] = []
    begun: tuple[str, float, str] | None = None
    last_s = 0.0
    for t_s, mode, reason in zip(series.t_s.tolist(), series.texts("mode"), series.texts("reason"), strict=True):
        if begun is None or mode != begun[0]:
            if begun is not None:
                spells.append(Spell(begun[0], begun[1], t_s, begun[2]))
            begun = (mode, t_s, reason)
        last_s = t_s
    return spells if begun is None else [*spells, Spell(begun[0], begun[1], last_s, begun[2])]


def guard_spells(vehicle: VehicleRun) -> list[Spell]:
    """When each guard made setpoints stricter, in the order of time; short pauses are bridged."""
    series = vehicle.recording.topic("/setpoint")
    if len(series) == 0:
        return []
    gap_s = max(_GUARD_GAP_S, _SHARE_OF_RUN * float(series.t_s[-1] - series.t_s[0]))
    open_spells: dict[str, Spell] = {}
    spells: list[Spell] = []
    for t_s, acting in zip(series.t_s.tolist(), series.values("acting"), strict=True):
        for guard, reason in _named(acting):
            known = open_spells.get(guard)
            if known is not None and t_s - known.to_s <= gap_s:
                open_spells[guard] = Spell(guard, known.from_s, t_s, known.reason)
            else:
                if known is not None:
                    spells.append(known)
                open_spells[guard] = Spell(guard, t_s, t_s, reason)
    return sorted([*spells, *open_spells.values()], key=lambda spell: (spell.from_s, spell.name))


def _named(acting: object) -> list[tuple[str, str]]:
    rows = acting if isinstance(acting, list) else []
    return [(str(row[0]), str(row[1]) if len(row) > 1 else "") for row in rows if isinstance(row, list) and row]
