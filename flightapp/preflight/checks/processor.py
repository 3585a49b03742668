"""Does the processor run at full speed?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "cpu-governor"
REASON = "a processor that saves power wakes up too late for a control period"
GOOD = ("performance",)


def judge(facts: Facts) -> tuple[Result, ...]:
    governors = facts.computer.governors
    if not governors:
        return (Result(NAME, Level.SKIPPED, "this machine does not tell", REASON),)
    found = ", ".join(governors)
    if all(governor in GOOD for governor in governors):
        return (Result(NAME, Level.PASSED, found, REASON),)
    return (Result(NAME, Level.WARNING, found, REASON, "sudo cpupower frequency-set -g performance"),)
