"""A real flight over one kind of network, beside those on the virtual clock: the check that the two agree."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.analysis import report
from flightapp.config.mission import load_mission
from flightapp.recording.reader import read_recording
from flightapp.sim.network_campaign.conditions import Condition
from flightapp.sim.network_campaign.real.namespaces import can_use_namespaces
from flightapp.sim.virtual.figures import PURSUIT

TIMEOUT_S = 400.0


@dataclass(frozen=True, slots=True)
class RealFlown:
    """What became of real processes. Ages in the pursuit, as the vehicles recorded them."""

    condition: Condition
    network: str
    """`namespaces` or `proxy`."""
    outcome: str
    capture_time_s: float | None
    separation_min_m: float | None
    age_p50_ms: float | None
    age_p99_ms: float | None
    violations: tuple[str, ...]

    def as_json(self) -> dict[str, object]:
        return asdict(self)

    @property
    def sentence(self) -> str:
        ages = (
            "no states heard"
            if self.age_p50_ms is None
            else f"state age p50 {self.age_p50_ms:.0f} ms, p99 {self.age_p99_ms:.0f} ms"
        )
        one = self.condition
        network = f"{one.delay_ms:g} ms +- {one.jitter_ms:g}, {one.loss_percent:g} % lost, partition {one.partition}"
        return f"real processes, {self.network}, {network}: {self.outcome}, {ages}"


def fly_real(condition: Condition, mission: Path, profile: Path, folder: Path, *, proxy: bool = False) -> RealFlown:
    """Fly once in real time; recordings stay in `folder`. In namespaces where the machine allows it, unless `proxy`."""
    namespaces = not proxy and can_use_namespaces()
    run = folder / f"real-{condition.partition}-{condition.delay_ms:g}ms-{condition.loss_percent:g}percent"
    run.mkdir(parents=True)
    with (run / "network.log").open("wb") as log:
        status = subprocess.run(
            _command(condition, mission, profile, run, namespaces=namespaces), check=False, stderr=log, timeout=TIMEOUT_S
        )
    violations = (
        [] if status.returncode == 0 else [f"fault: the flight ended with status {status.returncode}, see {run}/network.log"]
    )
    names = [vehicle.name for vehicle in load_mission(mission).vehicles]
    summary: dict[str, Any] = report([run])[0] if not violations else {}
    ages_s = [age_s for name in names for age_s in _ages_s(run / f"{name}.mcap")] if not violations else []
    p50, p99 = (None, None) if not ages_s else (float(value) * 1e3 for value in np.percentile(ages_s, (50.0, 99.0)))
    return RealFlown(
        condition=condition,
        network="namespaces" if namespaces else "proxy",
        outcome=str(summary.get("outcome", "fault")),
        capture_time_s=summary.get("capture_time_s"),
        separation_min_m=summary.get("min_separation_m"),
        age_p50_ms=p50,
        age_p99_ms=p99,
        violations=tuple(violations),
    )


def _command(condition: Condition, mission: Path, profile: Path, run: Path, *, namespaces: bool) -> list[str]:
    command = [
        *(sys.executable, "-m", "flightapp.sim.network_campaign.real", str(mission), str(profile), str(run)),
        *("--delay-ms", str(condition.delay_ms), "--jitter-ms", str(condition.jitter_ms)),
        *("--loss-percent", str(condition.loss_percent), "--partition", condition.partition),
    ]
    if not namespaces:
        return command
    alone = 'ip link set lo up && exec "$@"'
    return ["unshare", "--net", "sh", "-c", alone, "sh", *command, "--namespaces"]


def _ages_s(recording: Path) -> Iterator[float]:
    """Of every teammate's newest state, each time that the vehicle wrote them down in its pursuit."""
    read = read_recording(recording)
    phases = [(message["t_s"], message["phase"]) for message in read.topic("/phase").messages]
    began_s = next((t_s for t_s, phase in phases if phase == PURSUIT), math.inf)
    ended_s = next((t_s for t_s, phase in phases if phase != PURSUIT and t_s > began_s), math.inf)
    for message in read.topic("/team").messages:
        if began_s <= message["t_s"] <= ended_s:
            yield from (one["age_s"] for one in message["members"] if one["phase"] != "done")
