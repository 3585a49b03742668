"""Does it help to be told of obstacles that a mate has seen? One mission on the virtual clock, without and with `share_discs`.

    .venv/bin/python tools/shared_discs.py missions/demo_two_pursuers.toml --range 4 --seeds 0 1 2
    .venv/bin/python tools/shared_discs.py missions/demo_two_pursuers.toml --range 10 --rendered

Of each flight: how long the pursuit took, the smallest clearance and separation, and in how many control periods each pursuer
knew of an obstacle only because a mate had told it. The camera knows what is nearer than `--range`, or with `--rendered` what
real perception finds in rendered pictures.
"""

from __future__ import annotations

import argparse
import logging
import tempfile
from pathlib import Path

from flightapp.config.profile import Profile
from flightapp.recording.reader import read_recording
from flightapp.sim.virtual.figures import PURSUIT, Referee
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[1]


def fly(mission: Path, run: Path, seed: int, range_m: float, *, reach_m: float | None, rendered: bool, share: bool) -> str:
    """One flight until the pursuit is over, as one line."""
    referee = Referee()
    times_s: list[float] = []

    def watch(fleet: VirtualFleet) -> None:
        referee.watch(fleet)
        pursuers = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"]
        if any(one.loop.phase == PURSUIT for one in pursuers):
            times_s.append(fleet.clock.now_s())
            reached_m = referee.figures(fleet).min_target_distance_m
            if reach_m is not None and reached_m is not None and reached_m < reach_m:
                fleet.stop()
        elif times_s:
            fleet.stop()

    def change(profile: Profile) -> Profile:
        camera = profile.camera.model_copy(update={"range_max_m": range_m})
        network = profile.network.model_copy(update={"share_discs": share})
        return profile.model_copy(update={"camera": camera, "network": network})

    fleet = fly_virtual(
        mission, ROOT / "profiles/sim.toml", run, seed=seed, watch=watch, change_profile=change, rendered=rendered
    )
    figures = referee.figures(fleet)
    outcomes = sorted({str(one.loop.outcome) for one in fleet.vehicles.values()})
    told = []
    for one in fleet.vehicles.values():
        if one.vehicle.role == "pursuer":
            periods = read_recording(run / f"{one.name}.mcap").topic("/observation").messages
            told.append(f"{one.name} {sum(bool(period.get('told_discs')) for period in periods)} of {len(periods)}")
    return (
        f"seed {seed}, {'told ' if share else 'alone'}: {', '.join(outcomes)} after {times_s[-1] - times_s[0]:.2f} s, "
        f"clearance {figures.min_obstacle_clearance_m:.2f} m, separation {figures.min_separation_m:.2f} m, "
        f"told in {', '.join(told)} periods"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path)
    parser.add_argument("--range", type=float, default=4.0, help="of the cameras, m")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--reach", type=float, help="end when a pursuer has been nearer to the evader than this, m")
    parser.add_argument("--rendered", action="store_true")
    wanted = parser.parse_args()
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as folder:
        for seed in wanted.seeds:
            for share in (False, True):
                run = Path(folder) / f"{seed}-{share}"
                run.mkdir()
                options = {"rendered": wanted.rendered, "share": share}
                print(fly(wanted.mission, run, seed, wanted.range, reach_m=wanted.reach, **options), flush=True)


if __name__ == "__main__":
    main()
