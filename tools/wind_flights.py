"""`python tools/wind_flights.py --seeds 0-19`: a pursuit in wind on the virtual clock, with and without the controller.

Every seed flies the mission once with each controller, in the same wind, to the end of the pursuit. Printed for each, and at
the end for all: captures, time to capture, how far the flown velocity is from what the planner decided and from what was sent
after the guards (root mean square over the pursuers, m/s), smallest clearance and separation.
"""

from __future__ import annotations

import argparse
import json
import logging
import statistics
import sys
import tempfile
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from flightapp.analysis.campaign.seeds import parse_seeds
from flightapp.core.errors import InputError
from flightapp.sim.virtual.figures import PURSUIT, Referee
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

CONTROLLERS = ("autopilot", "aadrc-smc")
SAMPLE_STEPS = 4
TIME_LIMIT_S = 200.0
SWITCH = 'controller = "aadrc-smc"'


@dataclass(frozen=True, slots=True)
class Flown:
    """One pursuit."""

    seed: int
    controller: str
    outcome: str
    pursuit_s: float
    decided_rms_m_s: float
    sent_rms_m_s: float
    clearance_min_m: float
    separation_min_m: float


@dataclass(slots=True)
class Watcher:
    """Looks at every pursuer every SAMPLE_STEPS of the simulation, and ends the flight with the pursuit."""

    referee: Referee = field(default_factory=Referee)
    steps: int = 0
    began_s: float | None = None
    ended_s: float = 0.0
    squares: list[tuple[float, float]] = field(default_factory=list)

    def watch(self, fleet: VirtualFleet) -> None:
        self.steps += 1
        if self.steps % SAMPLE_STEPS:
            return
        self.referee.watch(fleet)
        pursuing = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer" and one.loop.phase == PURSUIT]
        if not pursuing:
            if self.began_s is not None:
                fleet.stop()
            return
        self.ended_s = fleet.clock.now_s()
        self.began_s = self.ended_s if self.began_s is None else self.began_s
        for one in pursuing:
            if one.loop.decision is None or not one.autopilot.sent:
                continue
            flown, sent = one.velocity_ned_m_s[:2], one.autopilot.sent[-1][1].velocity_ned_m_s[:2]
            decided = one.loop.decision.velocity_ned_m_s[:2]
            self.squares.append((float(((decided - flown) ** 2).sum()), float(((sent - flown) ** 2).sum())))


def fly(mission: str, profile: Path, seed: int, controller: str) -> Flown:
    """One flight of the text `mission`, in a folder that is thrown away."""
    watcher = Watcher()
    with tempfile.TemporaryDirectory() as name:
        path, run = Path(name) / "mission.toml", Path(name) / "run"
        path.write_text(mission.replace(SWITCH, f'controller = "{controller}"'))
        run.mkdir()
        fleet = fly_virtual(path, profile, run, seed=seed, watch=watcher.watch, time_limit_s=TIME_LIMIT_S)
    outcomes = {str(one.loop.outcome) for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"}
    figures, squares = watcher.referee.figures(fleet), np.sqrt(np.mean(watcher.squares or [(np.nan, np.nan)], axis=0))
    return Flown(
        seed,
        controller,
        ", ".join(sorted(outcomes)),
        round(watcher.ended_s - (watcher.began_s or 0.0), 2),
        round(float(squares[0]), 3),
        round(float(squares[1]), 3),
        round(figures.min_obstacle_clearance_m or 0.0, 3),
        round(figures.min_separation_m or 0.0, 3),
    )


def summary(flown: list[Flown]) -> str:
    """One controller's flights in a line."""

    def median(name: str) -> float:
        return statistics.median(getattr(one, name) for one in flown)

    captured = sum(one.outcome == "captured" for one in flown)
    return (
        f"{flown[0].controller}: captured {captured}/{len(flown)} after {median('pursuit_s'):.1f} s, velocity "
        f"{median('decided_rms_m_s'):.2f} m/s off what was decided and {median('sent_rms_m_s'):.2f} m/s off what was sent, "
        f"clearance at least {min(one.clearance_min_m for one in flown):.2f} m, "
        f"separation at least {min(one.separation_min_m for one in flown):.2f} m"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mission", type=Path, default=Path("missions/demo_wind.toml"))
    parser.add_argument("--profile", type=Path, default=Path("profiles/sim.toml"))
    parser.add_argument("--seeds", default="0-19", help="17, 0-19 or 3,5")
    parser.add_argument("--json", action="store_true", help="one line a flight for machines, no summary")
    arguments = parser.parse_args()
    logging.disable(logging.CRITICAL)
    mission = arguments.mission.read_text()
    if SWITCH not in mission:
        raise InputError(f"{arguments.mission}: has no line '{SWITCH}', which this comparison switches")
    flown = []
    for seed in parse_seeds(arguments.seeds):
        for controller in CONTROLLERS:
            flown.append(fly(mission, arguments.profile, seed, controller))
            print(json.dumps(asdict(flown[-1])), flush=True)
    if not arguments.json:
        for controller in CONTROLLERS:
            print(summary([one for one in flown if one.controller == controller]))


if __name__ == "__main__":
    try:
        main()
    except (InputError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(2)
