"""Clock: do the vehicles' clocks agree, does any jump, and what is the time base of this report?

The youngest state that a vehicle hears of another within a second or two is as old as the link is slow, plus what the two clocks
differ by. Of both directions of a link the first half cancels, as in NTP: offset = (youngest at A - youngest at B) / 2.
"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import MISSION, Analyser
from flightapp.analysis.analysers.subject import Heard, Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.core.types import Array
from flightapp.fleet.admission import FUTURE_TOLERANCE_S

NAME = "clock"
FLOOR_S = 2.0
"""Within it somebody at 20 Hz is heard forty times: the youngest state then shows the link's least delay."""
JUMP_S = 0.1
"""Half of what is refused as coming from the future, and ten times what the least delay of a good link moves by."""
STEADY_FLOORS = 3
"""So many before and after a jump must agree: a link that is lost and comes back is no jump."""


def examine(subject: Subject) -> list[Finding]:
    others = [vehicle.name for vehicle in subject.mission.vehicles if vehicle.name != subject.name]
    found = [finding for name in others for finding in (*_offset(subject, name), *_jumps(subject, name))]
    return [_base(subject), *found]


def _base(subject: Subject) -> Finding:
    """How this recording was brought onto the time base of the run."""
    shift_s, source = subject.vehicle.shift_s, subject.vehicle.shift_source
    evidence: dict[str, float | str] = {"shift_s": shift_s, "source": source}
    if source == "not measured":
        text = f"No clock offset of {subject.name} was measured: its times are taken as they are."
        return Finding(NAME, Severity.NOTE, "offset not measured", text, evidence=evidence, vehicle=subject.name)
    text = f"The times of {subject.name} were moved by {shift_s * 1e3:.1f} ms ({source})."
    return Finding(NAME, Severity.OK, "time base", text, evidence=evidence, vehicle=subject.name)


def _offset(subject: Subject, name: str) -> list[Finding]:
    """What the ages say although clocks agree as far as anybody knew: stale from the first, or stamped in the future."""
    heard = subject.heard.get(name)
    if heard is None:
        return []
    t_s, floors = floors_of(heard)
    if len(floors) < STEADY_FLOORS:
        return []
    offset_s = -float(np.median(floors))
    if abs(offset_s) <= FUTURE_TOLERANCE_S or float(np.ptp(floors[:STEADY_FLOORS])) > JUMP_S:
        return []
    where = "behind" if offset_s < 0.0 else "ahead of"
    text = (
        f"States of {name} seem {-offset_s:.2f} s old when they are youngest: its clock is {where} that of {subject.name}, "
        "or the link delays everything. Synchronise the clocks before the next flight."
    )
    evidence: dict[str, float | str] = {"offset_s": offset_s, "other": name, "limit_s": FUTURE_TOLERANCE_S}
    return [Finding(NAME, Severity.WARNING, "clocks differ", text, float(t_s[0]), float(t_s[-1]), evidence, subject.name)]


def _jumps(subject: Subject, name: str) -> list[Finding]:
    heard = subject.heard.get(name)
    if heard is None:
        return []
    t_s, floors = floors_of(heard)
    for index in range(STEADY_FLOORS, len(floors) - STEADY_FLOORS + 1):
        before, after = floors[index - STEADY_FLOORS : index], floors[index : index + STEADY_FLOORS]
        step_s = float(np.median(after) - np.median(before))
        if abs(step_s) > JUMP_S and max(np.ptp(before), np.ptp(after)) < JUMP_S / 2:
            text = f"Between {subject.name} and {name} the clocks moved by {step_s:+.2f} s in flight."
            evidence: dict[str, float | str] = {"step_s": step_s, "other": name, "limit_s": JUMP_S}
            at_s = float(t_s[index])
            return [Finding(NAME, Severity.WARNING, "clock jumped", text, at_s, at_s, evidence, subject.name)]
    return []


def floors_of(heard: Heard) -> tuple[Array, Array]:
    """Starts (m,) of stretches of FLOOR_S, and the youngest state heard in each (m,); stretches without news are left out."""
    flying = heard.is_done == 0
    t_s, age_s = heard.t_s[flying], heard.age_s[flying]
    if len(t_s) == 0:
        return np.zeros(0), np.zeros(0)
    slot = ((t_s - t_s[0]) / FLOOR_S).astype(np.int64)
    slots, first = np.unique(slot, return_index=True)
    floors = np.minimum.reduceat(age_s, first)
    spread = np.maximum.reduceat(age_s, first) - floors
    heard_often = spread < FLOOR_S / 2
    return t_s[0] + slots[heard_often] * FLOOR_S, floors[heard_often]


ANALYSER = Analyser(NAME, "Did the clocks agree?", ("/team", MISSION), examine)
