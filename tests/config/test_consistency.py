from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flightapp.config.consistency import check_mission_fits_profile
from flightapp.config.loading import validate
from flightapp.config.mission import Mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import InputError
from tests.config.tables import MISSION, PROFILE, ROOT, Change, changed

MISSION_FILE, PROFILE_FILE = Path("mission.toml"), Path("profile.toml")
SMALL = [[-6.0, -9.0], [5.0, -9.0], [5.0, 9.0], [-6.0, 9.0]]


def _check(name: str, mission: list[Change], profile: list[Change]) -> str:
    try:
        check_mission_fits_profile(
            validate(Mission, changed(MISSION, *mission), MISSION_FILE),
            validate(Profile, changed(PROFILE, *profile), PROFILE_FILE),
            MISSION_FILE,
            PROFILE_FILE,
            name,
        )
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", ["p1", "p2", "e1"])
@pytest.mark.parametrize("path", sorted((ROOT / "profiles").glob("*.toml")), ids=lambda path: path.name)
def test_the_demo_fits_every_profile(name: str, path: Path) -> None:
    check_mission_fits_profile(validate(Mission, MISSION, MISSION_FILE), load_profile(path), MISSION_FILE, path, name)


CASES: dict[str, tuple[str, list[Change], list[Change], list[str]]] = {
    "unknown vehicle": ("p7", [], [], ["mission.toml: vehicles", "'p7'", "known: p1, p2, e1"]),
    "keep-out beyond the hold radius": (
        "p1",
        [],
        [(("safety", "target_keep_out_m"), 2.5)],
        ["profile.toml: safety.target_keep_out_m = 2.5", "must be smaller than capture.hold_radius_m = 2.2", "mission.toml"],
    ),
    "faster than the profile": (
        "p1",
        [(("vehicles", 0, "speed_max_m_s"), 7.0)],
        [],
        ["mission.toml: vehicles[0].speed_max_m_s = 7.0", "must not exceed limits.speed_max_m_s = 5.0", "profile.toml"],
    ),
    "separation wider than the hold geometry": (
        "p2",
        [],
        [(("safety", "separation_min_m"), 4.3)],
        ["profile.toml: safety.separation_min_m = 4.3", "must be smaller than 4.40 m", "2 pursuers hold", "mission.toml"],
    ),
    "volume smaller than the stopping distance": (
        "p1",
        [
            (("flight_volume", "vertices_m"), SMALL),
            (("vehicles", 2, "start"), {"north_m": 3.0, "east_m": 0.0}),
            (("obstacles",), {}),
        ],
        [],
        ["mission.toml: flight_volume.vertices_m", "too small", "must be free", "limits.speed_max_m_s = 5.0", "profile.toml"],
    ),
    "height at the edge of the band": (
        "p1",
        [(("vehicles", 0, "height_m"), 1.6)],
        [],
        ["mission.toml: vehicles[0]", "1.6 m", "must lie between 1.7 m and", "safety.height_margin_m = 0.2", "profile.toml"],
    ),
    "starts closer than the separation": (
        "p1",
        [(("vehicles", 1, "start", "east_m"), -6.7)],
        [],
        ["mission.toml: vehicles[0].start = (0.0, -8.0)", "1.30 m from vehicles[1]", "must be at least 1.70 m", "profile.toml"],
    ),
    "stations closer than the separation": (
        "p1",
        [
            (("ingress",), "planned"),
            (("vehicles", 0, "station"), {"north_m": 1.0, "east_m": 1.0}),
            (("vehicles", 1, "station"), {"north_m": 1.0, "east_m": 2.0}),
        ],
        [],
        ["mission.toml: vehicles[0].station = (1.0, 1.0)", "1.00 m from where vehicles[1] waits", "must be at least 1.70 m"],
    ),
    "a camera that the profile has not": (
        "p1",
        [],
        [(("camera",), {"source": "none"})],
        ["mission.toml: vehicles[0].camera = true", "camera.source = 'none' in profile.toml", "must be false"],
    ),
}


@pytest.mark.parametrize(("name", "mission", "profile", "wanted"), CASES.values(), ids=CASES.keys())
def test_a_contradiction_names_both_files_the_field_the_value_and_what_would_be_right(
    name: str, mission: list[Change], profile: list[Change], wanted: list[str]
) -> None:
    sentence = _check(name, mission, profile)
    assert len(sentence.splitlines()) == 1
    for part in wanted:
        assert part in sentence


def test_an_evader_is_not_bound_by_the_pursuers_rules() -> None:
    profile: list[Any] = [(("safety", "target_keep_out_m"), 2.5), (("safety", "separation_min_m"), 4.3)]
    assert _check("e1", [], profile) == ""
