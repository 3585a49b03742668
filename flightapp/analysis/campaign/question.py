"""What campaigns and tuning are asked on the command line: a scenario with changes, and planner parameters."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flightapp.analysis.campaign.seeds import parse_seeds
from flightapp.config.loading import read_toml
from flightapp.core.errors import InputError
from flightapp.sim.batch.scenario import Scenario, load_scenario


def planners_and_seeds(
    path: Path, scenario: Scenario, planners: Sequence[str], seeds: str | None
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """What the command line says, else the [campaign] of the scenario, which stands in `path`."""
    if not planners and not scenario.campaign.planners:
        raise InputError(f"--planner: name at least one, or several as campaign.planners in {path}")
    chosen = parse_seeds(scenario.campaign.seeds, f"{path}: campaign.seeds:") if seeds is None else parse_seeds(seeds)
    return tuple(planners) or scenario.campaign.planners, chosen


def load_question(scenario: Path, changes: Sequence[str], parameters: Path | None) -> tuple[Scenario, dict[str, Any]]:
    """The scenario with each KEY=VALUE of `changes`, and the tables of the parameter file; InputError names what is wrong."""
    overrides: dict[str, str] = {}
    for change in changes:
        key, separator, value = change.partition("=")
        if not separator or not key:
            raise InputError(f"--set {change}: must be KEY=VALUE, for example sensing.range_m=10")
        overrides[key.strip()] = value.strip()
    return load_scenario(scenario, overrides), {} if parameters is None else read_toml(parameters)
