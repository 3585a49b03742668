"""The checklist on the ground: what converges is waited for, what failed ends the flight before it begins."""

from __future__ import annotations

from collections.abc import Collection

from flightapp.core.errors import FlightError
from flightapp.preflight.checklist import refuse_unknown, run_checklist
from flightapp.preflight.gathering import Gatherer
from flightapp.preflight.result import Level, Result
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.journal import Journal
from flightapp.runtime.pace import Pace
from flightapp.runtime.rooms import Rooms

TIMEOUT_S = 60.0
PERIOD_S = 0.2
STARTED_ALONE = ("team",)
"""Checks that a vehicle does not wait for on the ground: in the air it waits for its team, as the mission says."""


async def pass_checklist(rooms: Rooms, loop: ControlLoop, pace: Pace, waived: Collection[str]) -> None:
    """Go through the checklist until it is passed or waived; FlightError where a check fails or never settles."""
    gatherer = Gatherer(rooms, loop)
    await gatherer.read_parameters()
    await gatherer.plan_ways()
    deadline_s = rooms.clock.now_s() + TIMEOUT_S
    while True:
        results = run_checklist(gatherer.facts(), waived)
        running = [result for result in results if result.level is Level.RUNNING and result.check not in STARTED_ALONE]
        if any(result.level is Level.FAILED for result in results) or not running:
            break
        if rooms.clock.now_s() > deadline_s:
            raise FlightError(f"preflight: not ready within {TIMEOUT_S:g} s: {_told(running)}")
        await pace.tick(PERIOD_S)
    refuse_unknown(waived, results)
    _record(results, rooms.journal)
    failed = [result for result in results if result.level is Level.FAILED]
    if failed:
        raise FlightError(f"preflight: {_told(failed)}")


def _record(results: list[Result], journal: Journal) -> None:
    """The checklist as it was passed: waivers and warnings as events of their own."""
    for result in results:
        if result.level in (Level.WAIVED, Level.WARNING, Level.FAILED):
            text = f"{result.check} {result.level.word}: {result.found}"
            journal.event("warning", "preflight", text, check=result.check, result=result.level.word)
    passed = sum(result.level is Level.PASSED for result in results)
    journal.event("info", "preflight", f"{passed} of {len(results)} checks passed")


def _told(results: list[Result]) -> str:
    return "; ".join(f"{result.check}: {result.found}{f' -> {result.remedy}' if result.remedy else ''}" for result in results)
