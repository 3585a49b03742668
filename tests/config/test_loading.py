from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flightapp.config.loading import read_toml, validate
from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import InputError
from tests.config.tables import MISSION, PROFILE, ROOT


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("demo*.toml")), ids=lambda path: path.name)
def test_the_missions_load(path: Path) -> None:
    assert load_mission(path).name == path.stem


@pytest.mark.parametrize("path", sorted((ROOT / "profiles").glob("*.toml")), ids=lambda path: path.name)
def test_the_profiles_load(path: Path) -> None:
    profile = load_profile(path)
    assert profile.name == path.stem
    assert profile.limits.as_limits().speed_max_m_s == profile.limits.speed_max_m_s


@pytest.mark.parametrize(
    ("content", "wanted"),
    [
        (None, "no such file"),
        (b"name = 'x'\nheight_m = \n", "line 2"),
        (b"name = 'x'\nname = 'y'\n", "line 2"),
        (b"[datum\n", "line 1"),
        (b"name = '\xff\xfe'\n", "not valid TOML"),
        (b"", "missing"),
    ],
    ids=["missing file", "no value", "twice", "open bracket", "not text", "empty file"],
)
def test_a_file_that_cannot_be_read_is_one_sentence(content: bytes | None, wanted: str, tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_mission(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert wanted in str(caught.value)


def test_a_folder_is_not_a_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        read_toml(tmp_path)


def _places(value: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    found = [path] if path else []
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        found += _places(inner, (*path, key))
    return found


values = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(2**70), 2**70),
    st.sampled_from([0, 0.0, -1, 1e-300, 1e300, 10**400, math.nan, True, "", "x", [], {}, [[]], [[0.0, 0.0]], {"north_m": 1}]),
    st.text(max_size=5),
    st.dates(),
    st.lists(st.one_of(st.floats(), st.text(max_size=3)), max_size=4),
    st.lists(st.tuples(st.floats(-70, 70), st.floats(-70, 70)).map(list), max_size=6),
    st.dictionaries(st.text(max_size=5), st.integers(), max_size=2),
)


def _mutated(tables: dict[str, Any], data: st.DataObject) -> dict[str, Any]:
    result = copy.deepcopy(tables)
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(_places(result)))
        place: Any = result
        for part in path[:-1]:
            place = place[part]
        kind = data.draw(st.sampled_from(["replace", "replace", "replace", "remove", "add", "double"]))
        if kind == "remove":
            del place[path[-1]]
        elif kind == "add" and isinstance(place, dict):
            place[data.draw(st.text(max_size=6))] = copy.deepcopy(data.draw(values))
        elif kind == "double" and isinstance(place, list):
            place.append(copy.deepcopy(place[int(path[-1])]))
        else:
            place[path[-1]] = copy.deepcopy(data.draw(values))
        if not result:
            break
    return result


def _sentences(model: type[Mission] | type[Profile], tables: dict[str, Any]) -> str:
    """What is wrong with `tables`; the empty sentence of the right file where nothing is. Any other exception is a failure."""
    try:
        validate(model, tables, Path("file.toml"))
    except InputError as error:
        return str(error)
    return "file.toml: "


@settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_any_damage_to_a_mission_loads_or_is_refused_in_words(data: st.DataObject) -> None:
    assert _sentences(Mission, _mutated(MISSION, data)).startswith("file.toml: ")


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_any_damage_to_a_profile_loads_or_is_refused_in_words(data: st.DataObject) -> None:
    assert _sentences(Profile, _mutated(PROFILE, data)).startswith("file.toml: ")
