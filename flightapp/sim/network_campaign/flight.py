"""One mission over one kind of network, on the virtual clock: flown, measured, judged."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from flightapp.config.profile import load_profile
from flightapp.runtime.outcome import Outcome
from flightapp.sim.link_shaper import LinkShaper
from flightapp.sim.network_campaign.conditions import Condition
from flightapp.sim.network_campaign.observer import NetworkObserver
from flightapp.sim.virtual.figures import Referee
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

TIME_LIMIT_S = 300.0


@dataclass(frozen=True, slots=True)
class Flown:
    """What became of one seed over one network; equal for equal seeds. Ages are those of teammates' states in the pursuit."""

    condition: Condition
    seed: int
    outcome: str
    capture_time_s: float | None
    separation_min_m: float | None
    """Between pursuers, true, in the plane."""
    age_p50_ms: float | None
    age_p99_ms: float | None
    leader_changes: int
    split_felt: bool
    """Whether somebody's newest state of somebody got older than a second while the fleet was split."""
    violations: tuple[str, ...]

    @property
    def captured(self) -> bool:
        return self.outcome == "captured"

    def as_json(self) -> dict[str, object]:
        return asdict(self)


def fly_condition(condition: Condition, seed: int, mission: Path, profile: Path, folder: Path) -> Flown:
    """Fly; recordings go to the new folder `folder`."""
    folder.mkdir(parents=True)
    referee = Referee()
    observer = NetworkObserver(LinkShaper(condition.quality, seed), condition.partition, load_profile(profile).safety)

    def watch(fleet: VirtualFleet) -> None:
        referee.watch(fleet)
        observer.watch(fleet)

    with _quiet():
        fleet = fly_virtual(mission, profile, folder, seed=seed, watch=watch, time_limit_s=TIME_LIMIT_S)
    return _flown(condition, seed, fleet, observer)


def _flown(condition: Condition, seed: int, fleet: VirtualFleet, observer: NetworkObserver) -> Flown:
    pursuers = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"]
    ended = {one.loop.outcome or one.loop.phase for one in pursuers}
    outcome = ended.pop() if len(ended) == 1 else ", ".join(sorted(ended))
    faults = [f"fault: {one.name}: {one.error}" for one in fleet.vehicles.values() if one.error]
    faults += [f"fault: {one.name} ended its mission with a fault" for one in pursuers if one.loop.outcome == Outcome.FAULT]
    return Flown(
        condition=condition,
        seed=seed,
        outcome=outcome,
        capture_time_s=round(observer.ended_s - observer.began_s, 2) if outcome == "captured" else None,
        separation_min_m=_rounded(observer.separation_m),
        age_p50_ms=_percentile_ms(observer.ages_s, 50.0),
        age_p99_ms=_percentile_ms(observer.ages_s, 99.0),
        leader_changes=observer.leader_changes,
        split_felt=observer.split_felt,
        violations=(*faults, *observer.broken.values()),
    )


def _rounded(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None


def _percentile_ms(ages_s: Sequence[float], percent: float) -> float | None:
    return round(float(np.percentile(ages_s, percent)) * 1e3, 1) if ages_s else None


@contextmanager
def _quiet() -> Iterator[None]:
    """Hundreds of missions would each tell their story on the terminal."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)
