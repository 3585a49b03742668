"""A whole mission in space: an evader that climbs and dives is followed over walls of known height and encircled."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.recording.reader import read_recording
from flightapp.runtime.outcome import Outcome
from flightapp.sim.virtual.figures import PURSUIT, Referee
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[3]
FLOOR_M, CEILING_M, MARGIN_M = 1.5, 18.0, 0.45


def test_pursuers_follow_up_and_down_over_obstacles_of_known_height_and_capture(tmp_path: Path) -> None:
    referee, places = Referee(), {"p1": [], "p2": [], "e1": []}  # type: ignore[var-annotated]
    over = set()

    def watch(fleet: VirtualFleet) -> None:
        referee.watch(fleet)
        for name, one in fleet.vehicles.items():
            if one.loop.phase == PURSUIT:
                places[name].append(one.position_ned_m.copy())
                north, east, _ = places[name][-1]
                if fleet.world.signed_distance_m(north, east, -0.5) < 0.0:
                    over.add(name)

    fleet = fly_virtual(ROOT / "missions/demo_climb_and_dive.toml", ROOT / "profiles/sim.toml", tmp_path, seed=1, watch=watch)
    for one in fleet.vehicles.values():
        assert one.outcome is Outcome.CAPTURED, one.error
    figures = referee.figures(fleet)
    assert figures.min_obstacle_clearance_m is not None
    assert figures.min_obstacle_clearance_m > MARGIN_M
    assert over >= {"p1", "p2"}, "who flies round the walls has shown nothing"
    for name, flown in places.items():
        heights = -np.array(flown)[:, 2]
        assert FLOOR_M < heights.min() < 5.5, name
        assert 8.0 < heights.max() < CEILING_M, name
    recorded = read_recording(tmp_path / "p1.mcap").topic("/setpoint").column("clearance_m")
    assert np.nanmin(recorded) > 0.0, "what is known on board counts heights, too"
