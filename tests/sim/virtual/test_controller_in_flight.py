"""`aadrc-smc` in a flight of the real executive and loop: when it speaks, what its velocity loop is taken for, and its replay."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.replay.flight import read_flight
from flightapp.replay.replay import Wanted, replay
from flightapp.sim.virtual.figures import PURSUIT
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual
from flightapp.vehicle.velocity_gains import VelocityGains
from tests.sim.virtual.played import Played, evader_path

ROOT = Path(__file__).parents[3]
TREE = ROOT / "tests/sim/virtual/beside_a_tree.toml"
CALM, WINDY = "wind_north_m_s = 0.5", 'velocity_loop = "px4"\nwind_north_m_s = 4.0'


def test_it_speaks_from_the_pursuit_on_over_the_gains_of_the_autopilot_and_is_replayed_identically(tmp_path: Path) -> None:
    mission, run = tmp_path / "mission.toml", tmp_path / "run"
    mission.write_text('controller = "aadrc-smc"\n' + TREE.read_text().replace(CALM, WINDY))
    run.mkdir()
    played = Played("e1", "evader", 3), Played("p2", "pursuer", 2)
    began_s: list[float] = []

    def play(fleet: VirtualFleet) -> None:
        played[0].play(fleet, evader_path(fleet.clock.now_s()))
        played[1].play(fleet, (-2.0, 9.0, -2.5))
        if not began_s and fleet.vehicles["p1"].loop.phase == PURSUIT:
            began_s.append(fleet.clock.now_s())

    fleet = fly_virtual(mission, ROOT / "profiles/sim.toml", run, seed=3, flown={"p1"}, watch=play, time_limit_s=18.0)
    one = fleet.vehicles["p1"]
    before = [sent for t_s, sent in one.autopilot.sent if t_s < began_s[0]]
    during = [sent for t_s, sent in one.autopilot.sent if t_s > began_s[0] + 0.1]
    assert len(before) > 10
    assert all(sent.acceleration_ned_m_s2 is None for sent in before), "before there is something to follow it is silent"
    fed = np.array([sent.acceleration_ned_m_s2 for sent in during], dtype=np.float64)
    assert len(fed) > 50
    planar = np.linalg.norm(fed[:, :2], axis=1)
    assert 0.2 < planar.max() <= one.rooms.limits.acceleration_max_m_s2 + 1e-9
    flight = read_flight(run / "p1.mcap")
    assert flight.velocity_gains == VelocityGains(float(np.float32(1.8)), 4.0)
    [decided] = replay(Wanted(run / "p1.mcap")).replayed
    assert decided.identical, decided.text()
