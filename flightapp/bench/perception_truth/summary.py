"""From scored trials to rates with intervals, errors and verdicts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from flightapp.bench.perception_truth.conditions import GOOD
from flightapp.bench.perception_truth.score import Score
from flightapp.bench.perception_truth.trials import RATE_HZ

SOLID_M = 0.05
SOLID_RANGE_M = 8.0
"""Something at least this thick and at most this far away must never stand in a sector that is reported free."""
SETTLING_FRAMES = 6
"""0.2 s: a thing that has just come into view may still be being confirmed; counted apart."""
_Z_95 = 1.96
_LISTED = 20

Summary = dict[str, Any]


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """95 % interval of a rate (Wilson's score interval); 0 to 1 without trials."""
    if trials == 0:
        return 0.0, 1.0
    rate, z2 = successes / trials, _Z_95**2
    centre = (rate + z2 / (2 * trials)) / (1 + z2 / trials)
    half = _Z_95 * math.sqrt(rate * (1 - rate) / trials + z2 / (4 * trials**2)) / (1 + z2 / trials)
    return max(0.0, centre - half), min(1.0, centre + half)


def summarise(scores: Sequence[Score]) -> Summary:
    """Everything that is reported, as plain numbers; what could not be measured is null."""
    of_kind = {
        kind: [one for one in scores if one.trial.kind == kind] for kind in ("width", "condition", "branch", "open", "moving")
    }
    poles = of_kind["width"] + of_kind["condition"]
    summary: Summary = {
        "frames": sum(one.trial.frames for one in scores),
        "detection": _cells(of_kind["width"]),
        "branch": _cells(of_kind["branch"]),
        "conditions": [_condition(list(group)) for _, group in groupby(of_kind["condition"], lambda one: one.trial.condition)],
        "false_discs": [_false_discs(list(group)) for _, group in groupby(of_kind["open"], lambda one: one.trial.condition)],
        "false_free": _false_free(poles),
        "position": _position([one for one in poles if one.trial.condition == GOOD]),
        "moving": _moving(of_kind["moving"]),
        "sectors": _sectors(scores),
    }
    summary["aims"] = [aim(summary) for aim in _AIMS]
    return summary


def _rate(values: Sequence[bool]) -> Summary:
    low, high = wilson(sum(values), len(values))
    return {"of": len(values), "rate": sum(values) / len(values) if values else None, "low": low, "high": high}


def _percentiles(values: Sequence[float]) -> Summary:
    measured = [value for value in values if math.isfinite(value)]
    if not measured:
        return {"of": 0, "p50": None, "p95": None}
    p50, p95 = (float(value) for value in np.percentile(np.abs(measured), (50, 95)))
    return {"of": len(measured), "p50": p50, "p95": p95}


def _cells(scores: Sequence[Score]) -> list[Summary]:
    """Detection by width and distance: in single frames, and held at the end of half a second."""

    def place(one: Score) -> tuple[float, float]:
        return one.trial.width_m, one.trial.distance_m

    out = []
    for (width, distance), group in groupby(sorted(scores, key=place), place):
        cell = list(group)
        out.append(
            {
                "width_m": width,
                "distance_m": distance,
                "frame": _rate([found for one in cell for found in one.found]),
                "half_second": _rate([one.held[-1] for one in cell]),
                "free_frames": sum(sum(one.is_free[SETTLING_FRAMES:]) for one in cell),
            }
        )
    return out


def _condition(scores: Sequence[Score]) -> Summary:
    return {
        "name": scores[0].trial.condition.name,
        "widths": [
            {"width_m": width, "frame": _rate([found for one in scores if one.trial.width_m == width for found in one.found])}
            for width in sorted({one.trial.width_m for one in scores})
        ],
        "surface_m": _percentiles([error for one in scores for error in one.surface_error_m]),
        "false_free": _false_free(scores),
        "false_discs_per_min": _per_minute(sum(sum(one.false_discs) for one in scores), sum(one.trial.frames for one in scores)),
        "moves_wrongly": _rate([moves for one in scores for moves in one.moves_wrongly]),
    }


def _false_discs(scores: Sequence[Score]) -> Summary:
    frames, discs = sum(one.trial.frames for one in scores), sum(sum(one.false_discs) for one in scores)
    return {
        "name": scores[0].trial.condition.name,
        "minutes": frames / RATE_HZ / 60,
        "discs": discs,
        "per_minute": _per_minute(discs, frames),
    }


def _false_free(scores: Sequence[Score]) -> Summary:
    """Frames in which a solid thing within range was neither a disc nor unseen."""
    frames, settling, found = 0, 0, []
    for one in scores:
        if one.trial.width_m < SOLID_M:
            continue
        for number, (distance, is_free) in enumerate(zip(one.distance_m, one.is_free, strict=True)):
            if distance > SOLID_RANGE_M:
                continue
            frames += 1
            if not is_free:
                continue
            if number < SETTLING_FRAMES:
                settling += 1
            else:
                trial = one.trial
                found.append(
                    {"condition": trial.condition.name, "width_m": trial.width_m, "distance_m": round(distance, 2)}
                    | {"seed": trial.seed, "frame": number, "is_remembered": one.held[number]}
                )
    return {
        "minutes": frames / RATE_HZ / 60,
        "frames": len(found),
        "per_minute": _per_minute(len(found), frames),
        "frames_settling": settling,
        "list": found[:_LISTED],
    }


def _position(scores: Sequence[Score]) -> list[Summary]:
    """Errors by distance, of everything at least as wide as a tree."""
    out = []
    for low, high in ((0.0, 2.5), (2.5, 4.5), (4.5, 6.5), (6.5, 10.0)):
        there = [one for one in scores if low <= one.trial.distance_m < high]
        named: Summary = {"from_m": low, "to_m": high}
        for name in ("surface_error_m", "centre_error_m", "radius_error_m"):
            named[name] = _percentiles([error for one in there for error in getattr(one, name)])
        out.append(named)
    return out


def _moving(scores: Sequence[Score]) -> list[Summary]:
    """The second half of each flight of the ball: by then its velocity should be known."""

    def speed(one: Score) -> float:
        return one.trial.ball_speed_m_s

    out = []
    for value, group in groupby(sorted(scores, key=speed), speed):
        balls = list(group)
        late = [(one, number) for one in balls for number in range(one.trial.frames // 2, one.trial.frames)]
        out.append(
            {
                "speed_m_s": value,
                "frame": _rate([found for one in balls for found in one.found]),
                "velocity_error_m_s": _percentiles([one.velocity_error_m_s[number] for one, number in late]),
                "ghosts_per_min": _per_minute(sum(sum(one.false_discs) for one in balls), sum(one.trial.frames for one in balls)),
            }
        )
    return out


def _sectors(scores: Sequence[Score]) -> Summary:
    def share(pairs: list[tuple[int, int]]) -> float | None:
        total = sum(pair[1] for pair in pairs)
        return sum(pair[0] for pair in pairs) / total if total else None

    return {
        "outside_reported_seen": share([pair for one in scores for pair in one.seen_wrongly]),
        "inside_reported_unseen": share([pair for one in scores for pair in one.unseen_wrongly]),
    }


def _per_minute(count: int, frames: int) -> float | None:
    return count * RATE_HZ * 60 / frames if frames else None


def _aim(name: str, value: float | None, aim: float, *, at_least: bool) -> Summary:
    verdict = "not measured"
    if value is not None:
        verdict = "met" if (value >= aim if at_least else value <= aim) else "missed"
    return {"name": name, "value": value, "aim": aim, "at_least": at_least, "verdict": verdict}


def _found(summary: Summary, width_m: float, distance_m: float, kind: str) -> float | None:
    for cell in summary["detection"]:
        if (cell["width_m"], cell["distance_m"]) == (width_m, distance_m):
            rate: float | None = cell[kind]["rate"]
            return rate
    return None


def _branch_at(summary: Summary, distance_m: float) -> float | None:
    rates = [cell["half_second"]["rate"] for cell in summary["branch"] if cell["distance_m"] == distance_m]
    return rates[0] if rates else None


def _worst_invention(summary: Summary) -> float | None:
    return max((one["per_minute"] for one in summary["false_discs"]), default=None)


def _worst_velocity(summary: Summary) -> float | None:
    errors = [one["velocity_error_m_s"]["p50"] for one in summary["moving"]]
    return max((one for one in errors if one is not None), default=None)


_AIMS: tuple[Callable[[Summary], Summary], ...] = (
    lambda s: _aim("50 cm at 4 m found, share of frames", _found(s, 0.5, 4.0, "frame"), 0.95, at_least=True),
    lambda s: _aim("3 cm at 5 m held after 0.5 s", _found(s, 0.03, 5.0, "half_second"), 0.95, at_least=True),
    lambda s: _aim("5 cm at 8 m held after 0.5 s", _found(s, 0.05, 8.0, "half_second"), 0.95, at_least=True),
    lambda s: _aim("4 cm branch at 4 m held after 0.5 s", _branch_at(s, 4.0), 0.95, at_least=True),
    lambda s: _aim("solid things in free sectors a minute", s["false_free"]["per_minute"], 0.0, at_least=False),
    lambda s: _aim("false discs a minute, worst open field", _worst_invention(s), 0.0, at_least=False),
    lambda s: _aim(
        "surface within 2.5-4.5 m, p95 of the error in m", s["position"][1]["surface_error_m"]["p95"], 0.2, at_least=False
    ),
    lambda s: _aim("velocity of a ball, median error in m/s", _worst_velocity(s), 0.5, at_least=False),
    lambda s: _aim("bearings outside the picture reported seen", s["sectors"]["outside_reported_seen"], 0.0, at_least=False),
)
