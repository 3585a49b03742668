"""Named variants and parameter files: what they fix, what they leave open, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.config.loading import read_toml
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.variants import VARIANTS, with_variant
from flightapp.planning.parameters import parsed
from flightapp.planning.registry import file_parameters, make_planner, planner_names
from flightapp.runtime.composition import build_strategy
from tests.planning.closed_loop import DEMO, PROFILE, demo, fly, limits

FILES = sorted((Path(__file__).parents[2] / "missions" / "parameters").glob("ac2f-*.toml"))


def parameters_of(name: str, given: dict[str, object] | None = None) -> Ac2fParameters:
    return parsed(Ac2fParameters, name, with_variant(name, given))


def test_every_variant_is_a_planner_that_differs_from_the_others() -> None:
    assert set(VARIANTS) <= set(planner_names())
    found = [parameters_of(name) for name in VARIANTS]
    assert all(a != b for i, a in enumerate(found) for b in found[:i])
    assert parameters_of("ac2f") == Ac2fParameters()


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_every_variant_flies(name: str) -> None:
    flight = fly(demo(1, planner=name, time_limit_s=3.0), 1)
    modes = flight.modes[0] | flight.modes[1]
    assert modes <= ({"fine"} if name == "dwa-fixed" else {"coarse"})


def test_a_contradiction_is_refused_in_one_sentence() -> None:
    with pytest.raises(InputError) as error:
        make_planner("geo-apf", limits=limits(), parameters={"stages": "both"})
    assert str(error.value) == "strategy 'geo-apf': stages = 'both': this variant fixes it to 'coarse'; leave it out"
    with pytest.raises(InputError, match="strategy 'apf': speeed is not a parameter"):
        make_planner("apf", limits=limits(), parameters={"speeed": 3.0})


def test_what_is_equal_or_open_is_taken() -> None:
    assert parameters_of("geo-apf", {"stages": "coarse", "field_gain_m2": 0.5}).field_gain_m2 == 0.5
    assert not parameters_of("ac2f-literal").admissibility
    assert parameters_of("ac2f-literal", {"admissibility": True}).admissibility


def test_there_are_the_parameters_of_the_source_and_the_best_ones() -> None:
    assert [path.stem for path in FILES] == ["ac2f-best", "ac2f-paper"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_a_parameter_file_serves_every_variant(path: Path, name: str) -> None:
    values = read_toml(path)
    found = parameters_of(name, file_parameters(name, values))
    changed = {key for key, value in values.items() if getattr(found, key) != value}
    assert changed <= set(VARIANTS[name].fixed)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_mission_names_variant_and_parameter_file(path: Path, tmp_path: Path) -> None:
    strategy = f'strategy = {{ name = "ac2f-no-memory", parameters_file = "{path}" }}'
    mission_path = tmp_path / "mission.toml"
    mission_path.write_text(DEMO.read_text().replace('strategy = { name = "ac2f" }', strategy))
    mission = load_mission(mission_path)
    planner = build_strategy(mission, mission.vehicles[0], load_profile(PROFILE), mission_path, 0)
    assert isinstance(planner, Ac2fPlanner)
