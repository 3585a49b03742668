"""The file that says what is compared: planners, scenario files and seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from flightapp.analysis.campaign.everything.curve import Curve, checked
from flightapp.analysis.campaign.seeds import parse_seeds
from flightapp.config.loading import Strict, load
from flightapp.core.errors import InputError
from flightapp.planning.registry import planner_names
from flightapp.sim.batch.scenario import Scenario, load_scenario


class Family(Strict):
    """Scenarios that stand together in the table."""

    name: str = Field(min_length=1)
    scenarios: tuple[Path, ...] = Field(min_length=1)
    """Files, relative to this one."""


class GridFile(Strict):
    """As a person writes it."""

    planners: tuple[str, ...] = Field(min_length=1)
    seeds: str = "0-199"
    families: tuple[Family, ...] = Field(min_length=1)
    curves: tuple[Curve, ...] = ()


@dataclass(frozen=True, slots=True)
class Grid:
    """What is compared. `families`: (name, names of its scenarios), in the order of the file."""

    planners: tuple[str, ...]
    seeds: tuple[int, ...]
    scenarios: tuple[Scenario, ...]
    families: tuple[tuple[str, tuple[str, ...]], ...]
    curves: tuple[Curve, ...] = ()


def load_grid(path: Path, planners: Sequence[str], scenarios: Sequence[str], seeds: str | None) -> Grid:
    """The grid in `path`, cut down to `planners`, names of `scenarios` and `seeds` where they are given; InputError else."""
    file = load(GridFile, path)
    loaded = {family.name: [load_scenario(path.parent / one) for one in family.scenarios] for family in file.families}
    everything = [scenario for some in loaded.values() for scenario in some]
    names = [scenario.name for scenario in everything]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{path}: families: the scenario '{name}' is named twice; name each once")
    for name in scenarios:
        if name not in names:
            raise InputError(f"--scenario {name}: not in {path}; it has {', '.join(names)}")
    wanted = [name for name in names if not scenarios or name in scenarios]
    chosen = tuple(planners) or file.planners
    for planner in chosen:
        if planner not in planner_names():
            option = "--planner" if planners else f"{path}: planners:"
            raise InputError(f"{option} {planner}: no such planner; known: {', '.join(planner_names())}")
    drawn = parse_seeds(file.seeds, f"{path}: seeds:") if seeds is None else parse_seeds(seeds)
    families = [(name, tuple(one.name for one in some if one.name in wanted)) for name, some in loaded.items()]
    return Grid(
        tuple(dict.fromkeys(chosen)),
        drawn,
        tuple(scenario for scenario in everything if scenario.name in wanted),
        tuple(family for family in families if family[1]),
        checked(file.curves, {scenario.name: scenario for scenario in everything}, path),
    )
