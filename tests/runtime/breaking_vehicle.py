"""The real vehicle process with a strategy that breaks: after two seconds at 3 m/s it does what FAILURE says.

Run as a script: FAILURE (not-finite, endless), then the arguments of `flightapp.runtime.vehicle_process`.
"""

import sys

import numpy as np

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning import registry
from flightapp.runtime.vehicle_process import main

GOOD_FOR_S = 2.0


class Breaking:
    """Flies north, then breaks."""

    def __init__(self, failure: str) -> None:
        self._failure = failure
        self._started_s: float | None = None

    def reset(self, seed: int | None = None) -> None:
        self._started_s = None

    def step(self, observation: Observation) -> Decision:
        started_s = self._started_s = observation.t_s if self._started_s is None else self._started_s
        velocity = np.array([3.0, 0.0, 0.0])
        if observation.t_s - started_s > GOOD_FOR_S:
            while self._failure == "endless":
                pass
            velocity = np.array([np.nan, np.inf, 0.0])
        return Decision(velocity, None, 0.0, "breaking", None)


def build(_name: str, _limits: Limits, _given: object, _seed: int) -> Breaking:
    return Breaking(FAILURE)


if __name__ == "__main__":
    FAILURE = sys.argv[1]
    registry.EVADERS = {**registry.EVADERS, "hover": __name__}
    sys.exit(main(sys.argv[2:]))
