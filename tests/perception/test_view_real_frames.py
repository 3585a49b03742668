"""Real depth frames through `python -m perception`: its discs against the raw depth, which the tests read on their own."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.cli import main

BAND_M = 0.3


@dataclass(frozen=True)
class Recording:
    """How a set of frames was taken. The floor was fitted to the frames; of the hand-held set it is not known."""

    folder: str
    focal_px: float
    centre_px: tuple[float, float]
    height_m: float | None
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def options(self) -> list[str]:
        lens = f"{self.focal_px},{self.focal_px},{self.centre_px[0]},{self.centre_px[1]}"
        height = [] if self.height_m is None else ["--height-m", str(self.height_m)]
        return ["--intrinsics", lens, "--pitch-deg", str(self.pitch_deg), "--roll-deg", str(self.roll_deg), *height]


PERSON = Recording("nvblox_human", 393.02, (320.28, 243.87), height_m=0.34)
ROBOT = Recording("aims_slam", 385.0, (320.0, 240.0), height_m=0.6, pitch_deg=-19.5, roll_deg=10.0)
HAND_HELD = Recording("felixchenfy", 617.4, (317.39, 245.98), height_m=None)


def listed(recording: Recording, depth_data: Path, capsys: pytest.CaptureFixture[str], *more: str) -> list[dict]:
    assert main([str(depth_data / recording.folder), *recording.options(), *more, "--json"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert rows
    return rows


def discs_of(row: dict) -> np.ndarray:
    """(n, 3) north_m, east_m, radius_m."""
    return np.array([[disc["north_m"], disc["east_m"], disc["radius_m"]] for disc in row["discs"]]).reshape(-1, 3)


def raw_depth_m(recording: Recording, depth_data: Path, name: str) -> np.ndarray:
    return cv2.imread(str(depth_data / recording.folder / name), cv2.IMREAD_UNCHANGED) * 0.001


def first_disc_m(discs: np.ndarray, bearing_rad: float) -> float:
    """Distance along a bearing to the first disc, inf if there is none."""
    along = discs[:, 0] * math.cos(bearing_rad) + discs[:, 1] * math.sin(bearing_rad)
    across = discs[:, 1] * math.cos(bearing_rad) - discs[:, 0] * math.sin(bearing_rad)
    hit = (np.abs(across) < discs[:, 2]) & (along > 0)
    return float((along[hit] - np.sqrt(discs[hit, 2] ** 2 - across[hit] ** 2)).min(initial=np.inf))


def standing_points(recording: Recording, depth: np.ndarray, clear_m: float, clear_slope: float) -> np.ndarray:
    """(n, 3) north, east, distance along the optical axis of what stands in the height band, clear of the floor."""
    v, u = np.nonzero(depth > 0.3)
    z = depth[v, u]
    right, down, forward = (
        (u - recording.centre_px[0]) / recording.focal_px * z,
        (v - recording.centre_px[1]) / recording.focal_px * z,
        z,
    )
    roll, pitch = math.radians(recording.roll_deg), math.radians(recording.pitch_deg)
    right, down = right * math.cos(roll) - down * math.sin(roll), right * math.sin(roll) + down * math.cos(roll)
    forward, down = forward * math.cos(pitch) + down * math.sin(pitch), down * math.cos(pitch) - forward * math.sin(pitch)
    floor_down_m = math.inf if recording.height_m is None else recording.height_m
    standing = (np.abs(down) < BAND_M) & (down < floor_down_m - clear_m - clear_slope * z)
    return np.column_stack([forward, right, z])[standing]


class TestThePerson:
    """Walks beside a wall, 2.1 m before a small robot that looks down a corridor of 30 m."""

    LEG = np.s_[205:285, 195:212]
    BACK = np.s_[80:160, 205:250]

    @pytest.mark.parametrize(("part", "band_m"), [(LEG, 0.3), (BACK, 1.0)])
    def test_is_found_at_the_distance_of_its_pixels(
        self, part: tuple[slice, slice], band_m: float, depth_data: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (row,) = listed(PERSON, depth_data, capsys, "--band-m", str(band_m))
        depth = raw_depth_m(PERSON, depth_data, row["name"])[part]
        columns = np.arange(part[1].start, part[1].stop)
        bearing = math.atan((columns.mean() - PERSON.centre_px[0]) / PERSON.focal_px)
        distance_m = float(np.median(depth[depth > 0])) / math.cos(bearing)
        assert 2.0 < distance_m < 2.6
        assert first_disc_m(discs_of(row), bearing) == pytest.approx(distance_m, abs=0.35)

    def test_the_corridor_beside_it_is_free_and_its_noisy_end_empty(
        self, depth_data: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (row,) = listed(PERSON, depth_data, capsys)
        depth = raw_depth_m(PERSON, depth_data, row["name"])
        far = depth[170:250, 310:380]
        assert np.percentile(far[far > 0], (5, 95)).tolist() == pytest.approx([13, 30], abs=4)
        for column in range(310, 380, 5):
            bearing = math.atan((column - PERSON.centre_px[0]) / PERSON.focal_px)
            assert first_disc_m(discs_of(row), bearing) > 8, f"column {column}"
        assert row["events"] == []


ALL = pytest.mark.parametrize("recording", [PERSON, ROBOT, HAND_HELD], ids=lambda recording: recording.folder)


class TestEveryFrame:
    @ALL
    def test_what_stands_near_is_covered_by_discs(
        self, recording: Recording, depth_data: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for row in listed(recording, depth_data, capsys):
            points = standing_points(recording, raw_depth_m(recording, depth_data, row["name"]), 0.35, 0.05)
            near, discs = points[points[:, 2] < 4], discs_of(row)
            assert len(near) > 500, row["name"]
            outside_m = (np.hypot(near[:, :1] - discs[:, 0], near[:, 1:2] - discs[:, 1]) - discs[:, 2]).min(axis=1)
            assert np.mean(outside_m > 0.2) < 0.03, row["name"]
            assert row["events"] == []

    @ALL
    def test_no_disc_stands_where_nothing_does(
        self, recording: Recording, depth_data: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for row in listed(recording, depth_data, capsys):
            points = standing_points(recording, raw_depth_m(recording, depth_data, row["name"]), 0.2, 0.02)
            # The floor was fitted to the nearest metres: an error of a degree lifts it into the band further away.
            for disc in (disc for disc in row["discs"] if disc["distance_m"] < 5):
                gap_m = np.hypot(points[:, 0] - disc["north_m"], points[:, 1] - disc["east_m"]) - disc["radius_m"]
                assert np.count_nonzero(gap_m < 0.25) >= 12, f"{row['name']}, disc {disc['number']}"

    @ALL
    def test_far_noise_is_no_obstacle(self, recording: Recording, depth_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
        for row in listed(recording, depth_data, capsys):
            # The range ends at 10 m along the optical axis; a ray at the corner of the picture is 1.3 times as long.
            assert all(disc["distance_m"] < 13 for disc in row["discs"]), row["name"]
