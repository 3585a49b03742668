"""The paths that a planner's search weighed, into the recording a few times a second; planners without a search have none."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import cast

from flightapp.core.types import Observation
from flightapp.planning.ac2f.candidates import Candidates
from flightapp.planning.api import Planner
from flightapp.runtime.journal import Journal

PERIOD_S = 0.2


class SearchRecord:
    """Asks the planner after a decision, where it can tell and it is time again."""

    def __init__(self, planner: Planner, journal: Journal) -> None:
        self._ask = cast("Callable[[], Candidates | None] | None", getattr(planner, "candidates", None))
        self._journal = journal
        self._due_s = -math.inf

    def note(self, observation: Observation) -> None:
        """Called after every decision on `observation`."""
        if self._ask is None or observation.t_s < self._due_s:
            return
        found = self._ask()
        if found is not None:
            self._due_s = observation.t_s + PERIOD_S
            self._journal.candidates(found, observation.own, observation.t_s)
