"""How far apart pursuers arrive at their places around the evader, with and without the leader's plan, in the fast simulator.

    .venv/bin/python tools/arrival_spread.py --pursuers 3 --seeds 0-19

A pursuer is there once its planned time to its own place is below 0.3 s. Distance from the evader would not tell: who comes from
behind passes close by it on the way to its place.
"""

from __future__ import annotations

import argparse
import statistics
from dataclasses import dataclass, field
from pathlib import Path

from flightapp.analysis.campaign.seeds import parse_seeds
from flightapp.core.types import Decision, Observation
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.scenario import load_scenario

THERE_S = 0.3
STARTS = ("[74.0, 2.0]", "[74.0, 48.0]", "[74.0, 25.0]")


@dataclass(slots=True)
class Arrivals:
    """When each pursuer of an episode first was at its place."""

    at_s: dict[int, float] = field(default_factory=dict)

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:  # noqa: ARG002
        for index, decision in enumerate(decisions[:-1]):
            eta_s = decision.diagnostics.get("eta_s")
            if isinstance(eta_s, float) and eta_s <= THERE_S:
                self.at_s.setdefault(index, t_s)

    def end(self, truth: Truth) -> None:
        """Nothing more to see."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", type=Path, default=Path("missions/scenarios/a2-encircle.toml"))
    parser.add_argument("--pursuers", type=int, choices=(2, 3), default=3)
    parser.add_argument("--seeds", default="0-19")
    given = parser.parse_args()
    for planned in ("false", "true"):
        starts = f"[{', '.join(STARTS[: given.pursuers])}]"
        changes = {"pursuers.count": str(given.pursuers), "layout.pursuer_starts_m": starts, "messages.assignment": planned}
        scenario = load_scenario(given.scenario, changes)
        captured, arrivals = 0, []
        for seed in parse_seeds(given.seeds):
            watcher = Arrivals()
            captured += fly(scenario, "ac2f", seed, watcher=watcher).outcome == "captured"
            if len(watcher.at_s) == given.pursuers:
                arrivals.append(sorted(watcher.at_s.values()))
        spreads_s = [times_s[-1] - times_s[0] for times_s in arrivals]
        print(
            f"plan {planned}: captured {captured}, all there in {len(arrivals)}, from first to last mean "
            f"{statistics.mean(spreads_s):.2f} s, median {statistics.median(spreads_s):.2f} s, last after "
            f"{statistics.mean(times_s[-1] for times_s in arrivals):.2f} s"
        )


if __name__ == "__main__":
    main()
