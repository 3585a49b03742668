"""The fault script of a mock autopilot: which part fails, how, when; and the engine that plays it.

    [[faults]]
    target = "gps"
    verb = "off"
    when = { mode = "OFFBOARD", height_above_m = 2.0, after_s = 3.0 }
    duration_s = 8.0

Every fault reports when it began, when it was first *felt* (something really was suppressed or altered), and when it
ended; a fault that never began or was never felt is reported at the end, so that a test cannot pass for the wrong reason.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from flightapp.config.loading import Strict, load

Target = Literal["link", "link_up", "link_down", "telemetry", "gps", "battery", "arming", "mode", "motors"]
Verb = Literal["off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent"]
ModeName = Literal["MANUAL", "ALTCTL", "POSCTL", "OFFBOARD", "TAKEOFF", "HOLD", "RTL", "LAND"]
DenialName = Literal["TEMPORARILY_REJECTED", "DENIED", "FAILED"]

_DUTY = {"period_s": 2.0, "duty": 0.5}
_LINK_FIELDS: dict[str, dict[str, Any]] = {
    "off": {},
    "stuck": {},
    "garbage": {"fraction": 1.0},
    "wrong": {"system_id": 200},
    "slow": {"rate_bytes_s": 1000.0},
    "delayed": {"delay_s": 0.5},
    "intermittent": _DUTY,
}
FIELDS: dict[str, dict[str, dict[str, Any]]] = {
    "link": _LINK_FIELDS,
    "link_up": _LINK_FIELDS,
    "link_down": _LINK_FIELDS,
    "telemetry": {
        "off": {},
        "stuck": {},
        "garbage": {"fraction": 0.5},
        "wrong": {"offset_m": 10.0},
        "slow": {"factor": 5.0},
        "delayed": {"delay_s": 0.5},
        "intermittent": _DUTY,
    },
    "gps": {
        "off": {},
        "stuck": {},
        "garbage": {"deviation_m": 2.0},
        "wrong": {"offset_m": 3.0},
        "slow": {"factor": 10.0},
        "delayed": {"delay_s": 1.0},
        "intermittent": {"period_s": 10.0, "duty": 0.7},
    },
    "battery": {
        "off": {},
        "stuck": {},
        "garbage": {},
        "wrong": {"remaining": 0.04},
        "slow": {"factor": 10.0},
        "delayed": {"delay_s": 5.0},
        "intermittent": _DUTY,
    },
    "arming": {
        "off": {"result": "TEMPORARILY_REJECTED"},
        "stuck": {"result": "DENIED"},
        "garbage": {},
        "wrong": {},
        "slow": {"delay_s": 2.0},
        "delayed": {"delay_s": 1.0},
        "intermittent": {**_DUTY, "result": "TEMPORARILY_REJECTED"},
    },
    "mode": {
        "off": {"result": "DENIED"},
        "stuck": {"mode": "POSCTL"},
        "garbage": {},
        "wrong": {"mode": "POSCTL"},
        "slow": {"delay_s": 1.0},
        "delayed": {"delay_s": 1.0},
        "intermittent": {"mode": "POSCTL", "period_s": 4.0, "duty": 0.5},
    },
    "motors": {
        "off": {},
        "stuck": {},
        "garbage": {},
        "wrong": {"acceleration_m_s2": 1.5},
        "slow": {"fraction": 0.4},
        "delayed": {"delay_s": 0.3},
        "intermittent": {"period_s": 1.0, "duty": 0.2},
    },
}
"""The fields that each verb takes on each target, with their defaults.

