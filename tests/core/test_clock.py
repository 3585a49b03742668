from __future__ import annotations

import itertools
import time

import pytest

from flightapp.core.clock import ManualClock, SystemClock, monotonic_ns


def test_fleet_time_is_unix_time_that_never_steps_back(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SystemClock()
    assert clock.now_s() == pytest.approx(time.time(), abs=0.05)
    monkeypatch.setattr(time, "time_ns", lambda: 0)
    monkeypatch.setattr(time, "time", lambda: 0.0)
    stamps = [clock.now_ns() for _ in range(2000)]
    assert all(later >= earlier for earlier, later in itertools.pairwise(stamps))
    assert stamps[0] > 1.6e18


def test_monotonic_stamps_of_any_process_become_fleet_time() -> None:
    clock = SystemClock()
    assert clock.from_monotonic_ns(monotonic_ns()) == pytest.approx(clock.now_s(), abs=0.01)
    assert clock.now_ns() * 1e-9 == pytest.approx(clock.now_s(), abs=0.01)


def test_a_manual_clock_moves_only_by_hand() -> None:
    clock = ManualClock(5.0)
    clock.advance(0.25)
    assert clock.now_s() == 5.25
    assert clock.now_s() == 5.25
