"""Which failsafe wins and why, for a person: answered by the real table and the real state machine."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.core.errors import InputError
from flightapp.safety.failsafe.machine import Failsafe, Verdict
from flightapp.safety.failsafe.table import TABLE, Condition, Row

TRUE, FALSE = frozenset({"1", "true", "yes", "on"}), frozenset({"0", "false", "no", "off"})


@dataclass(frozen=True, slots=True)
class Explanation:
    """`rows`: of the conditions that are set, with whether each is in effect after `after_s`; `verdict`: what wins."""

    after_s: float
    rows: tuple[tuple[Row, bool], ...]
    verdict: Verdict


def parse_conditions(text: str) -> frozenset[Condition]:
    """`link_lost=1,battery_low=1` -> conditions; InputError names an unknown one and the known ones."""
    found = set()
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, value = part.partition("=")
        try:
            condition = Condition(name.strip())
        except ValueError:
            known = ", ".join(Condition)
            raise InputError(f"--set: '{name.strip()}': no such condition; known: {known}") from None
        word = value.strip().lower() or "1"
        if word not in TRUE | FALSE:
            raise InputError(f"--set: {name.strip()} = '{value.strip()}': write 1 or 0")
        if word in TRUE:
            found.add(condition)
    return frozenset(found)


def explain(conditions: frozenset[Condition], after_s: float) -> Explanation:
    """What happens when `conditions` have all held for `after_s` seconds."""
    machine = Failsafe()
    machine.step(0.0, conditions)
    verdict = machine.step(after_s, conditions)
    in_effect = machine.in_effect(after_s)
    return Explanation(after_s, tuple((row, row in in_effect) for row in TABLE if row.condition in conditions), verdict)


def sentence(found: Explanation) -> str:
    """The answer in one sentence."""
    row = found.verdict.row
    if row is None:
        return f"After {found.after_s:g} s: NORMAL, the mission goes on."
    override = "the pilot may override" if row.pilot_may_override else "the pilot may not override"
    return f"After {found.after_s:g} s: {row.action.name} by the {row.by}, because of {row.condition} ({row.why}); {override}."
