"""What deciding one recording again has shown, in numbers and in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flightapp.replay.difference import Difference

SHOWN = 10


@dataclass(frozen=True, slots=True)
class Replayed:
    """One vehicle. `what_if` is empty where the planner that flew was asked again."""

    file: str
    vehicle: str
    strategy: str
    complete: bool
    start_s: float
    duration_s: float
    decisions: int
    setpoints: int
    skipped: int
    """Periods whose obstacles the recorder has dropped: they cannot be decided again, and what follows may differ by that."""
    differences: tuple[Difference, ...]
    what_if: Mapping[str, Any]

    @property
    def identical(self) -> bool:
        return not self.differences

    def summary(self) -> dict[str, Any]:
        """Plain JSON values, without the list of differences."""
        decisions = [one for one in self.differences if one.of_decision]
        setpoints = [one for one in self.differences if one.of_setpoint]
        return {
            "file": self.file,
            "vehicle": self.vehicle,
            "strategy": self.strategy,
            "identical": self.identical,
            "complete": self.complete,
            "duration_s": self.duration_s,
            "decisions": self.decisions,
            "setpoints": self.setpoints,
            "skipped": self.skipped,
            "decisions_differ": len(decisions),
            "setpoints_differ": len(setpoints),
            "velocity_max_m_s": max((one.velocity_m_s for one in decisions), default=0.0),
            "setpoint_max_m_s": max((one.setpoint_m_s for one in setpoints), default=0.0),
            "first_decision": as_json(decisions[0]) if decisions else None,
            "first_setpoint": as_json(setpoints[0]) if setpoints else None,
            "what_if": self.what_if or None,
        }

    def all_differences(self) -> list[dict[str, Any]]:
        return [as_json(one) for one in self.differences]

    def text(self) -> str:
        """A few lines for a person."""
        counts = f"{self.decisions} decisions and {self.setpoints} setpoints in {self.duration_s:.1f} s"
        made = f"{self.vehicle} ({self.strategy}): {counts}"
        lines = [f"{made}: identical" if self.identical else f"{made}:"]
        if not self.identical:
            lines += self._differences()
        if not self.complete:
            lines.append("  the recording is cut off: decided again up to the cut")
        if self.skipped:
            lines.append(f"  {self.skipped} periods lack their obstacles and were left out: what follows them may differ by that")
        if self.what_if.get("decisions"):
            lines += _what_if_lines(self.what_if)
        return "\n".join(lines)

    def _differences(self) -> list[str]:
        decisions = [one for one in self.differences if one.of_decision]
        setpoints = [one for one in self.differences if one.of_setpoint]
        lines = []
        for word, ones, made in (("decisions", decisions, self.decisions), ("setpoints", setpoints, self.setpoints)):
            if ones:
                lines.append(f"  {len(ones)} of {made} {word} differ, first after {ones[0].t_s - self.start_s:.2f} s")
        lines += [f"  {one.t_s - self.start_s:8.2f} s  {_words(one)}" for one in self.differences[:SHOWN]]
        if len(self.differences) > SHOWN:
            lines.append(f"  ... and {len(self.differences) - SHOWN} more; --out FILE writes all of them")
        return lines


def as_json(one: Difference) -> dict[str, Any]:
    """Only what differs; an amount that is not a number is null."""
    plain = dataclasses.asdict(one)
    kept = {name: value for name, value in plain.items() if value not in (0.0, None, ())}
    return {name: None if value == float("inf") else value for name, value in {"t_s": one.t_s, **kept}.items()}


def _words(one: Difference) -> str:
    parts = []
    for amount, text in (
        (one.velocity_m_s, "velocity by {:.3g} m/s"),
        (one.yaw_rad, "yaw by {:.3g} rad"),
        (one.goal_m, "goal by {:.3g} m"),
        (one.setpoint_m_s, "setpoint by {:.3g} m/s"),
        (one.setpoint_yaw_rad, "its yaw by {:.3g} rad"),
        (one.setpoint_acceleration_m_s2, "its acceleration by {:.3g} m/s2"),
    ):
        if amount > 0.0:
            parts.append(text.format(amount))
    if one.mode is not None:
        parts.append(f"mode {one.mode[0]} -> {one.mode[1]}")
    if one.failure is not None:
        parts.append(f"{one.failure[0] or 'the planner worked'} -> {one.failure[1] or 'it works'}")
    if one.reason is not None and one.mode is None:
        parts.append("reason")
    if one.diagnostics:
        parts.append(f"diagnostics {', '.join(one.diagnostics)}")
    if one.guards is not None:
        then, now = map(_names, one.guards)
        parts.append(f"guards {then} -> {now}" if then != now else f"reasons of {now}")
    return ", ".join(parts)


def _names(acting: Sequence[tuple[str, str]]) -> str:
    return "+".join(name for name, _ in acting) or "none"


def _what_if_lines(found: Mapping[str, Any]) -> list[str]:
    lines = [f"  open loop: {found['open_loop']}"]
    lines.append(
        f"  velocity apart {found['velocity_apart_mean_m_s']:.2f} m/s on average; faster in {_percent(found['faster_share'])}, "
        f"slower in {_percent(found['slower_share'])}; closing in faster in {_percent(found['closing_faster_share'])}, "
        f"slower in {_percent(found['closing_slower_share'])} of the decisions"
    )
    for word, key in (("then", "modes_then"), ("now", "modes_now")):
        lines.append(f"  modes {word}: " + ", ".join(f"{mode} from {after_s:.1f} s" for after_s, mode in found[key][:SHOWN]))
    lines.append(
        "  apart each second, mean/max m/s: "
        + " ".join(f"{one['velocity_apart_mean_m_s']:.1f}/{one['velocity_apart_max_m_s']:.1f}" for one in found["seconds"])
    )
    return lines


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.0f} %"
