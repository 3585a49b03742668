"""The recorded evader: passes the points of its track, at the wanted speed, from where it stands; bad tracks are one sentence."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.config.parameter_files import beside
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.api import Planner
from flightapp.planning.evasion.recorded import Recorded
from flightapp.planning.evasion.track_file import HEADER, read_track
from flightapp.planning.registry import make_evader
from flightapp.runtime.composition import build_strategy
from flightapp.sim.batch.scenario import load_scenario
from tests.planning.evasion.flight import LIMITS, fly

ROW = "{t},{x},{y},1.0,0.0,0.0,0.0,1.0"
START = (60.0, 5.0)
MISSIONS = Path(__file__).parents[3] / "missions"


def write(path: Path, rows: list[tuple[float, float, float]]) -> Path:
    """A track file of rows t, x, y."""
    path.write_text("\n".join([HEADER, *(ROW.format(t=t, x=x, y=y) for t, x, y in rows)]) + "\n")
    return path


@pytest.fixture
def bend(tmp_path: Path) -> Path:
    """12 m and a quarter of a circle at 3 m/s, beginning anywhere."""
    way = [0.3 * k for k in range(90)]
    bent = [
        (s, 0.0) if s < 12.0 else (12.0 + 8.0 * math.sin((s - 12.0) / 8.0), 8.0 - 8.0 * math.cos((s - 12.0) / 8.0)) for s in way
    ]
    return write(tmp_path / "bend.txt", [(100.0 + 0.1 * k, 7.0 + x, -3.0 + y) for k, (x, y) in enumerate(bent)])


def recorded(file: Path, limits: Limits = LIMITS, **parameters: Any) -> Planner:
    return make_evader("recorded", limits=limits, parameters={"file": str(file), **parameters})


def laid_out(rows: np.ndarray[Any, Any], start: tuple[float, float], bearing_rad: float) -> np.ndarray[Any, Any]:
    """The places of a track from `start`, its farthest point at `bearing_rad`."""
    places = rows[:, 1:] - rows[0, 1:]
    farthest = places[np.argmax(np.hypot(places[:, 0], places[:, 1]))]
    turn = bearing_rad - math.atan2(farthest[1], farthest[0])
    cos, sin = math.cos(turn), math.sin(turn)
    return np.asarray(np.array(start) + places @ np.array([[cos, sin], [-sin, cos]]))


def farthest_from(path: list[tuple[float, float]], places: np.ndarray[Any, Any]) -> float:
    """Greatest distance of one of `places` from the nearest point of `path`."""
    flown = np.array(path)
    return float(np.hypot(*np.moveaxis(places[:, None] - flown[None], 2, 0)).min(axis=1).max())


@pytest.mark.parametrize(("scale", "rotation_deg"), [(1.0, 0.0), (0.5, 0.0), (1.2, 70.0)])
def test_it_passes_every_point_at_the_scaled_speed(bend: Path, scale: float, rotation_deg: float) -> None:
    rows = read_track(bend)
    flight = fly(recorded(bend, speed_scale=scale, rotation_deg=rotation_deg), START, rows[-1, 0] / scale + 3.0)
    places = laid_out(rows, START, math.pi + math.radians(rotation_deg))
    assert farthest_from(flight.path, places) < 0.5
    assert math.dist(flight.path[20], flight.path[30]) == pytest.approx(3.0 * scale, rel=0.05)
    assert math.dist(flight.path[-1], places[-1]) < 0.1


def test_it_leads_towards_the_boundary(bend: Path) -> None:
    flight = fly(recorded(bend), START, 12.0)
    assert flight.path[-1][0] < START[0] - 15.0
    assert flight.path[-1][1] == pytest.approx(START[1], abs=0.5)


def test_a_track_that_is_too_fast_is_flown_as_fast_as_the_vehicle_can(bend: Path) -> None:
    """Its points are passed nevertheless."""
    slow = Limits(1.5, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
    flight = fly(recorded(bend, slow), START, 25.0)
    places = laid_out(read_track(bend), START, math.pi)
    assert farthest_from(flight.path, places) < 0.5
    speeds = [float(np.hypot(*decision.velocity_ned_m_s[:2])) for decision in flight.decisions]
    assert max(speeds) <= 1.5 + 1e-9


def test_it_may_begin_later_in_the_track(bend: Path) -> None:
    flight = fly(recorded(bend, start_s=6.0), START, 6.0)
    rows = read_track(bend)
    assert math.dist(flight.path[-1], START) == pytest.approx(math.dist(rows[60, 1:], rows[-1, 1:]), abs=0.2)


def test_a_loop_goes_on_from_its_end(bend: Path) -> None:
    once, twice = (fly(recorded(bend, loop=loop), START, 17.0) for loop in (False, True))
    lap_m = math.dist(once.path[-1], START)
    assert math.dist(twice.path[-1], START) > 1.5 * lap_m


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["line 1 = ''", HEADER]),
        ("t,x,y\n1,2,3\n", ["line 1 = 't,x,y'", HEADER]),
        (f"{HEADER}\n0,1,2,3,0,0,0,1\n", ["1 rows", "at least 2"]),
        (f"{HEADER}\n0,1,2,3,0,0,0,1\n0.1,fast,2,3,0,0,0,1\n", ["line 3", "tx = 'fast'", "finite number"]),
        (f"{HEADER}\n0,1,2,3,0,0,0,1\n0.1,1,nan,3,0,0,0,1\n", ["line 3", "ty = 'nan'", "finite number"]),
        (f"{HEADER}\n0,1,2,3,0,0,0,1\n\n0.1,1,2\n", ["line 4", "3 values", "must be 8"]),
        (f"{HEADER}\n1,1,2,3,0,0,0,1\n\n0.5,1,2,3,0,0,0,1\n", ["line 4", "timestamp = 0.5", "later than"]),
    ],
)
def test_a_bad_track_is_refused_in_one_sentence(tmp_path: Path, text: str, words: list[str]) -> None:
    file = tmp_path / "bad.txt"
    file.write_text(text)
    with pytest.raises(InputError) as error:
        recorded(file)
    assert "bad.txt" in str(error.value)
    assert "\n" not in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_a_missing_track_and_a_start_beyond_its_end_are_refused(tmp_path: Path, bend: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.txt: no such file"):
        recorded(tmp_path / "nowhere.txt")
    with pytest.raises(InputError, match=r"start_s = 60\.0: .*bend\.txt ends after 8\.9 s"):
        recorded(bend, start_s=60.0)


def test_files_named_by_parameters_lie_beside_the_file_that_names_them() -> None:
    given = {"file": "tracks/a.txt", "weights_file": "/data/w.toml", "speed_scale": 0.5}
    assert beside(given, Path("missions")) == {
        "file": "missions/tracks/a.txt",
        "weights_file": "/data/w.toml",
        "speed_scale": 0.5,
    }


def test_missions_and_scenarios_find_the_track_beside_them(tmp_path: Path, bend: Path) -> None:
    text = (MISSIONS / "demo_two_pursuers.toml").read_text()
    strategy = 'strategy = { name = "boundary-seeking" }'
    assert strategy in text
    path = tmp_path / "mission.toml"
    path.write_text(text.replace(strategy, f'strategy = {{ name = "recorded", parameters = {{ file = "{bend.name}" }} }}'))
    mission = load_mission(path)
    profile = load_profile(MISSIONS.parent / "profiles" / "sim.toml")
    assert isinstance(build_strategy(mission, mission.vehicles[-1], profile, path, 0), Recorded)
    scenario = tmp_path / "scenario.toml"
    dense = (MISSIONS / "scenarios" / "a2-dense.toml").resolve()
    scenario.write_text(f'extends = "{dense}"\n[evader]\npolicy = "recorded"\nparameters = {{ file = "{bend.name}" }}\n')
    assert load_scenario(scenario).evader.parameters["file"] == str(bend)


@pytest.fixture
def racing_tracks() -> list[Path]:
    """Real racing tracks; skips where they are absent."""
    root = Path(os.environ.get("FLIGHTAPP_DATA", Path(__file__).parents[3] / ".." / "shared" / "data"))
    folder = (root / "tracks" / "uzh_fpv_10hz").resolve()
    if not folder.is_dir():
        pytest.skip("no recorded racing tracks here; name their folder in FLIGHTAPP_DATA")
    return sorted(folder.glob("*.txt"))


def test_real_racing_tracks_are_flown_point_by_point(racing_tracks: list[Path]) -> None:
    assert racing_tracks
    for file in racing_tracks:
        rows = read_track(file)
        flight = fly(recorded(file, speed_scale=0.4), START, rows[-1, 0] / 0.4 + 5.0)
        assert farthest_from(flight.path, laid_out(rows, START, math.pi)) < 0.8, file.name
