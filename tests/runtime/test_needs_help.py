"""A strategy that cannot go on by itself is kept hovering by the host, and the operator is warned."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.core.types import Decision, Observation
from flightapp.planning.api import STUCK
from flightapp.recording.reader import read_recording
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[2]


class Trapped:
    """Says `stuck` from its second second on, and after three more that it flies on."""

    def __init__(self) -> None:
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        self._begun_s: float | None = None
        self._mode = ""

    def step(self, observation: Observation) -> Decision:
        self._begun_s = observation.t_s if self._begun_s is None else self._begun_s
        mode = STUCK if 2.0 <= observation.t_s - self._begun_s < 5.0 else "pursue"
        reason, self._mode = (f"now {mode}" if mode != self._mode else ""), mode
        return Decision(np.zeros(3), None, 0.0, mode, None, reason)


def test_a_strategy_that_says_stuck_warns_the_operator_once(tmp_path: Path) -> None:
    begun_s: list[float] = []

    def watch(fleet: VirtualFleet) -> None:
        if fleet.vehicles["e1"].loop.phase == "pursue" or begun_s:
            begun_s.append(fleet.clock.now_s())
            if begun_s[-1] - begun_s[0] > 8.0:
                fleet.stop()

    mission, profile = ROOT / "missions/hover.toml", ROOT / "profiles/sim.toml"
    fly_virtual(mission, profile, tmp_path, seed=1, watch=watch, strategies={"e1": Trapped()}, time_limit_s=60.0)
    events = [one for one in read_recording(tmp_path / "e1.mcap").topic("/event").messages if one["name"] == "mode"]
    told = [(one["level"], one["text"]) for one in events]
    assert told == [("info", "pursue: now pursue"), ("warning", "stuck: now stuck"), ("info", "pursue: now pursue")]
