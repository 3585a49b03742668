"""Does a controller over the autopilot's velocity loop count on the gains that this autopilot has? One result a gain.

Never written by the app: they belong to the tuning of the vehicle.
"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result
from flightapp.vehicle.velocity_gains import PLANAR, VERTICAL, is_usable

REASON = "aadrc-smc adds to what the autopilot's own velocity loop does"
SAME_SHARE = 0.02


def judge(facts: Facts) -> tuple[Result, ...]:
    """Nothing where the loop is alone: then nobody asked for its gains."""
    assumed = facts.profile.control.tracking
    return tuple(
        _result(name, facts.parameters[name], value, field)
        for name, value, field in (
            (PLANAR, assumed.velocity_gain_1_s, "velocity_gain_1_s"),
            (VERTICAL, assumed.vertical_gain_1_s, "vertical_gain_1_s"),
        )
        if name in facts.parameters
    )


def _result(name: str, found: float | None, assumed: float, field: str) -> Result:
    if found is None or not is_usable(found):
        text = f"{'not answered' if found is None else f'{found:g}'}, the profile's {assumed:g} counts"
        return Result(name, Level.WARNING, text, REASON, "check it in a ground station")
    if abs(found - assumed) <= SAME_SHARE * assumed:
        return Result(name, Level.PASSED, f"{found:g}", REASON)
    text = f"{found:g}, the profile says {assumed:g}: the autopilot's counts"
    return Result(name, Level.WARNING, text, REASON, f"write control.tracking.{field} = {found:g} into the profile, or retune")
