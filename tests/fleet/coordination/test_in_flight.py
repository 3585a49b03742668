"""The plan and the capture inside the vehicle processes, on the virtual clock: the leader dies in the chase, two finish it."""

from __future__ import annotations

from pathlib import Path

from flightapp.analysis.run import load_run
from flightapp.analysis.summary import summarise
from flightapp.recording.reader import read_recording
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual
from tests.fleet.coordination.chase import PURSUERS, SIM, chase_of_three

CHASED_S = 2.0
"""Of the pursuit before the leader dies."""
FAILOVER_MAX_S = 3.0


class LeaderDies:
    """Watches a fleet; kills the leader's process in the chase, and stops when all that are left have an outcome."""

    def __init__(self) -> None:
        self.killed: str | None = None
        self.pursuing_s = self.killed_s = self.planned_s = float("inf")
        self.outcomes: dict[str, str] = {}
        self.ended_s: dict[str, float] = {}
        self.members_before: set[tuple[str, ...]] = set()

    def __call__(self, fleet: VirtualFleet) -> None:
        now_s = fleet.clock.now_s()
        loops = {name: fleet.vehicles[name].loop for name in PURSUERS if name != self.killed}
        if self.pursuing_s > now_s and all(loop.phase == "pursue" for loop in loops.values()):
            self.pursuing_s = now_s
        if self.killed is None and now_s > self.pursuing_s + CHASED_S:
            (self.killed,) = (name for name, loop in loops.items() if loop.leadership.is_leader(now_s))
            self.members_before = {loop.coordination.plan.members for loop in loops.values() if loop.coordination.plan}
            fleet.vehicles[self.killed].kill()
            self.killed_s = now_s
            return
        plans = [loop.coordination.plan for loop in loops.values()]
        if self.killed and self.planned_s > now_s and all(plan and self.killed not in plan.members for plan in plans):
            self.planned_s = now_s
        for name in (*loops, "e1"):
            outcome = fleet.vehicles[name].loop.outcome
            if outcome is not None and name not in self.outcomes:
                self.outcomes[name], self.ended_s[name] = outcome, now_s
        if self.killed and len(self.outcomes) == len(loops) + 1:
            fleet.stop()


def test_two_finish_what_three_began_when_the_leader_dies_in_the_chase(tmp_path: Path) -> None:
    story = LeaderDies()
    fly_virtual(chase_of_three(tmp_path), SIM, tmp_path, watch=story)
    assert story.members_before == {PURSUERS}, "all three were in the plan of everybody when the leader died"
    assert story.planned_s - story.killed_s < FAILOVER_MAX_S
    assert set(story.outcomes.values()) == {"captured"}, story.outcomes
    assert max(story.ended_s.values()) - min(story.ended_s.values()) < 0.3, "one decision ends it for all"
    left = [name for name in PURSUERS if name != story.killed]
    told = {name: read_recording(tmp_path / f"{name}.mcap") for name in left}
    for recording in told.values():
        (dropped,) = [event for event in recording.topic("/event").messages if event["data"].get("dropped")]
        assert dropped["data"]["dropped"] == [story.killed]
        assert "2 of 3" in dropped["text"]
        ranks = [(plan["term"], plan["version"]) for plan in recording.topic("/plan").messages]
        assert ranks == sorted(ranks)
    texts = [event["text"] for recording in told.values() for event in recording.topic("/event").messages]
    assert any(text.startswith("captured: encirclement by 2 of 3 pursuers") for text in texts)
    summary = summarise(load_run([tmp_path]))
    assert (summary["captured_by"], summary["capturers"]) == (left, 2)
