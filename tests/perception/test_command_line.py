"""`python -m perception`: pictures and discs of recorded frames; one sentence on bad input."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.cli import main
from tests.perception.scenes import MakeStage, pose

needs_sdk = pytest.mark.skipif(find_spec("pyrealsense2") is None, reason="pyrealsense2 is not installed")
D435 = "421.6,421.6,424,240"


def listed(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict]:
    """The frames as `--json` lists them."""
    assert main([str(argument) for argument in (*arguments, "--json")]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


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
    assert [row["name"] for row in rows] == ["0.png", "1.png"]
    for row in rows:
        (disc,) = row["discs"]
        assert (disc["north_m"], disc["east_m"], disc["radius_m"]) == pytest.approx((3.9, 1.0, 0.3), abs=0.2)
        assert disc["bearing_deg"] == disc["off_axis_deg"] == pytest.approx(14.0, abs=2)
        assert cv2.imread(row["picture"]).shape == (480 + 64, 848 + 560, 3)
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
    assert run.stderr.startswith("1 frame in ")


def test_a_list_alone_writes_no_file(frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(tmp_path.rglob("*"))
    rows = listed(capsys, frames, "--intrinsics", D435)
    assert [row["picture"] for row in rows] == [None, None]
    assert sorted(tmp_path.rglob("*")) == before


def test_whoever_reads_the_list_may_stop_reading(frames: Path) -> None:
    command = [sys.executable, "-m", "perception", frames, "--intrinsics", D435, "--json"]
    view = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert view.stdout is not None
    view.stdout.close()
    _, said = view.communicate(timeout=110)
    assert view.returncode == 0
    assert "Traceback" not in said
    assert "BrokenPipe" not in said


def test_an_empty_frame_is_an_event(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "dark.png"), np.zeros((480, 848), np.uint16))
    (row,) = listed(capsys, tmp_path / "dark.png", "--intrinsics", D435, "--out", tmp_path / "out")
    assert row["discs"] == []
    assert row["unseen_deg"] == [[-180.0, 180.0]]
    assert "empty" in row["events"][0]


def test_separate_images_are_not_one_sequence_unless_asked(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cv2.imwrite(str(frames / "2.png"), np.zeros((480, 848), np.uint16))
    apart = listed(capsys, frames, "--intrinsics", D435)
    together = listed(capsys, frames, "--intrinsics", D435, "--memory")
    assert apart[2]["discs"] == []
    (remembered,) = together[2]["discs"]
    assert (remembered["north_m"], remembered["east_m"]) == pytest.approx((3.9, 1.0), abs=0.2)
    assert remembered["age_s"] > 0
    assert together[1]["t_s"] - together[0]["t_s"] == pytest.approx(1 / 30, abs=1e-4)


def test_what_lies_in_an_excluded_circle_is_no_obstacle(frames: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = listed(capsys, frames, "--intrinsics", D435, "--exclude", "4,1,0.8")
    assert [row["discs"] for row in rows] == [[], []]


def test_frames_ends_early_and_every_thins_out_the_pictures(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in range(2, 6):
        (frames / f"{number}.png").write_bytes((frames / "0.png").read_bytes())
    rows = listed(capsys, frames, "--intrinsics", D435, "--out", tmp_path / "out", "--frames", 5, "--every", 2)
    assert [row["name"] for row in rows] == [f"{number}.png" for number in range(5)]
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [f"{n}-discs.png" for n in (0, 2, 4)]


def test_a_tilted_camera_sees_no_obstacle_in_the_floor(
    scene: MakeStage, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """20 degrees down, 8 right side down: taken for level, the floor would stand in the way."""
    depth = scene().shoot(pose(height=1.0, pitch_deg=-20, roll_deg=8)).depth
    cv2.imwrite(str(tmp_path / "floor.png"), depth)
    told = ["--intrinsics", D435, "--pitch-deg", -20, "--roll-deg", 8, "--height-m", 1]
    (right,) = listed(capsys, tmp_path / "floor.png", *told)
    (wrong,) = listed(capsys, tmp_path / "floor.png", "--intrinsics", D435)
    assert right["discs"] == []
    assert wrong["discs"]


def test_a_profile_brings_mounting_range_and_parameters(frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "profile.toml"
    profile.write_text("[camera]\nrange_max_m = 6.0\n[camera.mounting]\nforward_m = 1.0\n[perception]\nband_m = 0.5\n")
    (row, _) = listed(capsys, frames, "--intrinsics", D435, "--profile", profile)
    (disc,) = row["discs"]
    assert disc["north_m"] == pytest.approx(4.9, abs=0.2)
    assert disc["distance_m"] == pytest.approx(3.7, abs=0.2)
    profile.write_text("[camera]\nrange_max_m = 3.0\n")
    assert listed(capsys, frames, "--intrinsics", D435, "--profile", profile)[0]["discs"] == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[camera\n", "not a TOML file"),
        ("camera = 3\n", "camera = 3: a table is wanted"),
        ("[camera.mounting]\npitch_deg = 'up'\n", "pitch_deg = 'up': a number is wanted"),
        ("[perception]\nstride_px = 40\n", "perception.stride_px: Input should be less than or equal to 8"),
        ("[perception]\ncolour = 1\n", "perception.colour: Extra inputs are not permitted"),
    ],
)
def test_a_bad_profile_is_one_sentence(
    text: str, said: str, frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = tmp_path / "profile.toml"
    profile.write_text(text)
    assert main([str(frames), "--intrinsics", D435, "--profile", str(profile)]) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert "profile.toml" in captured.err
    assert captured.err.count("\n") == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frames": "nowhere"}, "nowhere': no such file, folder or camera"),
        ({"frames": "hollow"}, "hollow: the folder has no .png file"),
        ({"frames": "eight.png"}, "eight.png: 8-bit image with 3 channel(s); 16-bit with one channel is wanted"),
        ({"frames": "mixed"}, "mixed/1.png: 64x48 pixels, 0.png has 848x480"),
        ({"frames": "spoilt"}, "spoilt/9.png: not a readable image"),
        ({"intrinsics": "421,421,424"}, "--intrinsics = '421,421,424': four numbers FX,FY,CX,CY"),
        ({"intrinsics": "421,421,x,240"}, "--intrinsics = '421,421,x,240': four numbers"),
        ({"intrinsics": "421,421,1424,240"}, "the centre (1424, 240) lies outside the 848x480 image"),
        ({"frames": "notes.txt"}, "notes.txt': no such file, folder or camera"),
        ({"frames": "text.png"}, "text.png: not a readable image"),
        pytest.param({"frames": "text.db3"}, "text.db3", marks=needs_sdk),
        ({"frames": "text.mcap"}, "text.mcap"),
        ({"intrinsics": None}, "--intrinsics: missing"),
        ({"extra": ["--video", "look.avi"]}, "--video = 'look.avi': a name that ends in .mp4 is wanted"),
        ({"extra": ["--video", "nowhere/look.mp4"]}, "--video = 'nowhere/look.mp4': a file in a folder that exists is wanted"),
        ({"extra": ["--serve", "70000"]}, "--serve = 70000: between 0 and 65535 is wanted"),
        ({"extra": ["--serve", "0", "--host", "192.0.2.1"]}, "--serve = 0: cannot listen on 192.0.2.1"),
        ({"extra": ["--frames", "0"]}, "--frames = 0: at least 1 is wanted"),
        ({"extra": ["--every", "0"]}, "--every = 0: at least 1 is wanted"),
        ({"extra": ["--exclude", "1,2"]}, "--exclude = '1,2': NORTH,EAST,RADIUS"),
        ({"extra": ["--size", "8x8"]}, "--size = '8x8': WIDTHxHEIGHT"),
        ({"extra": ["--pitch-deg", "nan"]}, "--pitch-deg = nan: between -60 and 60 is wanted"),
        ({"extra": ["--profile", "nowhere.toml"]}, "--profile = 'nowhere.toml': cannot be read"),
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
    for name in ("notes.txt", "text.png", "text.db3", "text.mcap"):
        (tmp_path / name).write_text("no recording, only text\n" * 20)
    source = tmp_path / change["frames"] if "frames" in change else frames
    out = tmp_path / change.get("out", "out")
    intrinsics = change.get("intrinsics", D435)
    before = sorted(tmp_path.rglob("*"))
    arguments = [str(source), *(["--intrinsics", intrinsics] if intrinsics else []), *change.get("extra", [])]
    status = main([*arguments, *(["--out", str(out)] if "extra" not in change else [])])
    captured = capsys.readouterr()
    assert status == 2
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert sorted(tmp_path.rglob("*")) == before
