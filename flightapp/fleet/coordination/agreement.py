"""When the evader counts as captured for all: each pursuer judges by its own view, and the leader announces it.

A view counts only if it has seen everybody encircle who is assigned: who lost sight of an assigned teammate cannot vouch for it.
The leader announces as soon as most of the assigned hold that view, also where its own is missing: it may be held by a failsafe,
or not fly at all. Where nobody leads, everybody who holds it concludes the same once most of the assigned do.

Who has dropped out is assigned no longer, once a leader has planned without it; before that, and while nobody leads, its place
stays open and its voice is missing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from flightapp.fleet.coordination.core import Voice

VERDICT_AGE_MAX_S = 0.5


@dataclass(frozen=True, slots=True)
class Verdict:
    """One pursuer's view that the evader is captured."""

    by: frozenset[str]
    """Everybody, itself included, whom it has seen encircle for the dwell time."""


@dataclass(frozen=True, slots=True)
class Capture:
    """What was agreed."""

    by: tuple[str, ...]
    """The assigned pursuers that encircle."""
    agreed: tuple[str, ...]
    """Those of them whose view was known to whoever concluded it."""


class Agreement:
    """One vehicle's part; of the others it keeps the newest verdict."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._heard: dict[str, tuple[float, Verdict]] = {}

    def step(
        self,
        now_s: float,
        voice: Voice,
        assigned: Iterable[str],
        own: Verdict | None,
        inbox: Iterable[tuple[str, Verdict]],
    ) -> Capture | None:
        """The agreed capture, if this vehicle may conclude it now. own: what this vehicle itself judges."""
        for sender, verdict in inbox:
            self._heard[sender] = now_s, verdict
        needed = frozenset(assigned)
        held = {name: verdict for name, (at_s, verdict) in self._heard.items() if now_s - at_s <= VERDICT_AGE_MAX_S}
        if own is not None:
            held[self._name] = own
        agreed = {name for name, verdict in held.items() if name in needed and verdict.by >= needed}
        may_conclude = voice.is_own if voice.leader is not None else self._name in agreed
        if not may_conclude or 2 * len(agreed) <= len(needed):
            return None
        return Capture(tuple(sorted(needed)), tuple(sorted(agreed)))
