from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from tests.config.tables import MISSION, REMOVED, Change, mission_refusal

CROSSED = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]]
DOUBLED = [[-15.0, -30.0], [65.0, -30.0], [65.0, -30.0], [65.0, 30.0], [-15.0, 30.0]]
RING = [[-10.0, -30.0], [5.0, -30.0], [5.0, 30.0], [-10.0, 30.0]]


def at(*path: str | int, value: Any) -> Change:
    return path, value


CASES: dict[str, tuple[list[Change], list[str]]] = {
    "wrong unit": (
        [at("vehicles", 2, "speed_max_km_h", value=9.0)],
        ["vehicles[2].speed_max_km_h = 9.0", "unknown field", "did you mean 'speed_max_m_s'?"],
    ),
    "unknown table": ([at("telescope", value={"zoom": 1})], ["telescope = {...}", "unknown field", "known here: ", "vehicles"]),
    "unknown field, nested": (
        [at("vehicles", 0, "strategy", value={"name": "ac2f", "seed": 3})],
        ["vehicles[0].strategy.seed = 3", "known here: name, parameters, parameters_file"],
    ),
    "missing table": ([at("datum", value=REMOVED)], ["datum: missing; this field is required"]),
    "missing field": ([at("vehicles", 1, "system_id", value=REMOVED)], ["vehicles[1].system_id: missing"]),
    "text for a number": ([at("time_limit_s", value="90")], ["time_limit_s = '90'", "must be a number"]),
    "number for a text": ([at("fleet", value=3)], ["fleet = 3", "must be a text in quotes"]),
    "truth for a number": ([at("time_limit_s", value=True)], ["time_limit_s = true", "must be a number"]),
    "number for a truth": ([at("vehicles", 0, "camera", value=1)], ["vehicles[0].camera = 1", "must be true or false"]),
    "fraction for a whole number": (
        [at("vehicles", 0, "system_id", value=1.5)],
        ["vehicles[0].system_id = 1.5", "must be a whole number"],
    ),
    "number for a table": ([at("vehicles", 0, "start", value=3)], ["vehicles[0].start = 3", "must be a table"]),
    "number for a list": ([at("vehicles", value=3)], ["vehicles = 3", "must be a list"]),
    "NaN": ([at("datum", "latitude_deg", value=math.nan)], ["datum.latitude_deg = nan", "must be a finite number"]),
    "infinity": ([at("height_m", value=math.inf)], ["height_m = inf", "must be a finite number"]),
    "zero limit": (
        [at("vehicles", 2, "speed_max_m_s", value=0.0)],
        ["vehicles[2].speed_max_m_s = 0.0", "must be greater than 0"],
    ),
    "zero time": ([at("time_limit_s", value=0)], ["time_limit_s = 0", "must be greater than 0"]),
    "latitude off the Earth": ([at("datum", "latitude_deg", value=97.0)], ["datum.latitude_deg = 97.0", "must be at most 85"]),
    "unknown role": ([at("vehicles", 0, "role", value="hunter")], ["vehicles[0].role = 'hunter'", "'pursuer' or 'evader'"]),
    "bad name": ([at("vehicles", 0, "name", value="P 1")], ["vehicles[0].name = 'P 1'", "must match the pattern"]),
    "empty strategy": ([at("vehicles", 0, "strategy", "name", value="")], ["strategy.name = ''", "must not be empty"]),
    "no vehicles": ([at("vehicles", value=[])], ["vehicles = []", "must not be empty"]),
    "odd parameter": (
        [at("vehicles", 0, "strategy", "parameters", value={"gain": [["x"]]})],
        ["vehicles[0].strategy.parameters.gain", "must be a number, true or false, a text"],
    ),
    "same system id": (
        [at("vehicles", 1, "system_id", value=1)],
        ["vehicles[1].system_id = 1", "vehicles[0] has it too", "system ids must differ"],
    ),
    "same name": ([at("vehicles", 1, "name", value="p1")], ["vehicles[1].name = 'p1'", "names must differ"]),
    "two evaders": ([at("vehicles", 1, "role", value="evader")], ["vehicles[2].role = 'evader'", "one is supported"]),
    "faults of nobody": (
        [at("simulation", "faults", value={"zz": "a.toml"})],
        ["simulation.faults.zz", "no vehicle has this name", "known: p1, p2, e1"],
    ),
    "evader outside the area": (
        [at("vehicles", 2, "start", "north_m", value=500.0)],
        ["vehicles[2].start = (500.0, 2.0)", "evader 'e1' starts outside", "must lie inside flight_volume.vertices_m"],
    ),
    "start too far from the datum": (
        [at("vehicles", 2, "start", "north_m", value=5e6)],
        ["vehicles[2].start.north_m = 5000000.0", "must be at most 20000"],
    ),
    "start on top of another": (
        [at("vehicles", 1, "start", "east_m", value=-8.4)],
        ["vehicles[1].start = (0.0, -8.4)", "closer than 1 m to vehicles[0]", "must be apart"],
    ),
    "start inside a cylinder": (
        [at("vehicles", 0, "start", value={"north_m": 12.0, "east_m": -6.5})],
        ["vehicles[0].start = (12.0, -6.5)", "obstacles.cylinders[0]", "move the start or the obstacle"],
    ),
    "start inside a box": (
        [at("vehicles", 0, "start", value={"north_m": 21.0, "east_m": 14.0})],
        ["vehicles[0].start = (21.0, 14.0)", "obstacles.boxes[0]"],
    ),
    "fence that crosses itself": (
        [at("flight_volume", "vertices_m", value=CROSSED)],
        ["flight_volume.vertices_m = [[0.0, 0.0]", "crosses itself or has no area", "in order around"],
    ),
    "fence without area": (
        [at("flight_volume", "vertices_m", value=[[0.0, 0.0], [5.0, 0.0], [9.0, 0.0]])],
        ["flight_volume.vertices_m", "has no area"],
    ),
    "fence with a doubled vertex": (
        [at("flight_volume", "vertices_m", value=DOUBLED)],
        ["flight_volume.vertices_m", "vertices 1 and 2 are the same point (65.0, -30.0)", "list each once"],
    ),
    "fence that returns to its start": (
        [at("flight_volume", "vertices_m", value=[*RING, RING[0]])],
        ["flight_volume.vertices_m", "returns to its first vertex by itself"],
    ),
    "fence of two": ([at("flight_volume", "vertices_m", value=RING[:2])], ["flight_volume.vertices_m", "at least 3 entries"]),
    "vertex of three numbers": (
        [at("flight_volume", "vertices_m", value=[[0.0, 0.0], [9.0, 1.0, 3.0], [9.0, 9.0]])],
        ["flight_volume.vertices_m[1] = [9.0, 1.0, 3.0]", "must have at most 2 entries"],
    ),
    "NaN in a vertex": (
        [at("flight_volume", "vertices_m", value=[[0.0, 0.0], [math.nan, 1.0], [9.0, 9.0]])],
        ["flight_volume.vertices_m[1][0] = nan", "must be a finite number"],
    ),
    "band upside down": (
        [at("flight_volume", "height_max_m", value=1.0)],
        ["flight_volume.height_max_m = 1.0", "must be greater than height_min_m = 1.5"],
    ),
    "flight height outside the band": (
        [at("height_m", value=50.0)],
        ["height_m = 50.0", "must lie between height_min_m = 1.5 and height_max_m"],
    ),
    "own height outside the band": (
        [at("vehicles", 1, "height_m", value=1.0)],
        ["vehicles[1].height_m = 1.0", "must lie between"],
    ),
    "boundary with a doubled vertex": (
        [at("boundary", "vertices_m", value=[[0.0, -30.0], [0.0, 1.0], [0.0, 1.0]])],
        ["boundary.vertices_m", "vertices 1 and 2 are the same point (0.0, 1.0)"],
    ),
    "boundary of one vertex": ([at("boundary", "vertices_m", value=[[0.0, 0.0]])], ["boundary.vertices_m", "at least 2 entries"]),
    "boundary that crosses itself": (
        [at("boundary", "vertices_m", value=CROSSED)],
        ["boundary.vertices_m", "crosses itself", "in order"],
    ),
    "closed boundary of two": (
        [at("boundary", value={"vertices_m": [[0.0, 0.0], [0.0, 9.0]], "closed": True})],
        ["boundary.vertices_m", "must have at least 3 vertices"],
    ),
    "closed boundary that crosses itself": (
        [at("boundary", value={"vertices_m": [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [4.0, -3.0]], "closed": True})],
        ["boundary.vertices_m", "crosses itself"],
    ),
    "boundary out of reach": (
        [at("boundary", "vertices_m", value=[[-500.0, -30.0], [-500.0, 30.0]])],
        ["boundary.vertices_m", "outside the flight volume", "must run through"],
    ),
    "evader inside the protected area": (
        [
            at("boundary", value={"vertices_m": RING, "closed": True}),
            at("vehicles", 2, "start", value={"north_m": 2.0, "east_m": 0.0}),
        ],
        ["vehicles[2].start = (2.0, 0.0)", "inside the protected boundary", "must start outside"],
    ),
    "hold radius beyond the capture radius": (
        [at("capture", "hold_radius_m", value=9.0)],
        ["capture.hold_radius_m = 9.0", "must not exceed radius_m = 3.0"],
    ),
}


