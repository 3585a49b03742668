"""Frames, poses and time in the perception thread; step by step on a clock moved by hand, and as a real thread."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.core.clock import Clock, ManualClock, SystemClock
from flightapp.core.types import VehicleState
from flightapp.runtime import perception_thread
from flightapp.runtime.conditions import Conditions
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.vehicle.pose_history import PoseHistory
from perception.geometry import CameraMounting, camera_pose
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.sources.api import SourceHealth
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.synthetic.scene import Scene
from perception.types import DepthFrame, Intrinsics, VehiclePose

CAMERA = Intrinsics(424, 240, 210.8, 210.8, 212.0, 120.0)
POLE = np.array([[6.0, 0.5, 0.3, 9.0]])
DEADLINE_S = 20.0


class Frames:
    """A depth source that a test feeds; `error` is raised instead, as long as it is set."""

    def __init__(self) -> None:
        self.health = SourceHealth()
        self.is_finished = False
        self.is_closed = False
        self.error: Exception | None = None
        self.ready: DepthFrame | None = None

    def latest(self) -> DepthFrame | None:
        if self.error is not None:
            raise self.error
        frame, self.ready = self.ready, None
        return frame

    def close(self) -> None:
        self.is_closed = True


class Bench:
    """One perception thread with everything around it; the thread is not started."""

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = ManualClock(10.0)
        self.frames = Frames()
        self.history = PoseHistory()
        self.results = 0
        self.renderer = DepthRenderer(Scene(cylinders=POLE), CAMERA, noise=False)
        pipeline = PerceptionPipeline(PerceptionParameters(stride_px=1, memory_s=0.5), CameraMounting())
        self.thread = PerceptionThread(self.frames, pipeline, self.history, clock or self.clock, self._count)

    def _count(self) -> None:
        self.results += 1

    def tell_pose(self, t_s: float, yaw_rad: float = 0.0) -> None:
        self.history.append_state(VehicleState(t_s, np.array([0.0, 0.0, -5.0]), np.zeros(3), 0.0))
        self.history.append_attitude(t_s, 0.0, 0.0, wrap_pi(yaw_rad))

    def shoot(self, t_s: float, number: int = 1, yaw_rad: float = 0.0) -> DepthFrame:
        pose = camera_pose(VehiclePose((0.0, 0.0, -5.0), (0.0, 0.0, 0.0), 0.0, 0.0, yaw_rad), CameraMounting())
        return DepthFrame(t_s, number, self.renderer.render(pose, number), DEPTH_UNIT_M, CAMERA)

    def step_at(self, t_s: float) -> bool:
        self.clock.t_s = t_s
        return self.thread.step()

    def texts(self) -> list[str]:
        return [notice.text for notice in self.thread.take_notices()]


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_a_frame_is_processed_with_the_pose_it_belongs_to_however_late_it_comes() -> None:
    bench = Bench()
    for k in range(60):
        bench.tell_pose(10.0 + 0.02 * k, yaw_rad=0.02 * k)
    bench.frames.ready = bench.shoot(10.21, 7, yaw_rad=0.21)
    assert bench.step_at(11.2)
    newest = bench.thread.newest
    assert newest is not None
    assert (newest.frame_s, newest.frame_number, bench.results) == (10.21, 7, 1)
    assert newest.latency_s == pytest.approx(0.99)
    assert newest.processing_s == 0.0
    np.testing.assert_allclose(newest.obstacles.discs[0, :2], POLE[0, :2], atol=0.2)
    assert len(newest.age_s) == len(newest.confidence) == len(newest.obstacles.discs)


def test_a_frame_ahead_of_the_telemetry_waits_for_it_and_no_longer_than_a_period() -> None:
    bench = Bench()
    bench.tell_pose(9.98)
    bench.tell_pose(10.0)
    bench.frames.ready = bench.shoot(10.015)
    assert not bench.step_at(10.018)
    assert not bench.step_at(10.024)
    bench.tell_pose(10.02)
    assert bench.step_at(10.025), "its pose has come"
    bench.frames.ready = bench.shoot(10.055, 2)
    assert not bench.step_at(10.06)
    assert bench.step_at(10.081), "the telemetry is late: carried forward"
    bench.frames.ready = bench.shoot(10.025, 3)
    assert bench.step_at(10.03), "less than half a period ahead: carried forward at once"
    assert bench.thread.health.processed == 3


def test_the_newest_of_the_waiting_frames_wins_and_frames_faster_than_telemetry_do_not_starve() -> None:
    bench = Bench()
    bench.tell_pose(9.98)
    bench.tell_pose(10.0)
    used: list[int] = []
    for k in range(30):  # a frame each 4 ms, and never a pose again
        t_s = 10.012 + 0.004 * k
        bench.frames.ready = bench.shoot(t_s, k)
        if bench.step_at(t_s) and bench.thread.newest is not None:
            used.append(bench.thread.newest.frame_number)
    assert np.diff([0, *used]).max() <= 7, "a frame is taken, waits one telemetry period, and is used"
    still_waiting = used[-1] < 29
    assert bench.thread.health.replaced + len(used) + still_waiting == 30


def test_frames_without_a_pose_are_counted_and_told_once() -> None:
    bench = Bench()
    bench.frames.ready = bench.shoot(10.0)
    bench.step_at(10.0)
    assert bench.step_at(10.03)
    assert "has not told" in bench.texts()[0]
    for k in range(100):
        bench.tell_pose(12.0 + 0.02 * k)
    for k in range(20):
        bench.frames.ready = bench.shoot(11.0 + 0.03 * k, k)
        assert bench.step_at(13.5 + 0.03 * k)
    texts = bench.texts()
    assert len([text for text in texts if text.startswith("depth frame is not used: captured 2.50 s ago")]) == 1
    assert len(texts) == 2, "the other one: the first condition is over"
    bench.frames.ready = bench.shoot(math.nan)
    assert bench.step_at(14.2)
    assert bench.thread.health.without_pose == 22
    assert bench.thread.newest is None
    bench.frames.ready = bench.shoot(13.95)
    assert bench.step_at(15.3)
    assert bench.thread.health.processed == 1
    assert sum("over after" in text for text in bench.texts()) == 2


def test_what_is_wrong_with_camera_and_frames_is_told_when_it_begins_and_when_it_is_over() -> None:
    bench = Bench()
    bench.renderer = DepthRenderer(Scene(cylinders=POLE), CAMERA)
    for k in range(200):
        t_s = 10.0 + 0.02 * k
        bench.tell_pose(t_s)
        frame = bench.shoot(t_s, k)
        if 50 <= k < 100:
            frame.depth[:] = 0
            bench.frames.health = SourceHealth(restarts=1, fault=f"no frame for {0.02 * k:.1f} s")
        else:
            bench.frames.health = SourceHealth(restarts=1)
        bench.frames.ready = frame
        assert bench.step_at(t_s)
    texts = bench.texts()
    assert [text[:10] for text in texts].count("over after") == 2
    assert len(texts) == 4
    assert "no frame for 1.0 s" in texts
    assert any(text.startswith("depth frame is empty") for text in texts)


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=300))
def test_every_condition_begins_before_it_ends_and_none_floods(active: list[tuple[bool, bool]]) -> None:
    conditions, told = Conditions(), []
    for k, (first, second) in enumerate(active):
        sentences = [f"first {k}"] * first + [f"second {k}"] * second
        told += conditions.update(k / 30.0, sentences)
    told += conditions.update(1000.0, [])
    for name in ("first", "second"):
        levels = [notice.level for notice in told if name in notice.text]
        assert levels == ["warning", "info"] * (len(levels) // 2)
        assert len(levels) <= 2 + 2 * len(active) / 30.0


def test_a_camera_that_raises_is_tried_again_and_fails_only_if_nothing_else_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(perception_thread, "RETRY_MAX_S", 0.05)
    monkeypatch.setattr(perception_thread, "FAILURE_AFTER_S", 0.3)
    clock = SystemClock()
    bench = Bench(clock)
    thread = bench.thread
    bench.frames.error = OSError("USB device is gone")
    thread.start()
    try:
        wait_for(lambda: thread.failure is not None)
        assert thread.failure is not None
        assert "USB device is gone" in thread.failure
        assert len([text for text in bench.texts() if "USB device is gone" in text]) == 1
        assert thread.is_alive()
        bench.frames.error = None
        now_s = clock.now_s()
        bench.tell_pose(now_s - 0.02)
        bench.tell_pose(now_s)
        bench.frames.ready = bench.shoot(now_s)
        wait_for(lambda: bench.results == 1)
        assert thread.failure is None
    finally:
        thread.stop()
    assert not thread.is_alive()
    assert bench.frames.is_closed


@settings(max_examples=12, deadline=None)
@given(
    yaw_rate=st.sampled_from([-3.0, -2.0, 2.0, 3.0]),
    frame_delay_s=st.floats(0.002, 0.1),
    telemetry_delay_s=st.floats(0.0, 0.04),
    jitter=st.lists(st.floats(0.0, 0.015), min_size=60, max_size=60),
    phase_s=st.floats(0.0, 0.02),
)
def test_a_pole_stays_where_it_is_while_the_vehicle_turns(
    yaw_rate: float, frame_delay_s: float, telemetry_delay_s: float, jitter: list[float], phase_s: float
) -> None:
    """Swinging through the pole's bearing: attitudes at 50 Hz come late by a delay that varies, frames at 30 Hz by another."""
    bench = Bench()
    start_s, duration_s = 10.0, 0.5
    aim_rad = math.atan2(POLE[0, 1], POLE[0, 0])

    def yaw(t_s: float) -> float:
        return aim_rad + yaw_rate * (t_s - start_s - 0.5 * duration_s)

    told_s = [start_s - 0.3 + 0.02 * k for k in range(60)]
    shot_s = [start_s + phase_s + k / 30.0 for k in range(round(30 * duration_s))]
    arrivals = [(t_s + telemetry_delay_s + jitter[k], "pose", t_s) for k, t_s in enumerate(told_s)]
    arrivals += [(t_s + frame_delay_s, "frame", t_s) for t_s in shot_s if abs(wrap_pi(yaw(t_s) - aim_rad)) < 0.45]
    arrivals += [(start_s + 0.002 * k, "nothing", 0.0) for k in range(400)]
    for at_s, what, t_s in sorted(arrivals):
        if what == "pose":
            bench.tell_pose(t_s, yaw(t_s))
        elif what == "frame":
            bench.frames.ready = bench.shoot(t_s, round(30 * t_s), yaw(t_s))
        bench.step_at(at_s)
        newest = bench.thread.newest
        if newest is not None:
            assert len(newest.obstacles.discs) == 1, "one pole, seen once"
            np.testing.assert_allclose(newest.obstacles.discs[0, :2], POLE[0, :2], atol=0.2)
    assert bench.thread.health.processed >= 3
    assert bench.thread.health.without_pose == 0
