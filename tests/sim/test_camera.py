"""The camera process as the rest of a simulation meets it: files in, frames out, signals obeyed."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
import tomli_w

from flightapp.core.clock import SystemClock, monotonic_ns
from flightapp.core.errors import InputError
from flightapp.sim.camera import Fault, main, parse_fault
from flightapp.sim.truth import Truth, TruthWriter
from perception.sources import SharedMemorySource
from perception.types import DepthFrame

ROOT = Path(__file__).parents[2]
Result = TypeVar("Result")


def eventually(probe: Callable[[], Result | None], seconds: float = 20.0) -> Result:
    """The first result of `probe` that is not None; fails after a deadline."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = probe()
        if found is not None:
            return found
        time.sleep(0.002)
    raise AssertionError("it did not happen in time")


def truth(north: float = 0.0) -> Truth:
    return Truth(monotonic_ns(), (north, 0.0, -3.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0, True, False)


class Rig:
    """Files of one camera; `next_frame` moves the vehicle and waits for a frame taken after that."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        mission = tomllib.loads((ROOT / "missions" / "demo_two_pursuers.toml").read_text())
        mission["obstacles"] = {"boxes": [{"north_m": 6.0, "east_m": 0.0, "length_m": 1.0, "width_m": 10.0, "height_m": 9.0}]}
        (folder / "mission.toml").write_text(tomli_w.dumps(mission))
        self.writer = TruthWriter(folder / "truth")
        self.clock = SystemClock()
        self.source = SharedMemorySource(folder / "frames", self.clock.from_monotonic_ns)
        self.stamps: dict[float, int] = {}
        self.process: subprocess.Popen[str] | None = None

    def arguments(self, **changes: str | Path) -> list[str]:
        options: dict[str, str | Path] = {
            "mission": self.folder / "mission.toml",
            "profile": ROOT / "profiles" / "sim.toml",
            "vehicle": "p1",
            "truth": self.folder / "truth",
            "output": self.folder / "frames",
            "seed": "4",
        } | {key.replace("_", "-"): value for key, value in changes.items()}
        words = [str(part) for key, value in options.items() for part in (f"--{key}", value)]
        return [sys.executable, "-m", "flightapp.sim.camera", *words]

    def start(self, **changes: str | Path) -> subprocess.Popen[str]:
        self.process = subprocess.Popen(self.arguments(**changes), stderr=subprocess.PIPE, text=True, cwd=ROOT)
        return self.process

    def next_frame(self, north: float = 0.0) -> DepthFrame:
        moved_s = self.clock.now_s()

        def probe() -> DepthFrame | None:
            assert self.process is None or self.process.poll() is None, "the camera process has ended"
            state = truth(north)
            self.writer.write(state)
            self.stamps[self.clock.from_monotonic_ns(state.monotonic_ns)] = state.monotonic_ns
            frame = self.source.latest()
            return frame if frame is not None and frame.t_s > moved_s else None

        return eventually(probe)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    if rig.process is not None:
        rig.process.kill()
        rig.process.communicate()


@pytest.fixture
def kept_signals() -> Iterator[None]:
    """Signal handlers as before, after a test that runs the process's main function in this process."""
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_frames_show_what_the_vehicle_sees_and_when(rig: Rig) -> None:
    process = rig.start()
    frame = rig.next_frame()
    assert frame.depth.shape == (480, 848)
    assert np.median(frame.depth[200:280, 380:460]) * frame.depth_unit_m == pytest.approx(5.4, abs=0.1)
    assert frame.t_s in rig.stamps, "capture time is the true state's time"
    closer = rig.next_frame(north=2.0)
    assert np.median(closer.depth[200:280, 380:460]) * closer.depth_unit_m == pytest.approx(3.4, abs=0.1)
    process.send_signal(signal.SIGTERM)
    assert process.wait(10) == 0


def test_frames_come_at_the_cameras_rate(rig: Rig) -> None:
    rig.start()
    first = rig.next_frame()
    last = first
    while last.number < first.number + 30:
        last = rig.next_frame()
    assert (last.t_s - first.t_s) / (last.number - first.number) == pytest.approx(1 / 30, rel=0.25)


def test_other_vehicles_are_visible(rig: Rig) -> None:
    other = TruthWriter(rig.folder / "other")
    other.write(truth(north=3.0))
    rig.start(other_truth=rig.folder / "other")
    frame = rig.next_frame()
    assert frame.depth[236:244, 420:428].max() * frame.depth_unit_m == pytest.approx(3.0 - 0.1 - 0.35, abs=0.15)


def test_a_stale_vehicle_gives_no_new_frames(rig: Rig) -> None:
    rig.start()
    frame = rig.next_frame()
    deadline = time.monotonic() + 0.3
    later = []
    while time.monotonic() < deadline:
        found = rig.source.latest()
        if found is not None:
            later.append(found.number)
    assert len(later) <= 2
    assert rig.next_frame().number > frame.number


def test_a_zero_fault_blinds_the_camera(rig: Rig) -> None:
    rig.start(fault="zero@0.3")
    assert rig.next_frame().depth.any()
    eventually(lambda: None if rig.next_frame().depth.any() else True)


def test_a_stuck_fault_repeats_the_image(rig: Rig) -> None:
    rig.start(fault="stuck@0.3")
    previous = rig.next_frame().depth.copy()

    def repeats() -> bool | None:
        nonlocal previous
        image = rig.next_frame().depth.copy()
        same = np.array_equal(image, previous)
        previous = image
        return True if same else None

    eventually(repeats)


def test_an_off_fault_ends_the_stream_but_not_the_process(rig: Rig) -> None:
    process = rig.start(fault="off@0.2")
    first = rig.next_frame()
    quiet_since = time.monotonic()

    def silent() -> bool | None:
        nonlocal quiet_since
        rig.writer.write(truth())
        if rig.source.latest() is not None:
            quiet_since = time.monotonic()
        return True if time.monotonic() - quiet_since > 0.5 and rig.clock.now_s() > first.t_s + 0.7 else None

    eventually(silent)
    assert process.poll() is None


def test_the_camera_dies_with_its_parent(rig: Rig, tmp_path: Path) -> None:
    command = [*rig.arguments(), "--die-with-parent"]
    script = textwrap.dedent(f"""
        import subprocess, sys, time
        child = subprocess.Popen({command!r})
        print(child.pid, flush=True)
        time.sleep(60)
    """)
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    rig.next_frame()
    parent.kill()
    parent.communicate()

    def gone() -> bool | None:
        try:
            state = Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        return True if state in "ZX" else None

    eventually(gone, 10)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"vehicle": "p9"}, "--vehicle = 'p9': not in"),
        ({"fault": "melt@3"}, "--fault = 'melt@3': write off@T_S"),
        ({"mission": "nowhere.toml"}, "nowhere.toml: no such file"),
        ({"output": "/nowhere/frames"}, "--output = '/nowhere/frames': cannot be written"),
    ],
)
def test_bad_input_is_one_sentence(
    rig: Rig, changes: dict[str, str], said: str, capsys: pytest.CaptureFixture[str], kept_signals: None
) -> None:
    assert main(rig.arguments(**changes)[3:]) == 2
    errors = capsys.readouterr().err
    assert said in errors
    assert errors.count("\n") == 1


def test_faults_are_parsed() -> None:
    assert parse_fault("off@2.5") == Fault("off", 2.5)
    for text in ("off", "off@", "off@-1", "off@nan", "OFF@1", "@3"):
        with pytest.raises(InputError, match="write off@T_S"):
            parse_fault(text)
