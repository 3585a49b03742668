"""What a mate tells of obstacles leads the planner round them; the supervisor never hears of it; replay decides the same."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flightapp.config.profile import Profile
from flightapp.core.types import Setpoint
from flightapp.fleet.messages.codec import Header, encode
from flightapp.fleet.messages.discs import DISCS, Disc, Discs
from flightapp.fleet.messages.keys import key
from flightapp.fleet.sharing.heard import MEMORY_S
from flightapp.recording.reader import read_recording
from flightapp.replay import Wanted, replay
from flightapp.safety.api import SafetyContext, Supervised
from flightapp.safety.supervisor import Supervisor
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual
from tests.sim.virtual.played import PRIORITY, Played

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
HEDGE = Path(__file__).parent / "behind_a_hedge.toml"
EVADER_M = (24.0, 0.0, -2.5)
REACHED_M = 5.0
SIGHT_M = 4.0


def _short_sighted(share: bool) -> Any:
    def change(profile: Profile) -> Profile:
        network = profile.network.model_copy(update={"share_discs": share})
        return profile.model_copy(
            update={"network": network, "camera": profile.camera.model_copy(update={"range_max_m": SIGHT_M})}
        )

    return change


class _Race:
    """From the start of the pursuit until p1 has the evader in reach."""

    def __init__(self) -> None:
        self._evader = Played("e1", "evader", 3)
        self.times_s: list[float] = []
        self.clearances_m: list[float] = []

    @property
    def duration_s(self) -> float:
        return self.times_s[-1] - self.times_s[0]

    def watch(self, fleet: VirtualFleet) -> None:
        self._evader.play(fleet, EVADER_M)
        p1 = fleet.vehicles["p1"]
        if p1.loop.phase != "pursue":
            return
        north, east, down = p1.position_ned_m.tolist()
        self.times_s.append(fleet.clock.now_s())
        self.clearances_m.append(fleet.world.signed_distance_m(north, east, down) - p1.rooms.limits.body_radius_m)
        if math.hypot(EVADER_M[0] - north, EVADER_M[1] - east) < REACHED_M or self.duration_s > 20.0:
            fleet.stop()


def _race(run: Path, share: bool) -> _Race:
    run.mkdir()
    race = _Race()
    fly_virtual(
        HEDGE, SIM, run, seed=3, flown={"p1", "p2"}, watch=race.watch, change_profile=_short_sighted(share), time_limit_s=60.0
    )
    return race


def _told(path: Path) -> list[list[list[float]]]:
    return [message.get("told_discs") or [] for message in read_recording(path).topic("/observation").messages]


def test_a_hedge_that_only_the_mate_has_seen_is_flown_around_at_once(tmp_path: Path) -> None:
    alone, told = _race(tmp_path / "alone", share=False), _race(tmp_path / "told", share=True)
    assert told.duration_s < alone.duration_s - 1.0
    assert min(told.clearances_m) >= min(alone.clearances_m)
    assert not any(_told(tmp_path / "alone/p1.mcap"))
    assert max(map(len, _told(tmp_path / "told/p1.mcap"))) >= 3
    [again] = replay(Wanted(tmp_path / "told/p1.mcap")).replayed
    assert again.decisions > 50
    assert again.identical, again.text()


def _tell(fleet: VirtualFleet, sender: str, number: int, discs: list[tuple[float, float, float]]) -> None:
    now_s = fleet.clock.now_s()
    message = Discs(now_s, tuple(Disc(*row, 0.0, 0.0) for row in discs))
    content = encode(DISCS, message, Header(sender, number, now_s))
    fleet.network.publish(sender, key(fleet.mission.fleet, sender, "discs"), content, PRIORITY)


def test_a_lying_mate_reaches_the_planner_only_and_no_longer_than_it_lies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    evader, mate = Played("e1", "evader", 3), Played("p2", "pursuer", 2)
    lied_s: list[float] = []
    told_to_planner: list[tuple[float, int]] = []
    supervised: list[np.ndarray] = []
    check = Supervisor.check

    def spy(supervisor: Supervisor, wish: Setpoint, context: SafetyContext) -> Supervised:
        supervised.append(context.obstacles.discs)
        return check(supervisor, wish, context)

    monkeypatch.setattr(Supervisor, "check", spy)

    def watch(fleet: VirtualFleet) -> None:
        now_s, p1 = fleet.clock.now_s(), fleet.vehicles["p1"]
        evader.play(fleet, EVADER_M)
        mate.play(fleet, (16.0, 9.0, -2.5))
        if p1.loop.phase != "pursue":
            return
        if not lied_s or now_s - lied_s[-1] > 1.0 > now_s - lied_s[0] - 1.0:
            lied_s.append(now_s)
            north, east, _ = p1.position_ned_m.tolist()
            ring = [(north + 3.0 * math.cos(0.8 * k), east + 3.0 * math.sin(0.8 * k), 0.9) for k in range(8)]
            _tell(fleet, "p2", len(lied_s), ring)
            _tell(fleet, "e1", len(lied_s), [(-20.0, -20.0, 1.0)])
        if now_s - lied_s[-1] > MEMORY_S + 1.0:
            fleet.stop()

    fly_virtual(HEDGE, SIM, tmp_path, seed=3, flown={"p1"}, watch=watch, change_profile=_short_sighted(True), time_limit_s=40.0)
    recorded = read_recording(tmp_path / "p1.mcap").topic("/observation")
    for t_s, told in zip(recorded.values("t_s"), _told(tmp_path / "p1.mcap"), strict=True):
        told_to_planner.append((t_s, len(told)))
        assert [-20.0, -20.0, 1.0] not in told, "an evader is no mate"
    assert any(count for t_s, count in told_to_planner if t_s < lied_s[-1])
    assert not any(count for t_s, count in told_to_planner if t_s > lied_s[-1] + MEMORY_S + 0.1)
    assert len(supervised) == len(told_to_planner)
    assert not any(0.9 in discs[:, 2] for discs in supervised)
