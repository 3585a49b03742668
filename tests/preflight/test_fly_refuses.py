"""What `flightapp fly` makes of the checklist: it waits, refuses or goes on with a waiver, and leaves that in the recording."""

from __future__ import annotations

import asyncio
from collections.abc import Collection
from types import SimpleNamespace
from typing import Any

import pytest

from flightapp.core.errors import FlightError, InputError
from flightapp.preflight.facts import Facts
from flightapp.runtime import ground_checks
from flightapp.vehicle.autopilot import BatteryState, HealthState
from tests.preflight.good_facts import good_facts

LOW_BATTERY = good_facts(battery=BatteryState(14.2, 0.3))
CONVERGING = good_facts(health=HealthState(False, True, True, True))


class OnTheGround:
    """The rooms as far as the checklist needs them; facts come one after the other, the last one stays."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *facts: Facts) -> None:
        self._facts = list(facts)
        self.now_s = 1000.0
        self.looks = 0
        self.events: list[dict[str, Any]] = []
        monkeypatch.setattr(ground_checks, "Gatherer", lambda _rooms, _loop: self)

    async def read_parameters(self) -> None: ...

    async def plan_ways(self) -> None: ...

    def facts(self) -> Facts:
        self.looks += 1
        return self._facts.pop(0) if len(self._facts) > 1 else self._facts[0]

    async def tick(self, period_s: float) -> None:
        self.now_s += period_s

    def event(self, level: str, name: str, text: str, **data: object) -> None:
        self.events.append({"level": level, "name": name, "text": text, **data})

    def pass_checklist(self, waived: Collection[str] = ()) -> None:
        rooms: Any = SimpleNamespace(clock=SimpleNamespace(now_s=lambda: self.now_s), journal=self)
        stub: Any = self
        asyncio.run(ground_checks.pass_checklist(rooms, stub, stub, waived))

    def recorded(self, result: str) -> list[str]:
        return [event["check"] for event in self.events if event.get("result") == result]


def test_a_failed_check_is_refused_by_name_with_what_to_do_and_stands_in_the_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    ground = OnTheGround(monkeypatch, LOW_BATTERY)
    with pytest.raises(FlightError, match=r"preflight: battery: 30%.* -> change it"):
        ground.pass_checklist()
    assert ground.recorded("failed") == ["battery"]
    assert ground.now_s == 1000.0, "what fails is not waited for"


def test_the_same_check_waived_by_name_lets_fly_and_the_waiver_stands_in_the_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    ground = OnTheGround(monkeypatch, LOW_BATTERY)
    ground.pass_checklist(["battery"])
    assert ground.recorded("waived") == ["battery"]
    (event,) = [event for event in ground.events if event.get("check") == "battery"]
    assert event["level"] == "warning"
    assert "30%" in event["text"]


def test_a_waiver_for_one_check_covers_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    ground = OnTheGround(monkeypatch, LOW_BATTERY)
    with pytest.raises(FlightError, match="battery"):
        ground.pass_checklist(["clock"])
    with pytest.raises(InputError, match="--waive = 'batery'"):
        ground.pass_checklist(["batery"])


def test_what_converges_is_waited_for_and_not_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    ground = OnTheGround(monkeypatch, CONVERGING, CONVERGING, CONVERGING, good_facts())
    ground.pass_checklist()
    assert ground.looks == 4
    ground = OnTheGround(monkeypatch, CONVERGING)
    with pytest.raises(FlightError, match=r"not ready within 60 s: health: not yet: global position"):
        ground.pass_checklist(["health"])
    assert ground.now_s >= 1060.0
