"""Does this machine's clock agree with the others'?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "clock"
REASON = "positions of teammates are aged by their stamps: 0.1 s is half a metre at 5 m/s"
AHEAD_MAX_S = 0.05
BEHIND_MAX_S = 0.5
MEASURED_AFTER_S = 5.0
"""A link that is slow now and then makes a clock look late: the quickest message of this time counts."""
SYNCHRONISE = "synchronise all machines with chrony (one of them as server)"


def judge(facts: Facts) -> tuple[Result, ...]:
    heard = [mate for mate in facts.teammates if mate.age_s is not None]
    wrong = [mate for mate in heard if mate.clock_ahead_s > AHEAD_MAX_S or mate.clock_ahead_s < -BEHIND_MAX_S]
    if wrong:
        found = ", ".join(f"{mate.name} {mate.clock_ahead_s * 1e3:+.0f} ms" for mate in wrong)
        level = Level.RUNNING if facts.waited_s < MEASURED_AFTER_S else Level.FAILED
        return (Result(NAME, level, found, REASON, SYNCHRONISE),)
    if facts.computer.clock_synchronised is False:
        level = Level.WARNING if len(facts.mission.vehicles) > 1 else Level.NOTED
        return (Result(NAME, level, "not synchronised by NTP or PTP", REASON, SYNCHRONISE),)
    found = ", ".join(f"{mate.name} {mate.clock_ahead_s * 1e3:+.0f} ms" for mate in heard) or "nobody to compare with"
    return (Result(NAME, Level.PASSED, found, REASON),)
