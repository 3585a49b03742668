"""The election inside the vehicle processes, on the virtual clock: the leader of a pursuit dies in the chase."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.core.types import Decision, Observation
from flightapp.recording.reader import read_recording
from flightapp.runtime.control_loop import ControlLoop
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
PURSUERS = ("p1", "p2", "p3")
THIRD_PURSUER = """
[[vehicles]]
name = "p3"
role = "pursuer"
system_id = 4
start = { north_m = 0.0, east_m = 0.0, heading_deg = 0.0 }
strategy = { name = "ac2f" }

[[vehicles]]
name = "e1"
"""
CHASED_S = 0.5
FAILOVER_MAX_S = 1.5


class Stands:
    """Instead of the mission's strategies, whose reckoning is most of the cost of a flight and has no part in this."""

    def step(self, observation: Observation) -> Decision:
        return Decision(np.zeros(3), None, observation.own.yaw_rad, "standing", None, "", {})

    def reset(self, seed: int | None = None) -> None:
        """There is nothing to forget."""


class LeaderDies:
    """Watches a fleet; the process of the leader is killed in the pursuit, soon after all has been seen."""

    def __init__(self) -> None:
        self.killed: str | None = None
        self.killed_s = self.pursuing_s = self.replaced_s = float("inf")
        self.voices_max = 0
        self.leader: str | None = None
        self.terms: list[int] = []

    def __call__(self, fleet: VirtualFleet) -> None:
        now_s = fleet.clock.now_s()
        loops = {name: fleet.vehicles[name].loop for name in PURSUERS if name != self.killed}
        voices = [name for name, loop in loops.items() if loop.leadership.is_leader(now_s)]
        self.voices_max = max(self.voices_max, len(voices))
        if self.pursuing_s > now_s and all(loop.phase == "pursue" for loop in loops.values()):
            self.pursuing_s = now_s
        if self.killed is None and now_s > self.pursuing_s + CHASED_S:
            self._kill(fleet, loops, voices, now_s)
        elif self.killed is not None and voices and self.replaced_s > now_s:
            self.replaced_s = now_s
            self.leader = voices[0]
        if now_s > self.killed_s + FAILOVER_MAX_S + 0.1:
            self.terms.append(loops[voices[0]].leadership.term)
            fleet.stop()

    def _kill(self, fleet: VirtualFleet, loops: dict[str, ControlLoop], voices: list[str], now_s: float) -> None:
        (self.killed,) = voices
        assert {loop.leadership.leader for loop in loops.values()} == {self.killed}
        self.terms.append(loops[self.killed].leadership.term)
        fleet.vehicles[self.killed].kill()
        self.killed_s = now_s


def test_a_leader_that_dies_in_the_chase_is_replaced_and_recordings_tell(tmp_path: Path) -> None:
    demo = (ROOT / "missions/demo_two_pursuers.toml").read_text()
    mission = tmp_path / "three.toml"
    mission.write_text(demo.replace('\n[[vehicles]]\nname = "e1"\n', THIRD_PURSUER))
    story = LeaderDies()
    fly_virtual(mission, SIM, tmp_path, watch=story, strategies={name: Stands() for name in (*PURSUERS, "e1")})
    assert story.leader not in (None, story.killed)
    assert story.replaced_s - story.killed_s < FAILOVER_MAX_S
    assert story.voices_max == 1
    assert story.terms[1] > story.terms[0]
    follower = next(name for name in PURSUERS if name not in (story.killed, story.leader))
    events = read_recording(tmp_path / f"{follower}.mcap").topic("/event").messages
    told = [event["text"] for event in events if event["name"] == "leader"]
    assert f"{story.killed} leads in term {story.terms[0]}" in told
    assert told[-1] == f"{story.leader} leads in term {story.terms[1]}"