@pytest.mark.parametrize(("changes", "wanted"), CASES.values(), ids=CASES.keys())
def test_the_sentence_names_file_field_value_and_what_would_be_right(
    changes: list[Change], wanted: list[str], tmp_path: Path
) -> None:
    sentence = mission_refusal(tmp_path, *changes)
    assert sentence.startswith("file.toml: ")
    assert "\n" not in sentence
    for part in wanted:
        assert part in sentence


def test_every_finding_gets_its_own_sentence(tmp_path: Path) -> None:
    sentences = mission_refusal(tmp_path, at("height_m", value=-1.0), at("wind", value=3), at("datum", "altitude_m", value="x"))
    assert len(sentences.splitlines()) == 3


def test_a_single_vehicle_without_an_evader_is_a_mission(tmp_path: Path) -> None:
    assert mission_refusal(tmp_path, at("vehicles", value=MISSION["vehicles"][:1])) == ""


def test_a_return_below_an_obstacle_or_above_the_ceiling_is_refused(tmp_path: Path) -> None:
    low = mission_refusal(tmp_path, at("return_height_m", value=8.0))
    assert "return_height_m = 8.0" in low
    assert "greater than the tallest obstacle, 9 m" in low
    high = mission_refusal(tmp_path, at("return_height_m", value=14.5))
    assert "vehicles[2] returns at 18.5 m" in high
    assert "height_max_m = 18" in high


def test_ground_above_the_flight_height_is_refused(tmp_path: Path) -> None:
    refused = mission_refusal(tmp_path, at("vehicles", 0, "start", "ground_height_m", value=4.5))
    assert "vehicles[0].start.ground_height_m = 4.5" in refused
    assert "at least 1 m" in refused


def test_a_dwell_longer_than_the_pursuit_is_refused(tmp_path: Path) -> None:
    assert "capture.dwell_s" in mission_refusal(tmp_path, at("time_limit_s", value=1.0))
