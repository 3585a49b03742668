"""When a silent camera is started again: soon, then ever more rarely, and never while frames come."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from perception.sources.inbox import Arrival, Inbox
from perception.sources.stall_watch import BACK_OFF_S, START_TIMEOUT_S, StallWatch

STEP_S = 0.1


class Camera:
    """Counts restarts; `answers` says which of them succeed (the last one repeats)."""

    def __init__(self, *answers: bool) -> None:
        self.answers = answers
        self.times_s: list[float] = []
        self.now_s = 0.0

    def restart(self) -> None:
        answer = self.answers[min(len(self.times_s), len(self.answers) - 1)]
        self.times_s.append(self.now_s)
        if not answer:
            raise RuntimeError("no such device")

    def watch(self) -> StallWatch:
        return StallWatch("the camera", self.restart, stall_timeout_s=1.0, started_s=0.0)

    def run(self, watch: StallWatch, until_s: float, arrived: int) -> None:
        while self.now_s < until_s:
            self.now_s += STEP_S
            watch.step(self.now_s, arrived)


def test_a_stream_that_falls_silent_is_started_again_after_the_timeout() -> None:
    camera = Camera(True)
    watch = camera.watch()
    camera.run(watch, 2.0, arrived=1)
    assert camera.times_s == [pytest.approx(1.2)]
    assert watch.restarts == 1
    assert watch.fault(1) == "the camera: no frame for 1.1 s; being started again"
    assert watch.fault(2) == "", "a frame has come since"


def test_the_first_frame_after_a_start_may_take_longer() -> None:
    camera = Camera(True)
    watch = camera.watch()
    camera.run(watch, START_TIMEOUT_S - 2 * STEP_S, arrived=0)
    assert camera.times_s == []
    camera.run(watch, START_TIMEOUT_S + 0.3, arrived=0)
    assert len(camera.times_s) == 1


def test_attempts_that_fail_are_repeated_ever_more_rarely() -> None:
    camera = Camera(False)
    watch = camera.watch()
    camera.run(watch, 30.0, arrived=1)
    pauses_s = [later - earlier for earlier, later in zip(camera.times_s, camera.times_s[1:], strict=False)]
    assert pauses_s[:4] == pytest.approx(list(BACK_OFF_S), abs=STEP_S + 1e-6)
    assert max(pauses_s) <= BACK_OFF_S[-1] + STEP_S + 1e-6
    assert watch.restarts == 0
    assert "cannot be started again: no such device" in watch.fault(1)


def test_after_frames_the_next_stall_is_answered_at_once_again() -> None:
    camera = Camera(False, False, False, True)
    watch = camera.watch()
    camera.run(watch, 8.0, arrived=1)
    assert watch.restarts == 1
    camera.run(watch, 8.2, arrived=2)
    attempts = len(camera.times_s)
    camera.run(watch, 9.5, arrived=2)
    assert len(camera.times_s) == attempts + 1


@given(st.lists(st.tuples(st.floats(0.01, 2.0), st.booleans(), st.booleans()), max_size=80))
def test_no_restart_while_frames_come_and_no_fault_after_one(steps: list[tuple[float, bool, bool]]) -> None:
    camera = Camera(True)
    watch = camera.watch()
    arrived, silence_s = 0, 0.0
    for passed_s, has_frame, answers in steps:
        camera.answers = (answers,)
        camera.now_s += passed_s
        arrived += has_frame
        before = len(camera.times_s)
        silence_s = 0.0 if has_frame else silence_s + passed_s
        watch.step(camera.now_s, arrived)
        if silence_s < 1.0:
            assert len(camera.times_s) == before
        if has_frame:
            assert watch.fault(arrived) == ""


@given(st.lists(st.one_of(st.integers(0, 50), st.none()), max_size=60))
def test_every_frame_is_returned_or_skipped_and_every_gap_is_counted(numbers: list[int | None]) -> None:
    """None stands for the reader's turn."""
    inbox = Inbox(is_lossless=False)
    returned, lost, last, waiting = 0, 0, None, None
    for number in numbers:
        if number is None:
            arrival = inbox.take()
            assert (arrival and arrival.number) == waiting
            returned += arrival is not None
            waiting = None
            continue
        inbox.put(Arrival(None, number, 0.0))
        lost += max(0, number - last - 1) if last is not None else 0
        last = waiting = number
    arrived = sum(number is not None for number in numbers)
    assert returned + inbox.skipped + (waiting is not None) == arrived == inbox.arrived
    assert inbox.lost == lost
