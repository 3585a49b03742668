"""Ctrl-C during a mission on the virtual clock: it ends at once and in order, with nothing left that goes on."""

from __future__ import annotations

import gc
import threading
from pathlib import Path

import pytest

from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[3]
UNTIL_S = 2.0


class Person:
    """Presses Ctrl-C after two seconds."""

    def __init__(self) -> None:
        self.from_s: float | None = None

    def __call__(self, fleet: VirtualFleet) -> None:
        now_s = next(iter(fleet.vehicles.values())).rooms.clock.now_s()
        self.from_s = now_s if self.from_s is None else self.from_s
        if now_s - self.from_s > UNTIL_S:
            raise KeyboardInterrupt


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_ends_everything_without_a_word(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    before = set(threading.enumerate())
    with pytest.raises(KeyboardInterrupt):
        fly_virtual(ROOT / "missions/demo_two_pursuers.toml", ROOT / "profiles/sim.toml", tmp_path, watch=Person())
    gc.collect()
    for thread in set(threading.enumerate()) - before:
        thread.join(60.0)
        assert not thread.is_alive(), thread.name
    assert "Task was destroyed" not in caplog.text
