"""Whole missions on the virtual clock: the same application, no waiting, the same bits again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.recording.reader import read_recording
from flightapp.runtime.outcome import Outcome
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"


def flown(run: Path, mission: str, seed: int = 1) -> VirtualFleet:
    run.mkdir()
    return fly_virtual(ROOT / "missions" / mission, SIM, run, seed=seed)


def sent(fleet: VirtualFleet, name: str) -> np.ndarray:
    return np.array(
        [(t_s, *setpoint.velocity_ned_m_s, setpoint.yaw_rad) for t_s, setpoint in fleet.vehicles[name].autopilot.sent]
    )


def test_one_vehicle_takes_off_hovers_returns_and_lands_the_same_way_every_time(tmp_path: Path) -> None:
    one, again = (flown(tmp_path / name, "hover.toml") for name in ("one", "again"))
    vehicle = one.vehicles["e1"]
    assert vehicle.outcome is Outcome.TIMEOUT
    assert not vehicle.station.core.armed
    assert np.linalg.norm(vehicle.position_ned_m) < 0.5
    assert np.array_equal(sent(one, "e1"), sent(again, "e1"))
    assert read_recording(tmp_path / "one" / "e1.mcap").topic("/phase").texts("phase")[-1] == "done"


def test_the_demo_mission_is_captured_and_everybody_is_home(tmp_path: Path) -> None:
    fleet = flown(tmp_path / "run", "demo_two_pursuers.toml")
    for one in fleet.vehicles.values():
        assert one.outcome is Outcome.CAPTURED, one.error
        assert not one.is_flying
        assert one.recorder.dropped == 0


def test_a_fleet_whose_clocks_differ_by_much_flies_as_one(tmp_path: Path) -> None:
    run = tmp_path / "run"
    run.mkdir()
    ahead_s = {"p1": 0.4, "p2": 0.0, "e1": 30.0}
    fleet = fly_virtual(ROOT / "missions/demo_two_pursuers.toml", SIM, run, seed=1, clock_ahead_s=ahead_s)
    for name, one in fleet.vehicles.items():
        assert one.outcome is Outcome.CAPTURED, one.error
        for other, peer in one.rooms.team.peers.items():
            assert peer.rejected == 0
            assert abs(one.rooms.team.post.clock_ahead_s[other] - (ahead_s[other] - ahead_s[name])) < 1e-6
        recorded = read_recording(run / f"{name}.mcap").metadata["clock_offsets"]
        assert {other: round(float(value), 3) for other, value in recorded.items()} == {
            other: round(ahead_s[other] - ahead_s[name], 3) for other in ahead_s if other != name
        }
