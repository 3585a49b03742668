"""Does this machine's clock agree with the others'?"""

from __future__ import annotations

from collections.abc import Iterable

from flightapp.preflight.facts import Facts, TeammateFacts
from flightapp.preflight.result import Level, Result

NAME = "clock"
REASON = "positions of teammates are aged by their stamps: 0.1 s is half a metre at 5 m/s"
AHEAD_MAX_S = 0.05
BEHIND_MAX_S = 0.5
MEASURED_AFTER_S = 5.0
"""A link that is slow now and then makes a clock look late: the quickest message of this time counts."""
CORRECTED_MAX_S = 1.0
"""Stamps of a clock that was measured are corrected, however wrong it is; operators' commands and file dates are not."""
SYNCHRONISE = "synchronise all machines with chrony (one of them as server)"


def judge(facts: Facts) -> tuple[Result, ...]:
    heard = [mate for mate in facts.teammates if mate.age_s is not None]
    wrong = [mate for mate in heard if _is_wrong(mate)]
    if wrong:
        found = ", ".join(f"{mate.name} {mate.clock_ahead_s * 1e3:+.0f} ms" for mate in wrong)
        level = Level.RUNNING if facts.waited_s < MEASURED_AFTER_S else Level.FAILED
        return (Result(NAME, level, found, REASON, SYNCHRONISE),)
    far = [mate for mate in heard if mate.clock_measured_s is not None and abs(mate.clock_measured_s) > CORRECTED_MAX_S]
    if far:
        found = f"{_offsets(far)}: corrected in flight, not in file dates and operators' commands"
        return (Result(NAME, Level.WARNING, found, REASON, SYNCHRONISE),)
    if facts.computer.clock_synchronised is False:
        level = Level.WARNING if len(facts.mission.vehicles) > 1 else Level.NOTED
        return (Result(NAME, level, "not synchronised by NTP or PTP", REASON, SYNCHRONISE),)
    return (Result(NAME, Level.PASSED, _offsets(heard) or "nobody to compare with", REASON),)


def _is_wrong(mate: TeammateFacts) -> bool:
    """A clock that was not measured, and that the stamps of its messages show to be wrong."""
    return mate.clock_measured_s is None and not -BEHIND_MAX_S <= mate.clock_ahead_s <= AHEAD_MAX_S


def _offsets(mates: Iterable[TeammateFacts]) -> str:
    return ", ".join(
        f"{mate.name} {mate.clock_ahead_s * 1e3:+.0f} ms"
        if mate.clock_measured_s is None
        else f"{mate.name} {mate.clock_measured_s * 1e3:+.0f} ms (measured, corrected)"
        for mate in mates
    )
