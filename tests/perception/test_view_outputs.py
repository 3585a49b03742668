"""What the view leaves behind: pictures, a video that can be read back, a web page; also when somebody presses Ctrl-C."""

from __future__ import annotations

import http.client
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.cli import main
from perception.errors import PerceptionInputError
from perception.view.picture_folder import PictureFolder
from perception.view.serve import VIEWERS_MAX, LiveView
from perception.view.video import VideoFile
from tests.perception.scenes import MakeStage, pose

D435 = "421.6,421.6,424,240"
DEADLINE_S = 100.0


@pytest.fixture
def walk(scene: MakeStage, tmp_path: Path) -> Path:
    """Six images of a camera that comes 0.3 m nearer to a pole each time."""
    folder = tmp_path / "walk"
    folder.mkdir()
    world = scene(cylinders=[(5.0, 0.5, 0.3, 9.0)])
    for number in range(6):
        cv2.imwrite(str(folder / f"{number}.png"), world.shoot(pose(north=0.3 * number)).depth)
    return folder


def grey(level: int, width: int = 64) -> np.ndarray:
    return np.full((48, width, 3), level, np.uint8)


def read_video(path: Path) -> tuple[list[np.ndarray], float]:
    reader = cv2.VideoCapture(str(path))
    pictures = []
    while (read := reader.read())[0]:
        pictures.append(read[1])
    rate_hz = reader.get(cv2.CAP_PROP_FPS)
    reader.release()
    return pictures, rate_hz


