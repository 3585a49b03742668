"""Does the disk take the recording as fast as it comes?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "storage"
REASON = "a power cut costs what is not on the disk, and a slow disk costs channels"
FLUSH_WARNING_S = 0.2
FLUSH_MAX_S = 2.0
_REMEDY = "use another disk for recording.folder, or find what else writes to this one"


def judge(facts: Facts) -> tuple[Result, ...]:
    recorder = facts.recorder
    if recorder is None:
        return (Result(NAME, Level.SKIPPED, "nothing is recorded", REASON),)
    if recorder.error is not None:
        return (Result(NAME, Level.FAILED, recorder.error, REASON, "make recording.folder writable, with room"),)
    found = f"slowest flush {recorder.flush_slowest_s * 1e3:.0f} ms"
    if recorder.flush_slowest_s > FLUSH_MAX_S:
        return (Result(NAME, Level.FAILED, found, REASON, _REMEDY),)
    if recorder.flush_slowest_s > FLUSH_WARNING_S:
        return (Result(NAME, Level.WARNING, found, REASON, _REMEDY),)
    return (Result(NAME, Level.PASSED, found, REASON),)
