"""The other vehicles as one machine knows them: of each the newest state and intent, and what went wrong on the way."""

from __future__ import annotations

from flightapp.fleet.admission import Admission, Verdict
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.state import STATE
from flightapp.fleet.post import Post
from flightapp.fleet.shared_state import SharedState, join


class Peer:
    """One other vehicle. `state` is None until a state and an intent of it were heard."""

    def __init__(self, admission: Admission) -> None:
        self._admission = admission
        self.state: SharedState | None = None

    @property
    def taken(self) -> int:
        """States that were taken."""
        return self._admission.counts[Verdict.TAKEN]

    @property
    def lost(self) -> int:
        return self._admission.lost

    @property
    def rejected(self) -> int:
        return self._admission.rejected

    @property
    def ahead_s(self) -> float:
        """How far its newest state, taken or not, was stamped ahead of the own clock, after correction."""
        return self._admission.ahead_s


class Peers:
    """Polled; keeps the newest only."""

    def __init__(self, post: Post) -> None:
        self._states, self._intents = post.inlet(STATE, addressed=True), post.inlet(INTENT)
        self._intent_of: dict[str, Intent] = {}
        self.by_name = {name: Peer(admission) for name, admission in self._states.senders.items()}

    def poll(self, now_s: float) -> None:
        """Take what arrived since the last poll."""
        for vehicle, intent in self._intents.take(now_s):
            self._intent_of[vehicle] = intent
        for vehicle, state in self._states.take(now_s):
            header, known = self._states.senders[vehicle].newest, self._intent_of.get(vehicle)
            if header is not None and known is not None:
                self.by_name[vehicle].state = join(header, state, known)
