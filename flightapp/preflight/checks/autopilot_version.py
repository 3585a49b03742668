"""Is the autopilot one that this app was written for?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "autopilot"
REASON = "modes, parameters and failsafes are those of PX4 from 1.12 on"
OLDEST = (1, 12)
ANSWER_S = 5.0


def judge(facts: Facts) -> tuple[Result, ...]:
    details = facts.details
    if details.autopilot not in ("", "PX4"):
        return (Result(NAME, Level.FAILED, details.autopilot, REASON, "fly a PX4 autopilot"),)
    if details.version is None:
        level = Level.RUNNING if facts.waited_s < ANSWER_S else Level.WARNING
        return (Result(NAME, level, "version unknown", REASON, "ask for AUTOPILOT_VERSION in a ground station"),)
    text = "PX4 " + ".".join(str(part) for part in details.version)
    if details.version[:2] < OLDEST:
        return (Result(NAME, Level.FAILED, text, REASON, "update the firmware to 1.12 or newer"),)
    return (Result(NAME, Level.PASSED, text, REASON),)