def wait_for(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"{what} did not happen in {DEADLINE_S} s"
        time.sleep(0.01)


class TestVideo:
    def test_shows_every_picture_in_turn(self, walk: Path, tmp_path: Path) -> None:
        out, video = tmp_path / "out", tmp_path / "walk.mp4"
        assert main([str(walk), "--intrinsics", D435, "--memory", "--out", str(out), "--video", str(video)]) == 0
        shown, rate_hz = read_video(video)
        drawn = [cv2.imread(str(out / f"{number}-discs.png")) for number in range(6)]
        assert rate_hz == 30
        assert len(shown) == 6
        for number, picture in enumerate(shown):
            off = [float(np.abs(picture.astype(float) - other).mean()) for other in drawn]
            assert int(np.argmin(off)) == number
            assert off[number] < 6

    def test_separate_images_stand_for_a_second_each(self, walk: Path, tmp_path: Path) -> None:
        video = tmp_path / "walk.mp4"
        arguments = ["--intrinsics", D435, "--frames", "2", "--video", str(video), "--video-rate-hz", "10"]
        assert main([str(walk), *arguments]) == 0
        shown, rate_hz = read_video(video)
        assert (len(shown), rate_hz) == (20, 10)
        assert float(np.abs(shown[2].astype(float) - shown[8]).mean()) < 1

    def test_keeps_time_where_frames_are_missing_or_come_too_fast(self, tmp_path: Path) -> None:
        video = VideoFile(tmp_path / "v.mp4", rate_hz=10)
        for t_s, level in ((0.0, 20), (0.1, 60), (0.5, 100), (0.52, 140), (0.6, 180), (3600.0, 220)):
            video.add(t_s, grey(level))
        video.close()
        levels = [round(float(picture.mean()) / 20) * 20 for picture in read_video(tmp_path / "v.mp4")[0]]
        assert levels[:7] == [20, 60, 60, 60, 60, 140, 180]
        assert levels[-1] == 220
        # The hour without a frame is shown as five seconds.
        assert levels[6:] == [180] * 50 + [220]

    def test_goes_on_when_the_picture_changes_its_size(self, tmp_path: Path) -> None:
        video = VideoFile(tmp_path / "v.mp4", rate_hz=10)
        for number, width in enumerate((64, 128, 32, 64)):
            video.add(number / 10, grey(100, width))
        video.close()
        assert [picture.shape for picture in read_video(tmp_path / "v.mp4")[0]] == [(48, 64, 3)] * 4

    def test_appears_only_when_it_is_complete(self, tmp_path: Path) -> None:
        video = VideoFile(tmp_path / "v.mp4", rate_hz=10)
        video.add(0.0, grey(0))
        video.add(0.1, grey(1))
        assert not (tmp_path / "v.mp4").exists()
        video.close()
        assert [file.name for file in tmp_path.iterdir()] == ["v.mp4"]

    def test_without_a_picture_there_is_none(self, tmp_path: Path) -> None:
        VideoFile(tmp_path / "v.mp4", rate_hz=10).close()
        assert list(tmp_path.iterdir()) == []

    def test_a_folder_in_its_place_is_named(self, tmp_path: Path) -> None:
        (tmp_path / "v.mp4").mkdir()
        with pytest.raises(PerceptionInputError, match=r"v\.mp4'"):
            VideoFile(tmp_path / "v.mp4", rate_hz=10)


class TestPictureFolder:
    def test_a_picture_that_cannot_be_written_is_named_and_leaves_nothing(self, tmp_path: Path) -> None:
        folder = PictureFolder(tmp_path / "out")
        (tmp_path / "out" / "a-discs.png").mkdir()
        with pytest.raises(PerceptionInputError, match=r"a-discs\.png: cannot be written"):
            folder.add("a", grey(1))
        assert [file.name for file in (tmp_path / "out").iterdir()] == ["a-discs.png"]

    def test_a_folder_that_cannot_be_written_to_is_named(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("os.access", lambda path, mode: False)
        with pytest.raises(PerceptionInputError, match="cannot be written to; a folder that you may write to is wanted"):
            PictureFolder(tmp_path)


@pytest.fixture
def live() -> Iterator[LiveView]:
    view = LiveView("127.0.0.1", 0)
    yield view
    view.close()


def asked(view: LiveView, path: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection(view.address.removeprefix("http://").rstrip("/"), timeout=DEADLINE_S)
    connection.request("GET", path)
    return connection.getresponse()


def next_picture(stream: http.client.HTTPResponse) -> np.ndarray | None:
    """The next picture of a multipart stream, None at its end."""
    boundary = stream.readline().strip()
    if boundary != b"--frame":
        return None
    assert stream.readline().strip() == b"Content-Type: image/jpeg"
    name, _, length = stream.readline().partition(b":")
    assert name == b"Content-Length"
    stream.readline()
    picture = cv2.imdecode(np.frombuffer(stream.read(int(length)), np.uint8), cv2.IMREAD_COLOR)
    stream.readline()
    return np.asarray(picture)


class TestLiveView:
    def test_the_page_shows_the_stream(self, live: LiveView) -> None:
        page = asked(live, "/")
        assert page.status == 200
        assert b'src="/stream.mjpg"' in page.read()
        assert asked(live, "/elsewhere").status == 404

    def test_a_viewer_gets_the_newest_picture_and_then_each_new_one(self, live: LiveView) -> None:
        live.show(grey(10), "{}")
        live.show(grey(40), "{}")
        stream = asked(live, "/stream.mjpg")
        assert stream.headers["Content-Type"] == "multipart/x-mixed-replace; boundary=frame"
        assert next_picture(stream) == pytest.approx(grey(40), abs=2)
        live.show(grey(80), "{}")
        assert next_picture(stream) == pytest.approx(grey(80), abs=2)

    def test_a_viewer_that_does_not_read_holds_up_nobody(self, live: LiveView) -> None:
        random = np.random.default_rng(1)
        live.show(grey(0), "{}")
        asleep = asked(live, "/stream.mjpg")
        for _ in range(100):
            live.show(random.integers(0, 255, (480, 640, 3), np.uint8), "{}")
        live.show(grey(200), '{"number": 101}')
        awake = asked(live, "/newest.jpg").read()
        assert cv2.imdecode(np.frombuffer(awake, np.uint8), cv2.IMREAD_COLOR) == pytest.approx(grey(200), abs=2)
        assert json.loads(asked(live, "/newest.json").read()) == {"number": 101}
        asleep.close()

    def test_no_more_viewers_than_it_can_bear(self, live: LiveView) -> None:
        live.show(grey(0), "{}")
        viewers = [asked(live, "/stream.mjpg") for _ in range(VIEWERS_MAX)]
        assert [viewer.status for viewer in viewers] == [200] * VIEWERS_MAX
        assert asked(live, "/stream.mjpg").status == 503
        viewers[0].close()

        def is_free() -> bool:
            live.show(grey(0), "{}")  # the server notices at its next picture that somebody has gone
            return asked(live, "/newest.jpg").status == 200

        wait_for(is_free, "a free place")

    def test_the_stream_ends_with_the_view(self) -> None:
        view = LiveView("127.0.0.1", 0)
        view.show(grey(10), "{}")
        stream = asked(view, "/stream.mjpg")
        assert next_picture(stream) is not None
        closing = threading.Thread(target=view.close)
        closing.start()
        assert next_picture(stream) is None
        closing.join(DEADLINE_S)
        assert not closing.is_alive()
        with pytest.raises(ConnectionRefusedError):
            asked(view, "/")

    def test_a_taken_port_is_named(self, live: LiveView) -> None:
        port = int(live.address.rstrip("/").rpartition(":")[2])
        with pytest.raises(PerceptionInputError, match=rf"--serve = {port}: cannot listen on 127\.0\.0\.1:{port}"):
            LiveView("127.0.0.1", port)


def test_ctrl_c_ends_with_complete_files_and_a_summary(walk: Path, tmp_path: Path) -> None:
    for number in range(6, 200):
        (walk / f"{number}.png").hardlink_to(walk / "0.png")
    out, video = tmp_path / "out", tmp_path / "look.mp4"
    command = [sys.executable, "-m", "perception", walk, "--intrinsics", D435, "--memory", "--real-time", "--rate-hz", "30"]
    view = subprocess.Popen(
        [*command, "--json", "--out", out, "--video", video], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert view.stdout is not None
    rows = [json.loads(view.stdout.readline()) for _ in range(4)]
    view.send_signal(signal.SIGINT)
    rest, said = view.communicate(timeout=DEADLINE_S)
    rows += [json.loads(line) for line in rest.splitlines()]
    assert view.returncode == 0, said
    assert said.splitlines()[0].startswith(f"{len(rows)} frames in ")
    assert "computing p50" in said
    assert 4 <= len(rows) < 200
    assert sorted(str(file) for file in out.iterdir()) == sorted(row["picture"] for row in rows)
    assert all(cv2.imread(row["picture"]) is not None for row in rows)
    assert len(read_video(video)[0]) == len(rows)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["look.mp4", "out", "walk"]


def test_a_browser_sees_what_the_command_serves_until_ctrl_c(walk: Path) -> None:
    command = [sys.executable, "-m", "perception", walk, "--intrinsics", D435, "--memory", "--serve", "0"]
    view = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert view.stderr is not None
    announced = view.stderr.readline()
    assert announced.startswith("watch at http://127.0.0.1:")
    address = announced.split()[2].removeprefix("http://").rstrip("/")
    assert view.stderr.readline() == "end of the recording; the last picture stays until Ctrl-C\n"
    connection = http.client.HTTPConnection(address, timeout=DEADLINE_S)
    connection.request("GET", "/newest.json")
    row = json.loads(connection.getresponse().read())
    assert row["name"] == "5.png"
    assert row["discs"][0]["distance_m"] == pytest.approx(4.7 - 1.5 - 0.1, abs=0.3)
    connection.request("GET", "/stream.mjpg")
    picture = next_picture(connection.getresponse())
    assert picture is not None
    assert picture.shape == (544, 1408, 3)
    view.send_signal(signal.SIGINT)
    _, said = view.communicate(timeout=DEADLINE_S)
    assert view.returncode == 0
    assert said.startswith("6 frames in ")
