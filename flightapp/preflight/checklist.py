"""The checklist: every check in the order in which a person would go through it, and waivers by name."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

from flightapp.core.errors import InputError
from flightapp.preflight.checks import (
    autopilot_parameters,
    autopilot_version,
    battery,
    camera,
    certificates,
    clock,
    disk,
    fence,
    fleet_links,
    link,
    place,
    planned_ways,
    position,
    processor,
    ready_to_arm,
    storage,
    system_id,
    team,
    transmitter,
    velocity_loop,
)
from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

Check = Callable[[Facts], tuple[Result, ...]]

CHECKS: tuple[Check, ...] = (
    link.judge,
    autopilot_version.judge,
    system_id.judge,
    ready_to_arm.judge,
    transmitter.judge,
    position.judge,
    place.judge,
    battery.judge,
    fence.judge,
    autopilot_parameters.judge,
    velocity_loop.judge,
    camera.judge,
    planned_ways.judge,
    team.judge,
    certificates.judge,
    fleet_links.judge,
    clock.judge,
    disk.judge,
    storage.judge,
    processor.judge,
)


def run_checklist(facts: Facts, waived: Collection[str] = ()) -> list[Result]:
    """Every result; what failed and is named in `waived` is waived. What still runs cannot be waived: it is waited for."""
    return [_waive(result, waived) for check in CHECKS for result in check(facts)]


def refuse_unknown(waived: Collection[str], results: Collection[Result]) -> None:
    """InputError where a waiver names no check: a spelling mistake must not look like a waiver."""
    names = [result.check for result in results]
    for name in waived:
        if name not in names:
            raise InputError(f"--waive = '{name}': no such check; known: {', '.join(dict.fromkeys(names))}")


def _waive(result: Result, waived: Collection[str]) -> Result:
    if result.level is Level.FAILED and result.check in waived:
        return replace(result, level=Level.WAIVED)
    return result
