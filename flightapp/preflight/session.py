"""`flightapp preflight`: the checklist of one vehicle that stands on the ground, without flying it."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from flightapp.fleet.messages.command import Command
from flightapp.preflight.checklist import refuse_unknown, run_checklist
from flightapp.preflight.gathering import Gatherer
from flightapp.preflight.px4_parameters import Finding, findings
from flightapp.preflight.result import Level, Result
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.opening import Wish, open_rooms, running_loop

PERIOD_S = 0.2


@dataclass(frozen=True, slots=True)
class Written:
    """One parameter that was wrong: old value, the value to write, and what was read back (None: not written)."""

    name: str
    old: float | None
    wanted: float
    read_back: float | None
    reason: str


async def preflight(
    mission: Path,
    profile: Path,
    vehicle: str,
    *,
    waived: Collection[str],
    wait_s: float,
    may_write: Callable[[list[Finding]], bool] | None,
) -> tuple[list[Result], list[Written]]:
    """Results once nothing runs any more, at the latest after `wait_s`, and what was written.

    may_write: shown the wrong parameters before any is written, and asked; None writes none. InputError for bad files or an
    unknown waiver, FlightError without an autopilot.
    """
    with tempfile.TemporaryDirectory(prefix="flightapp-preflight-") as folder:
        wish = Wish(mission, profile, vehicle, Path(folder), seed=0)
        async with open_rooms(wish, Heartbeat(None)) as opened, running_loop(opened, _refuse) as loop:
            gatherer = Gatherer(opened.rooms, loop)
            await gatherer.read_parameters()
            await gatherer.plan_ways()
            written = [] if may_write is None else await _write(gatherer, may_write)
            clock = opened.rooms.clock
            deadline_s = clock.now_s() + wait_s
            while True:
                results = run_checklist(gatherer.facts(), waived)
                if not any(result.level is Level.RUNNING for result in results) or clock.now_s() > deadline_s:
                    break
                await asyncio.sleep(PERIOD_S)
            refuse_unknown(waived, results)
            return results, written


async def _write(gatherer: Gatherer, may_write: Callable[[list[Finding]], bool]) -> list[Written]:
    """Nothing is written to a vehicle that is armed."""
    facts = gatherer.facts()
    wrong = [finding for finding in findings(gatherer.needed, facts.parameters) if not finding.is_right]
    if not wrong or facts.status.armed or not may_write(wrong):
        return [Written(one.needed.name, one.value, one.needed.write, None, one.needed.reason) for one in wrong]
    return [
        Written(one.needed.name, one.value, one.needed.write, await gatherer.write_parameter(one.needed), one.needed.reason)
        for one in wrong
    ]


def _refuse(command: Command) -> tuple[bool, str]:
    return False, f"'{command.action}': this vehicle is in preflight, it does not fly"
