"""Then and now of one control period: whether they differ, in what, and by how much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import orjson

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Decision
from flightapp.recording.messages import DecisionRecord
from flightapp.recording.schema import encoder_of
from flightapp.replay.deciding import Decided
from flightapp.replay.flight import Tick

_ENCODE = encoder_of(DecisionRecord)


@dataclass(frozen=True, slots=True)
class Difference:
    """One period that is decided differently. Amounts are 0 where a thing is the same; infinite where only one has a number.

    mode, failure, guards: (then, now) where they differ, else None. guards are [name, reason]. diagnostics: the keys that both
    have and that differ.
    """

    t_s: float
    velocity_m_s: float = 0.0
    yaw_rad: float = 0.0
    goal_m: float = 0.0
    mode: tuple[str, str] | None = None
    reason: tuple[str, str] | None = None
    failure: tuple[str, str] | None = None
    diagnostics: tuple[str, ...] = ()
    setpoint_m_s: float = 0.0
    setpoint_yaw_rad: float = 0.0
    setpoint_acceleration_m_s2: float = 0.0
    guards: tuple[tuple[tuple[str, str], ...], tuple[tuple[str, str], ...]] | None = field(default=None)

    @property
    def of_decision(self) -> bool:
        """Whether the planner decided differently."""
        words = self.mode or self.reason or self.failure or self.diagnostics
        return bool(words) or max(self.velocity_m_s, self.yaw_rad, self.goal_m) > 0.0

    @property
    def of_setpoint(self) -> bool:
        """Whether the supervisor sends something else, or says something else about it."""
        amounts = (self.setpoint_m_s, self.setpoint_yaw_rad, self.setpoint_acceleration_m_s2)
        return self.guards is not None or max(amounts) > 0.0


def difference(tick: Tick, now: Decided, tolerance: float) -> Difference | None:
    """What differs in one period; None if nothing does by more than `tolerance` (m/s, rad, m, and numbers of diagnostics)."""
    found: dict[str, object] = {}
    then_failed = "the planner failed" if tick.planned and tick.decision is None else ""
    if bool(then_failed) != bool(now.failure):
        found["failure"] = (then_failed, now.failure)
    if tick.decision is not None and now.decision is not None:
        found |= _of_decision(tick.decision, now.decision, tolerance)
    if tick.sent is not None:
        found |= _of_setpoint(tick, now, tolerance)
    if not found:
        return None
    return Difference(tick.t_s, **found)  # type: ignore[arg-type]


def _of_decision(then: Decision, now: Decision, tolerance: float) -> dict[str, object]:
    found: dict[str, object] = _amounts(
        tolerance,
        velocity_m_s=_apart(then.velocity_ned_m_s, now.velocity_ned_m_s),
        yaw_rad=_turned(then.yaw_rad, now.yaw_rad),
        goal_m=_apart(then.goal_ned_m, now.goal_ned_m),
    )
    if then.mode != now.mode:
        found["mode"] = (then.mode, now.mode)
    if then.reason != now.reason and tolerance == 0.0:
        found["reason"] = (then.reason, now.reason)
    said = orjson.loads(_ENCODE(dict(now.diagnostics)))
    keys = tuple(key for key in then.diagnostics if key in said and not _same(then.diagnostics[key], said[key], tolerance))
    if keys:
        found["diagnostics"] = keys
    return found


def _of_setpoint(tick: Tick, now: Decided, tolerance: float) -> dict[str, object]:
    assert tick.sent is not None
    then, sent = tick.sent.setpoint, now.supervised.setpoint
    found: dict[str, object] = _amounts(
        tolerance,
        setpoint_m_s=_apart(then.velocity_ned_m_s, sent.velocity_ned_m_s),
        setpoint_yaw_rad=_turned(then.yaw_rad, sent.yaw_rad),
        setpoint_acceleration_m_s2=_apart(then.acceleration_ned_m_s2, sent.acceleration_ned_m_s2),
    )
    before, after = tick.sent.acting, now.supervised.acting
    # With a tolerance the reasons do not count: they tell numbers, and rounding them hides or shows the last digit.
    texts_differ = before != after if tolerance == 0.0 else [name for name, _ in before] != [name for name, _ in after]
    if texts_differ:
        found["guards"] = (before, after)
    return found


def _amounts(tolerance: float, **amounts: float) -> dict[str, object]:
    return {name: amount for name, amount in amounts.items() if amount > tolerance}


def _apart(then: Array | None, now: Array | None) -> float:
    if then is None or now is None:
        return 0.0 if then is now else float("inf")
    if np.array_equal(then, now, equal_nan=True):
        return 0.0
    apart = float(np.linalg.norm(then - now))
    return apart if np.isfinite(apart) else float("inf")


def _turned(then: float, now: float) -> float:
    if then == now or (np.isnan(then) and np.isnan(now)):
        return 0.0
    return abs(wrap_pi(then - now)) if np.isfinite(then - now) else float("inf")


def _same(then: object, now: object, tolerance: float) -> bool:
    """Whether two plain JSON values are the same; keys that only one has do not count."""
    if isinstance(then, bool) or isinstance(now, bool):
        return then is now
    if isinstance(then, (int, float)) and isinstance(now, (int, float)):
        return then == now or abs(then - now) <= tolerance
    if isinstance(then, list) and isinstance(now, list):
        return len(then) == len(now) and all(_same(a, b, tolerance) for a, b in zip(then, now, strict=True))
    if isinstance(then, Mapping) and isinstance(now, Mapping):
        return all(_same(value, now[key], tolerance) for key, value in then.items() if key in now)
    return then == now
