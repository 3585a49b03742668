"""What another planner would have decided in a flight that it did not fly.

Open loop: it sees what the one that flew has brought about, not what its own decisions would have. Where it differs for long, the
situations are no longer its own, and these numbers say in which direction it leans, not how it would have ended.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Decision
from flightapp.replay.deciding import Decided
from flightapp.replay.flight import Tick

CLEARLY_M_S = 0.1
"""Speeds that differ by less count as equal."""


@dataclass(frozen=True, slots=True)
class Compared:
    """One decision of both."""

    t_s: float
    apart_m_s: float
    faster_m_s: float
    closing_faster_m_s: float | None
    """Speed towards the target; None without one."""
    modes: tuple[str, str]


def compared(tick: Tick, now: Decided) -> Compared | None:
    """None where one of them decided nothing that can be compared."""
    then, other = tick.decision, now.decision
    if then is None or other is None or tick.given is None:
        return None
    apart = float(np.linalg.norm(other.velocity_ned_m_s - then.velocity_ned_m_s))
    if not math.isfinite(apart):
        return None
    return Compared(tick.t_s, apart, _speed(other) - _speed(then), _closing(tick, other, then), (then.mode, other.mode))


def what_if(decisions: Sequence[Compared]) -> dict[str, object]:
    """Divergence a second, the modes of both, and how often the other would have been clearly faster or closed in faster."""
    if not decisions:
        return {"decisions": 0}
    start_s = decisions[0].t_s
    seconds: dict[int, list[float]] = {}
    for one in decisions:
        seconds.setdefault(int(one.t_s - start_s), []).append(one.apart_m_s)
    closing = [one.closing_faster_m_s for one in decisions if one.closing_faster_m_s is not None]
    return {
        "open_loop": "it saw what the planner that flew brought about, not what its own decisions would have",
        "decisions": len(decisions),
        "velocity_apart_mean_m_s": float(np.mean([one.apart_m_s for one in decisions])),
        "faster_share": _share([one.faster_m_s for one in decisions]),
        "slower_share": _share([-one.faster_m_s for one in decisions]),
        "closing_faster_share": _share(closing),
        "closing_slower_share": _share([-value for value in closing]),
        "other_mode_share": float(np.mean([one.modes[0] != one.modes[1] for one in decisions])),
        "seconds": [
            {"second": second, "velocity_apart_mean_m_s": float(np.mean(values)), "velocity_apart_max_m_s": max(values)}
            for second, values in seconds.items()
        ],
        "modes_then": _timeline([(one.t_s - start_s, one.modes[0]) for one in decisions]),
        "modes_now": _timeline([(one.t_s - start_s, one.modes[1]) for one in decisions]),
    }


def _speed(decision: Decision) -> float:
    north, east, _ = decision.velocity_ned_m_s.tolist()
    return math.hypot(north, east)


def _closing(tick: Tick, other: Decision, then: Decision) -> float | None:
    assert tick.given is not None
    seen = tick.given.observation
    if seen.target is None:
        return None
    north, east, _ = (seen.target.position_ned_m - seen.own.position_ned_m).tolist()
    distance = math.hypot(north, east)
    if distance == 0.0:
        return None
    gain = other.velocity_ned_m_s - then.velocity_ned_m_s
    return float(gain[0] * north + gain[1] * east) / distance


def _share(gains_m_s: Sequence[float]) -> float | None:
    return sum(gain > CLEARLY_M_S for gain in gains_m_s) / len(gains_m_s) if gains_m_s else None


def _timeline(modes: Sequence[tuple[float, str]]) -> list[list[object]]:
    """[seconds after the first decision, mode] of every change."""
    changes: list[list[object]] = []
    for after_s, mode in modes:
        if not changes or changes[-1][1] != mode:
            changes.append([round(after_s, 3), mode])
    return changes
