"""Are the autopilot's parameters those that a pursuit needs? One result a parameter, under its own name."""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.px4_parameters import Finding, findings, needed_parameters
from flightapp.preflight.result import Level, Result


def judge(facts: Facts) -> tuple[Result, ...]:
    needed = needed_parameters(facts.mission, facts.profile, facts.vehicle)
    found = findings(needed, facts.parameters)
    if len(found) < len(needed):
        reading = Result(
            "parameters", Level.RUNNING, f"{len(found)} of {len(needed)} read", "they decide who has control", "wait"
        )
        return (reading, *(_result(one) for one in found))
    return tuple(_result(one) for one in found)


def _result(finding: Finding) -> Result:
    rule = finding.needed
    if finding.value is None:
        if finding.is_right:
            return Result(rule.name, Level.SKIPPED, "not in this version of the autopilot", rule.reason)
        return Result(rule.name, Level.FAILED, "the autopilot does not answer for it", rule.reason, "check the link; try again")
    text = f"{int(finding.value)}" if rule.is_integer else f"{finding.value:g}"
    if finding.is_right:
        return Result(rule.name, Level.PASSED, text, rule.reason)
    level = Level.FAILED if rule.must else Level.WARNING
    return Result(rule.name, level, f"{text}, wanted {rule.wanted}", rule.reason, "set it, or let --write-parameters do it")
