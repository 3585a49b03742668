"""The fleet at one moment as a person wants to see it: rows, leader, target, alarms, what happened."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from flightapp.config.mission import Mission
from flightapp.watch.data_model_alarms import Alarm, alarms_of
from flightapp.watch.data_model_events import Event, EventWatch
from flightapp.watch.data_model_heard import Heard
from flightapp.watch.data_model_leader import Leadership, leadership_of
from flightapp.watch.data_model_rows import Row, rows_of
from flightapp.watch.data_model_target import Target, target_of
from flightapp.watch.data_model_thresholds import Thresholds

EVENTS_KEPT = 50
GUARD_PAUSE_S = 1.0
"""A guard that acts again so soon has not stopped acting: near its limit it comes and goes."""


@dataclass(frozen=True, slots=True)
class Overview:
    """`events`: the newest last."""

    now_s: float
    mission: str
    fleet: str
    rows: tuple[Row, ...]
    leadership: Leadership
    target: Target | None
    alarms: tuple[Alarm, ...]
    events: tuple[Event, ...]

    @property
    def is_heard(self) -> bool:
        """Whether any vehicle ever was."""
        return any(row.state is not None for row in self.rows)


class FleetModel:
    """Remembers what a single look cannot tell: since when a guard acts, and what was different before."""

    def __init__(self, mission: Mission, digest: str, thresholds: Thresholds) -> None:
        self._mission, self._digest, self._thresholds = mission, digest, thresholds
        self._guards: dict[tuple[str, str], tuple[float, float]] = {}
        self._changes = EventWatch()
        self._events: deque[Event] = deque(maxlen=EVENTS_KEPT)

    def look(self, heard: Heard) -> Overview:
        """Times of `heard` do not go back from call to call."""
        leadership = leadership_of(heard)
        rows = rows_of(self._mission, heard, self._thresholds, leadership.leader, self._acting(heard))
        self._events += [Event(heard.now_s, text) for text in heard.complaints]
        self._events += self._changes.changes(heard.now_s, rows, leadership)
        return Overview(
            heard.now_s,
            self._mission.name,
            self._mission.fleet,
            rows,
            leadership,
            target_of(self._mission, heard, self._thresholds),
            alarms_of(rows, leadership, self._digest, self._thresholds),
            tuple(self._events),
        )

    def _acting(self, heard: Heard) -> dict[str, tuple[tuple[str, float], ...]]:
        """Guards by vehicle, with how long each has acted."""
        now_s = heard.now_s
        self._guards = {pair: (since, last) for pair, (since, last) in self._guards.items() if now_s - last <= GUARD_PAUSE_S}
        acting: dict[str, tuple[tuple[str, float], ...]] = {}
        for name, state in heard.states.items():
            for guard in state.guards:
                since_s, _ = self._guards.get((name, guard), (now_s, now_s))
                self._guards[name, guard] = since_s, now_s
            acting[name] = tuple((guard, now_s - self._guards[name, guard][0]) for guard in state.guards)
        return acting
