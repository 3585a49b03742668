"""One vehicle of a run as analysers see it: its recording, and what several of them ask for."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from flightapp.analysis.metrics import airborne
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.ulog.spans import Span, spans_of
from flightapp.config.mission import Mission
from flightapp.config.profile import Profile
from flightapp.core.types import Array
from flightapp.recording.phases import Window
from flightapp.recording.reader import Series

_Row = tuple[float, float, float, float, bool, list[float]]


@dataclass(frozen=True, slots=True)
class Heard:
    """What a vehicle knew of one other vehicle, a row for each `/team` message that names it."""

    t_s: Array  # (n,) when it was recorded
    age_s: Array  # (n,) since the state was true, by the clocks of both
    lost: Array  # (n,) messages that never came, in all
    taken: Array  # (n,) messages that came, in all; nan in older recordings
    is_done: Array  # (n,) 1 where it had said that its mission is over, else 0
    position_ned_m: Array  # (n, 3) where it was `age_s` ago


class Subject:
    """Everything is on the time base of the run, s."""

    def __init__(self, run: Run, vehicle: VehicleRun) -> None:
        self.run = run
        self.vehicle = vehicle
        self.name = vehicle.name
        self.airborne: Window | None = airborne(vehicle)
        self.pursuit: Window | None = vehicle.phases.window(("pursue",))

    @property
    def profile(self) -> Profile:
        """Of an analyser that needs one."""
        assert self.vehicle.profile is not None
        return self.vehicle.profile

    @property
    def mission(self) -> Mission:
        """Of an analyser that needs one."""
        assert self.run.mission is not None
        return self.run.mission

    @property
    def is_pursuer(self) -> bool:
        """Also where no role is known."""
        return self.vehicle.role != "evader"

    @property
    def has_camera(self) -> bool:
        """By mission and profile; where neither tells, by what was recorded."""
        named = [] if self.run.mission is None else [one for one in self.run.mission.vehicles if one.name == self.name]
        if any(not one.camera for one in named):
            return False
        if self.vehicle.profile is not None:
            return self.vehicle.profile.camera.source != "none"
        return len(self.topic("/obstacles")) > 0

    def topic(self, name: str) -> Series:
        return self.vehicle.recording.topic(name)

    def during(self, name: str, window: Window | Span) -> Series:
        """The messages of one topic from the start of `window` to its end."""
        series, (from_s, to_s) = self.topic(name), window
        return series.chosen((series.t_s >= from_s) & (series.t_s <= to_s))

    @functools.cached_property
    def offboard(self) -> list[Span]:
        """When the autopilot reported OFFBOARD in the air; a change is recorded when it is seen."""
        if self.airborne is None:
            return []
        series = self.topic("/autopilot")
        holds = np.array([mode == "OFFBOARD" for mode in series.texts("flight_mode")], dtype=bool)
        return spans_of(series.t_s, holds, self.vehicle.phases.end_s)

    @functools.cached_property
    def heard(self) -> dict[str, Heard]:
        """By the name of the other vehicle."""
        rows: dict[str, list[_Row]] = {}
        series = self.topic("/team")
        for t_s, members in zip(series.t_s.tolist(), series.messages.values("members"), strict=True):
            for member in members or ():
                taken = member.get("taken")
                row = (
                    t_s,
                    member["age_s"],
                    member["lost"],
                    math.nan if taken is None else taken,
                    member["phase"] == "done",
                    member["position_ned_m"],
                )
                rows.setdefault(str(member["name"]), []).append(row)
        return {name: _heard(told) for name, told in rows.items()}


def _heard(rows: list[_Row]) -> Heard:
    t_s, age_s, lost, taken, is_done, positions = zip(*rows, strict=True)
    return Heard(
        np.array(t_s),
        np.array(age_s),
        np.array(lost),
        np.array(taken, dtype=np.float64),
        np.array(is_done, dtype=np.float64),
        np.array(positions).reshape(-1, 3),
    )
