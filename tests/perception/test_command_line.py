"""`python -m perception`: pictures and discs of recorded frames; one sentence on bad input."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.cli import main
from tests.perception.scenes import MakeStage, pose

D435 = "421.6,421.6,424,240"


def listed(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> list[dict]:
    assert main([str(argument) for argument in (*arguments, "--json")]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture
def frames(scene: MakeStage, tmp_path: Path) -> Path:
    folder = tmp_path / "frames"
    folder.mkdir()
    world = scene(cylinders=[(4.0, 1.0, 0.3, 9.0)])
    for number in range(2):
        cv2.imwrite(str(folder / f"{number}.png"), world.shoot(pose()).depth)
    return folder


def test_every_frame_gets_a_picture_and_its_discs(frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out" / "pictures"
    rows = listed(capsys, frames, "--intrinsics", D435, "--out", out)
    assert [Path(row["file"]).name for row in rows] == ["0.png", "1.png"]
    for row in rows:
        (disc,) = row["discs"]
        assert (disc["north_m"], disc["east_m"], disc["radius_m"]) == pytest.approx((3.9, 1.0, 0.3), abs=0.2)
        assert cv2.imread(row["picture"]).shape == (480, 848 + 480, 3)
    assert sorted(file.name for file in out.iterdir()) == ["0-discs.png", "1-discs.png"]


def test_the_table_names_distance_and_bearing(frames: Path, tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "perception", frames / "0.png", "--intrinsics", D435, "--out", tmp_path / "out"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "distance_m" in run.stdout
    assert "0-discs.png" in run.stdout


def test_an_empty_frame_is_an_event(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "dark.png"), np.zeros((480, 848), np.uint16))
    (row,) = listed(capsys, tmp_path / "dark.png", "--intrinsics", D435, "--out", tmp_path / "out")
    assert row["discs"] == []
    assert row["unseen_deg"] == [[-180.0, 180.0]]
    assert "empty" in row["events"][0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frames": "nowhere"}, "nowhere: no such file or folder"),
        ({"frames": "hollow"}, "hollow: the folder has no .png file"),
        ({"frames": "eight.png"}, "eight.png: 8-bit image with 3 channel(s); 16-bit with one channel is wanted"),
        ({"frames": "mixed"}, "mixed/1.png: 64x48 pixels, 0.png has 848x480"),
        ({"frames": "spoilt"}, "spoilt/9.png: not a readable image"),
        ({"intrinsics": "421,421,424"}, "--intrinsics = '421,421,424': four numbers FX,FY,CX,CY"),
        ({"intrinsics": "421,421,x,240"}, "--intrinsics = '421,421,x,240': four numbers"),
        ({"intrinsics": "421,421,1424,240"}, "the centre (1424, 240) lies outside the 848x480 image"),
        ({"extra": ["--height-m", "-1"]}, "--height-m = -1.0: a positive number is wanted"),
        ({"extra": ["--range-min-m", "20"]}, "--range-min-m = 20.0"),
        ({"out": "eight.png"}, "cannot be made a folder"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(
    change: dict, said: str, frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "hollow").mkdir()
    cv2.imwrite(str(tmp_path / "eight.png"), np.zeros((480, 848, 3), np.uint8))
    for folder, name, image in (("mixed", "1.png", np.ones((48, 64), np.uint16)), ("spoilt", "9.png", None)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "0.png").write_bytes((frames / "0.png").read_bytes())
        if image is None:
            (tmp_path / folder / name).write_bytes(b"no image")
        else:
            cv2.imwrite(str(tmp_path / folder / name), image)
    source = tmp_path / change["frames"] if "frames" in change else frames
    out = tmp_path / change.get("out", "out")
    before = sorted(tmp_path.rglob("*"))
    status = main([str(source), "--intrinsics", change.get("intrinsics", D435), "--out", str(out), *change.get("extra", [])])
    captured = capsys.readouterr()
    assert status == 2
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert sorted(tmp_path.rglob("*")) == before


def test_the_person_in_a_real_frame_is_found_at_the_right_distance(
    depth_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = listed(capsys, depth_data / "nvblox_human", "--intrinsics", "393.02,393.02,320.28,243.87", "--out", tmp_path)
    discs = rows[0]["discs"]
    # The person stands 2.1 to 2.4 m ahead, between 9 and 22 degrees to the left, before an open corridor.
    person = [disc for disc in discs if -22 < disc["bearing_deg"] < -9 and disc["distance_m"] < 3]
    assert person
    assert min(disc["distance_m"] for disc in person) == pytest.approx(2.05, abs=0.3)
    assert not [disc for disc in discs if -3 < disc["bearing_deg"] < 8 and disc["distance_m"] < 8]


def test_far_noise_in_real_frames_is_no_obstacle(depth_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = listed(capsys, depth_data / "aims_slam", "--intrinsics", "385,385,320,240", "--out", tmp_path)
    assert len(rows) == 8
    for row in rows:
        assert row["discs"]
        assert row["events"] == []
        assert max(disc["distance_m"] for disc in row["discs"]) < 9.0


def test_real_indoor_frames_show_near_obstacles(depth_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = listed(capsys, depth_data / "felixchenfy", "--intrinsics", "617.25,617.55,317.39,245.98", "--out", tmp_path)
    for row in rows:
        assert 0.3 < row["discs"][0]["distance_m"] < 2.5
        assert len(row["discs"]) < 25
