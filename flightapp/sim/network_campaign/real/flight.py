"""A real flight over one kind of network, beside those on the virtual clock: the check that the two agree."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.analysis import report
from flightapp.config.mission import load_mission
from flightapp.sim.network_campaign.conditions import Condition
from flightapp.sim.network_campaign.real.namespaces import can_use_namespaces
from flightapp.sim.network_campaign.real.recorded import Network, read_network

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
        wrong = "".join(f", {text}" for text in self.violations)
        return f"real processes, {self.network}, {network}: {self.outcome}, {ages}{wrong}"


def fly_real(condition: Condition, mission: Path, profile: Path, folder: Path, *, proxy: bool = False) -> RealFlown:
    """Fly once in real time; recordings stay in `folder`. In namespaces where the machine allows it, unless `proxy`."""
    namespaces = not proxy and can_use_namespaces()
    run = folder / f"real-{condition.partition}-{condition.delay_ms:g}ms-{condition.loss_percent:g}percent"
    run.mkdir(parents=True)
    with (run / "network.log").open("wb") as log:
        status = subprocess.run(
            _command(condition, mission, profile, run, namespaces=namespaces), check=False, stderr=log, timeout=TIMEOUT_S
        )
    faults = [] if status.returncode == 0 else [f"fault: the flight ended with status {status.returncode}, see {run}/network.log"]
    network = None if faults else read_network(run, [vehicle.name for vehicle in load_mission(mission).vehicles])
    summary: dict[str, Any] = report([run])[0] if not faults else {}
    return RealFlown(
        condition=condition,
        network="namespaces" if namespaces else "proxy",
        outcome=str(summary.get("outcome", "fault")),
        capture_time_s=summary.get("capture_time_s"),
        separation_min_m=summary.get("min_separation_m"),
        age_p50_ms=_percentile_ms(network, 50.0),
        age_p99_ms=_percentile_ms(network, 99.0),
        violations=(*faults, *(() if network is None else network.violations)),
    )


def _percentile_ms(network: Network | None, percent: float) -> float | None:
    return round(float(np.percentile(network.ages_s, percent)) * 1e3, 1) if network is not None and network.ages_s else None


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
