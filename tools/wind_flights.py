"""`python tools/wind_flights.py --seeds 0-19`: a pursuit in wind on the virtual clock, with and without the controller.

Every seed flies the mission once with each controller, in the same wind, to the end of the pursuit. Printed for each flight:
outcome, duration of the pursuit, how far the flown velocity is from what the planner decided and from what was sent after the
guards (root mean square over the pursuers, m/s), smallest clearance and separation. At the end: the medians of both, and the
median of the pairs' differences (with the controller less without) with its 95 % interval (bootstrap over the pairs).
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

WITHOUT, WITH = CONTROLLERS = ("autopilot", "aadrc-smc")
LOOPS = ("px4", "reference")
SAMPLE_STEPS = 4
TIME_LIMIT_S = 200.0
SWITCH, LOOP_SWITCH = 'controller = "aadrc-smc"', 'velocity_loop = "px4"'
RESAMPLED = 10_000
FIGURES = {
    "pursuit_s": "pursuit, s",
    "decided_rms_m_s": "velocity off the decided one, m/s",
    "sent_rms_m_s": "velocity off the sent one, m/s",
    "clearance_min_m": "smallest clearance, m",
    "separation_min_m": "smallest separation, m",
}


@dataclass(frozen=True, slots=True)
class Flown:
    """One pursuit."""

    seed: int
    controller: str
    loop: str
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


def fly(mission: str, profile: Path, seed: int, controller: str, loop: str = "px4") -> Flown:
    """One flight of the text `mission`, in a folder that is thrown away."""
    watcher = Watcher()
    with tempfile.TemporaryDirectory() as name:
        path, run = Path(name) / "mission.toml", Path(name) / "run"
        path.write_text(mission.replace(SWITCH, f'controller = "{controller}"').replace(LOOP_SWITCH, f'velocity_loop = "{loop}"'))
        run.mkdir()
        fleet = fly_virtual(path, profile, run, seed=seed, watch=watcher.watch, time_limit_s=TIME_LIMIT_S)
    pursuers = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"]
    outcomes = {str(one.loop.outcome) for one in pursuers}
    figures, squares = watcher.referee.figures(fleet), np.sqrt(np.mean(watcher.squares or [(np.nan, np.nan)], axis=0))
    return Flown(
        seed,
        controller,
        loop,
        ", ".join(sorted(outcomes)) if watcher.began_s is not None else "no pursuit",
        round(watcher.ended_s - (watcher.began_s or 0.0), 2),
        round(float(squares[0]), 3),
        round(float(squares[1]), 3),
        round(figures.min_obstacle_clearance_m or 0.0, 3),
        round(figures.min_separation_m or 0.0, 3),
    )


def summary(flown: list[Flown]) -> list[str]:
    """Sentences about all flights over one velocity loop."""
    pairs = paired(flown)
    said = [f"velocity loop {flown[0].loop}, {len(pairs)} pairs:"]
    left_out = len({one.seed for one in flown}) - len(pairs)
    if left_out:
        said.append(f"  {left_out} seeds left out: a flight of the pair never came to a pursuit")
    if not pairs:
        return said
    caught = [(before.outcome == "captured", after.outcome == "captured") for before, after in pairs]
    said.append(
        f"  captured without / with: {sum(a for a, _ in caught)} / {sum(b for _, b in caught)} of {len(pairs)}; "
        f"only without {sum(a and not b for a, b in caught)}, only with {sum(b and not a for a, b in caught)}"
    )
    for name, title in FIGURES.items():
        before, after = (np.array([getattr(pair[side], name) for pair in pairs]) for side in (0, 1))
        middle, low, high = median_difference(after - before)
        said.append(
            f"  {title}: {statistics.median(before.tolist()):.2f} / {statistics.median(after.tolist()):.2f}, "
            f"difference {middle:+.2f} [{low:+.2f}, {high:+.2f}], least {before.min():.2f} / {after.min():.2f}"
        )
    return said


def paired(flown: list[Flown]) -> list[tuple[Flown, Flown]]:
    """(without, with) of every seed that has flown both."""
    by_key = {(one.seed, one.controller): one for one in flown if one.outcome != "no pursuit"}
    seeds = dict.fromkeys(one.seed for one in flown)
    return [(by_key[seed, WITHOUT], by_key[seed, WITH]) for seed in seeds if (seed, WITHOUT) in by_key and (seed, WITH) in by_key]


def median_difference(differences: np.ndarray) -> tuple[float, float, float]:
    """Median of the differences, and the 95 % interval of it by the bootstrap; the same for the same differences."""
    drawn = np.random.default_rng(0).choice(differences, (RESAMPLED, len(differences)))
    low, high = np.percentile(np.median(drawn, axis=1), (2.5, 97.5))
    return float(np.median(differences)), float(low), float(high)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mission", type=Path, default=Path("missions/demo_wind.toml"))
    parser.add_argument("--profile", type=Path, default=Path("profiles/sim.toml"))
    parser.add_argument("--seeds", default="0-19", help="17, 0-19 or 3,5")
    parser.add_argument(
        "--loop", choices=LOOPS, default=LOOPS[0], help="velocity loop of the autopilots: PX4's own gains or the reference"
    )
    parser.add_argument("--json", action="store_true", help="one line a flight for machines, no summary")
    arguments = parser.parse_args()
    logging.disable(logging.CRITICAL)
    mission = arguments.mission.read_text()
    for line in (SWITCH, LOOP_SWITCH):
        if line not in mission:
            raise InputError(f"{arguments.mission}: has no line '{line}', which this comparison switches")
    flown = []
    for seed in parse_seeds(arguments.seeds):
        for controller in CONTROLLERS:
            flown.append(fly(mission, arguments.profile, seed, controller, arguments.loop))
            print(json.dumps(asdict(flown[-1])), flush=True)
    if not arguments.json:
        print("\n".join(summary(flown)))


if __name__ == "__main__":
    try:
        main()
    except (InputError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(2)