link*: off no packet passes; stuck the last packet is repeated in place of every new one; garbage a `fraction` of the
packets has flipped bits; wrong packets bear a foreign `system_id`; slow at most `rate_bytes_s`, the rest waits, then is
lost; delayed by `delay_s`; intermittent off for `duty` of each `period_s`. `link` is both directions, `link_up` towards
the autopilot, `link_down` from it.
telemetry (streams only: heartbeats and answers still come): off; stuck values with running time stamps; garbage a
`fraction` of the messages is broken or nonsense; wrong positions `offset_m` to the north; slow rates divided by `factor`;
delayed; intermittent.
gps: off no fix; stuck position; garbage white noise of `deviation_m`; wrong by `offset_m` to the north; slow rate divided
by `factor`; delayed; intermittent fix.
battery: off empty; stuck at the value it had; garbage readings; wrong `remaining` fraction; slow rate; delayed readings;
intermittent messages.
arming: off refused with `result`; stuck neither arms nor disarms; garbage random results; wrong accepted but not armed;
slow acknowledged at once, armed after `delay_s`; delayed acknowledged and armed after `delay_s`; intermittent refusals.
mode: off commands refused with `result`, the mode stays; stuck an RC pilot takes `mode` and keeps it; garbage heartbeats
with nonsense modes; wrong an RC pilot takes `mode` once; slow acknowledged at once, changed after `delay_s`; delayed both;
intermittent an RC pilot takes `mode` and refuses others for `duty` of each `period_s`.
motors: off; stuck thrust; garbage random thrust; wrong a steady push of `acceleration_m_s2` to the north; slow a `fraction`
of the thrust is left; delayed response; intermittent cuts.
"""


class Condition(Strict):
    """All the given conditions hold at once; the fault begins `after_s` later."""

    armed: bool | None = None
    mode: ModeName | None = None
    landed: bool | None = None
    height_above_m: float | None = None
    height_below_m: float | None = None
    speed_above_m_s: float | None = None
    after_s: float = Field(default=0.0, ge=0, le=3600)

    @model_validator(mode="after")
    def _says_something(self) -> Condition:
        if not self.model_fields_set - {"after_s"}:
            raise ValueError(
                "the condition names nothing to wait for; "
                "give armed, mode, landed, height_above_m, height_below_m or speed_above_m_s"
            )
        if self.height_above_m is not None and self.height_below_m is not None and self.height_below_m <= self.height_above_m:
            raise ValueError(
                f"height_below_m = {self.height_below_m} must be greater than height_above_m = {self.height_above_m}: never true"
            )
        return self


class Fault(Strict):
    """One fault: `verb` on `target`, from `at_s` (since the start) or from `when`, for `duration_s` (default: to the end)."""

    target: Target
    verb: Verb
    at_s: float | None = Field(default=None, ge=0, le=36000)
    when: Condition | None = None
    duration_s: float | None = Field(default=None, gt=0, le=36000)
    delay_s: float | None = Field(default=None, gt=0, le=60)
    factor: float | None = Field(default=None, gt=1, le=1000)
    fraction: float | None = Field(default=None, ge=0, le=1)
    offset_m: float | None = Field(default=None, ge=-100000, le=100000)
    deviation_m: float | None = Field(default=None, gt=0, le=1000)
    period_s: float | None = Field(default=None, gt=0, le=600)
    duty: float | None = Field(default=None, gt=0, lt=1)
    rate_bytes_s: float | None = Field(default=None, gt=0, le=1e7)
    system_id: int | None = Field(default=None, ge=1, le=255)
    remaining: float | None = Field(default=None, ge=0, le=1)
    acceleration_m_s2: float | None = Field(default=None, ge=-20, le=20)
    mode: ModeName | None = None
    result: DenialName | None = None

    @model_validator(mode="after")
    def _is_consistent(self) -> Fault:
        if (self.at_s is None) == (self.when is None):
            found = "neither is given" if self.at_s is None else "both are given"
            raise ValueError(f"a fault begins at a time or on a condition: give at_s or when; {found}")
        taken = FIELDS[self.target][self.verb]
        for name in sorted(self.model_fields_set - {"target", "verb", "at_s", "when", "duration_s"}):
            if name not in taken:
                right = f"it takes {', '.join(taken)}" if taken else "it takes no further field"
                raise ValueError(f"{name} = {getattr(self, name)!r} means nothing to {self.target} {self.verb}; {right}")
        return self

    @property
    def name(self) -> str:
        return f"{self.target} {self.verb}"

    def get(self, field: str) -> Any:
        """The value of a field that this verb takes, or its default."""
        value = getattr(self, field)
        return FIELDS[self.target][self.verb][field] if value is None else value

    def targets(self) -> tuple[str, ...]:
        return ("link_up", "link_down") if self.target == "link" else (self.target,)


class FaultScript(Strict):
    """The scenario file of one mock autopilot."""

    description: str = ""
    faults: tuple[Fault, ...] = ()

    @model_validator(mode="after")
    def _do_not_overlap(self) -> FaultScript:
        for index, fault in enumerate(self.faults):
            for other_index in range(index):
                other = self.faults[other_index]
                if not set(fault.targets()) & set(other.targets()) or fault.at_s is None or other.at_s is None:
                    continue
                first, second = sorted((fault, other), key=lambda f: f.at_s or 0.0)
                end = float("inf") if first.duration_s is None else (first.at_s or 0.0) + first.duration_s
                if (second.at_s or 0.0) < end:
                    raise ValueError(
                        f"faults[{index}] ({fault.name}) and faults[{other_index}] ({other.name}) contradict: "
                        "both act on the same target at the same time; "
                        "give the earlier one a duration_s that ends before the later at_s"
                    )
        return self


def load_fault_script(path: Path) -> FaultScript:
    """The validated script in `path`; InputError names file, field, value and what would be right."""
    return load(FaultScript, path)


@dataclass(frozen=True, slots=True)
class Situation:
    """What the conditions of a script look at."""

    armed: bool
    mode: str
    landed: bool
    height_m: float
    speed_m_s: float


Report = Callable[[str, "ActiveFault", str], None]
"""Called with (event, fault, detail); event is began, felt or ended."""


class ActiveFault:
    """One fault and its state while the script plays."""

    def __init__(self, index: int, fault: Fault, seed: int, report: Report) -> None:
        self.index = index
        self.fault = fault
        self.verb = fault.verb
        self.random = random.Random(f"fault {seed} {index}")
        self.met_s: float | None = None
        """When the condition was met."""
        self.began_s: float | None = None
        self.felt_count = 0
        self.t_s = 0.0
        self._report = report

    @property
    def name(self) -> str:
        return self.fault.name

    def get(self, field: str) -> Any:
        return self.fault.get(field)

    def bites(self) -> bool:
        """False in the good part of an intermittent fault's period."""
        if self.verb != "intermittent":
            return True
        phase = (self.t_s - (self.began_s or 0.0)) % self.get("period_s")
        return bool(phase < self.get("duty") * self.get("period_s"))

    def felt(self, detail: str) -> None:
        """Something really was suppressed or altered."""
        self.felt_count += 1
        if self.felt_count == 1:
            self._report("felt", self, detail)


