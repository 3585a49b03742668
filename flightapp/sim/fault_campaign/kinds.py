"""Every kind of fault that the campaign knows: how it is done, for how long, and whether it excuses where a vehicle flies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_campaign.effects import (
    Commanded,
    CutOff,
    Effect,
    Filmed,
    FullDisk,
    Hung,
    Killed,
    Piloted,
    Planning,
    Scripted,
    WrongClock,
)
from flightapp.sim.fault_campaign.plan import Injection
from flightapp.sim.fault_script import Target, Verb

Range = tuple[float, float]
SHORT: Range = (0.2, 2.0)
LONG: Range = (2.0, 15.0)


@dataclass(frozen=True, slots=True)
class Kind:
    """`duration_s` None: to the end. `excuses`: see `attribution`. `ranges`: fields drawn evenly."""

    make: Callable[[Injection], Effect]
    duration_s: Range | None = None
    excuses: bool = False
    ranges: tuple[tuple[str, Range], ...] = ()
    from_start: bool = False
    """Only the beginning is a time for it."""
    needs_camera: bool = False


def _scripted(
    target: Target,
    verb: Verb,
    duration_s: Range | None,
    *,
    excuses: bool = False,
    from_start: bool = False,
    **ranges: Range,
) -> Kind:
    def make(injection: Injection) -> Effect:
        return Scripted(target, verb, injection.duration_s, dict(injection.fields))

    return Kind(make, duration_s, excuses, tuple(sorted(ranges.items())), from_start)


KINDS: Mapping[str, Kind] = {
    "link off": _scripted("link", "off", LONG, excuses=True),
    "link up off": _scripted("link_up", "off", LONG, excuses=True),
    "link up intermittent": _scripted("link_up", "intermittent", LONG, excuses=True, period_s=(0.3, 2.0)),
    "link up delayed": _scripted("link_up", "delayed", LONG, excuses=True, delay_s=(0.1, 0.8)),
    "link up garbage": _scripted("link_up", "garbage", LONG, excuses=True, fraction=(0.2, 1.0)),
    "link down off": _scripted("link_down", "off", LONG),
    "link down short": _scripted("link_down", "off", SHORT),
    "link down intermittent": _scripted("link_down", "intermittent", LONG, period_s=(0.3, 2.0)),
    "link down delayed": _scripted("link_down", "delayed", LONG, delay_s=(0.1, 0.8)),
    "link down garbage": _scripted("link_down", "garbage", LONG, fraction=(0.2, 1.0)),
    "telemetry off": _scripted("telemetry", "off", LONG),
    "telemetry stuck": _scripted("telemetry", "stuck", LONG, excuses=True),
    "telemetry delayed": _scripted("telemetry", "delayed", LONG, delay_s=(0.1, 0.8)),
    "telemetry slow": _scripted("telemetry", "slow", LONG, factor=(2.0, 20.0)),
    "telemetry garbage": _scripted("telemetry", "garbage", LONG, excuses=True, fraction=(0.1, 0.9)),
    "gps off": _scripted("gps", "off", LONG, excuses=True),
    "gps stuck": _scripted("gps", "stuck", LONG, excuses=True),
    "gps wrong": _scripted("gps", "wrong", LONG, excuses=True, offset_m=(-6.0, 6.0)),
    "gps garbage": _scripted("gps", "garbage", LONG, excuses=True, deviation_m=(0.5, 4.0)),
    "gps delayed": _scripted("gps", "delayed", LONG, excuses=True, delay_s=(0.2, 1.5)),
    "battery low": _scripted("battery", "wrong", None, remaining=(0.12, 0.2)),
    "battery critical": _scripted("battery", "wrong", None, remaining=(0.02, 0.09)),
    "arming refused": _scripted("arming", "off", (5.0, 40.0), from_start=True),
    "arming slow": _scripted("arming", "slow", (20.0, 40.0), from_start=True, delay_s=(0.5, 4.0)),
    "mode refused": _scripted("mode", "off", (1.0, 10.0)),
    "mode slow": _scripted("mode", "slow", LONG, delay_s=(0.3, 2.0)),
    "mode nonsense": _scripted("mode", "garbage", SHORT),
    "motors weak": _scripted("motors", "slow", LONG, excuses=True, fraction=(0.5, 0.8)),
    "motors push": _scripted("motors", "wrong", LONG, excuses=True, acceleration_m_s2=(-3.0, 3.0)),
    "pilot by stick": Kind(lambda _: Piloted(Mode.POSCTL), (2.0, 12.0)),
    "pilot by switch": Kind(lambda _: Piloted(Mode.ALTCTL), (0.5, 4.0)),
    "operator hold": Kind(lambda _: Commanded("hold", then="resume"), LONG),
    "operator rtl": Kind(lambda _: Commanded("rtl")),
    "operator land": Kind(lambda _: Commanded("land")),
    "operator abort": Kind(lambda _: Commanded("abort")),
    "killed": Kind(lambda _: Killed(), excuses=True),
    "hung": Kind(lambda _: Hung(), excuses=True),
    "planner raises": Kind(lambda _: Planning("raises"), SHORT),
    "planner no number": Kind(lambda _: Planning("no number"), (0.05, 2.0)),
    "planner slow": Kind(lambda _: Planning("slow"), (0.1, 3.0)),
    "camera off": Kind(lambda _: Filmed("off"), LONG, needs_camera=True),
    "camera short": Kind(lambda _: Filmed("off"), SHORT, needs_camera=True),
    "camera blind": Kind(lambda _: Filmed("blind"), LONG, needs_camera=True),
    "camera raises": Kind(lambda _: Filmed("raises"), LONG, needs_camera=True),
    "network short": Kind(lambda _: CutOff(), SHORT),
    "network long": Kind(lambda _: CutOff(), (5.0, 30.0)),
    "clock wrong": Kind(
        lambda injection: WrongClock(dict(injection.fields)["step_s"]), ranges=(("step_s", (-1.5, 1.5)),), from_start=True
    ),
    "disk full": Kind(lambda _: FullDisk()),
}
