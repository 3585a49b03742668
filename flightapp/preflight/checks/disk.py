"""Is there room for the recording?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "disk"
REASON = "a flight without a record answers no question afterwards"
BYTES_PER_S = 200e6 / 1200.0
"""The recorder's budget: 200 MB for 20 minutes without images."""
RESERVE_BYTES = 2e9


def judge(facts: Facts) -> tuple[Result, ...]:
    free = facts.computer.free_bytes
    needed = BYTES_PER_S * (facts.mission.time_limit_s + 600.0)
    found = f"{free / 1e9:.1f} GB free for {needed / 1e9:.2f} GB"
    if free < needed:
        return (Result(NAME, Level.FAILED, found, REASON, f"free space in {facts.profile.recording.folder}"),)
    if free < needed + RESERVE_BYTES:
        return (Result(NAME, Level.WARNING, found, REASON, f"free space in {facts.profile.recording.folder}"),)
    return (Result(NAME, Level.PASSED, found, REASON),)