class FaultEngine:
    """Plays a script: which fault acts on a target now."""

    def __init__(self, script: FaultScript, *, seed: int, report: Report) -> None:
        self._seed = seed
        self._report = report
        self.faults = [ActiveFault(index, fault, seed, report) for index, fault in enumerate(script.faults)]
        self._waiting = list(self.faults)
        self._running: list[ActiveFault] = []
        self._by_target: dict[str, ActiveFault] = {}

    def add(self, fault: Fault) -> ActiveFault:
        """One more fault while the script plays: for campaigns that choose the moment by what happens."""
        active = ActiveFault(len(self.faults), fault, self._seed, self._report)
        self.faults.append(active)
        self._waiting.append(active)
        return active

    def update(self, t_s: float, situation: Situation) -> None:
        """Begin and end faults."""
        for active in tuple(self._waiting):
            if self._is_due(active, t_s, situation):
                self._waiting.remove(active)
                self._running.append(active)
                active.began_s = active.t_s = t_s
                for target in active.fault.targets():
                    self._by_target[target] = active
                self._report("began", active, "")
        for active in tuple(self._running):
            active.t_s = t_s
            duration = active.fault.duration_s
            if duration is not None and active.began_s is not None and t_s >= active.began_s + duration:
                self._running.remove(active)
                self._by_target = {target: fault for fault in self._running for target in fault.fault.targets()}
                self._report("ended", active, "")

    def on(self, target: str) -> ActiveFault | None:
        """The fault that acts on `target` now; of several the one that began last."""
        return self._by_target.get(target)

    def unfelt(self) -> list[ActiveFault]:
        """Faults that never changed anything."""
        return [active for active in self.faults if active.felt_count == 0]

    @staticmethod
    def _is_due(active: ActiveFault, t_s: float, situation: Situation) -> bool:
        fault = active.fault
        if fault.at_s is not None:
            return t_s >= fault.at_s
        condition = fault.when
        if condition is None:
            return False
        if active.met_s is None and _holds(condition, situation):
            active.met_s = t_s
        return active.met_s is not None and t_s >= active.met_s + condition.after_s


def _holds(condition: Condition, situation: Situation) -> bool:
    return (
        (condition.armed is None or condition.armed == situation.armed)
        and (condition.mode is None or condition.mode == situation.mode)
        and (condition.landed is None or condition.landed == situation.landed)
        and (condition.height_above_m is None or situation.height_m > condition.height_above_m)
        and (condition.height_below_m is None or situation.height_m < condition.height_below_m)
        and (condition.speed_above_m_s is None or situation.speed_m_s > condition.speed_above_m_s)
    )
