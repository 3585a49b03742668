"""The controllers that are compared, each with the gains printed and with gains for the vehicle at hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from flightapp.control.cascade import CascadeGains
from flightapp.control.gains import DEFAULT, IDEAL, Gains
from flightapp.control.printed import PRINTED as PRINTED_GAINS
from flightapp.control.printed import TUNED_PID, PrintedGains
from flightapp.core.types import Array
from flightapp.sim.control_study.flight import CASCADE, LAW, PRINTED

AnyGains = Gains | PrintedGains | CascadeGains


@dataclass(frozen=True, slots=True)
class Plant:
    """The vehicle as the controller has it before it."""

    name: str
    period_steps: int
    lag_s: float
    delay_steps: int


IDEAL_PLANT = Plant("1 kHz", 1, 0.0, 0)
"""The source's double integrator."""
REAL_PLANT = Plant("50 Hz, lag", 20, 0.1, 20)
"""A vehicle under PX4: 0.1 s of lag and 20 ms of delay."""
PLANTS = (IDEAL_PLANT, REAL_PLANT)


@dataclass(frozen=True, slots=True)
class Method:
    """`gains_set`: printed or tuned."""

    name: str
    gains_set: str
    kind: int
    ideal: AnyGains
    real: AnyGains

    @property
    def label(self) -> str:
        return f"{self.name} {self.gains_set}"

    def gains(self, plant: Plant) -> Array:
        return (self.ideal if plant is IDEAL_PLANT else self.real).as_array()


def _law(name: str, change: Mapping[str, float]) -> Method:
    return Method(name, "tuned", LAW, replace(IDEAL, **change), replace(DEFAULT, **change))


def _same(name: str, gains_set: str, kind: int, gains: AnyGains) -> Method:
    return Method(name, gains_set, kind, gains, gains)


RAW_INPUT = {name: replace(PRINTED_GAINS[name], fed_limited=0.0) for name in ("hybrid", "adrc")}
METHODS: Mapping[str, Method] = MappingProxyType(
    {
        method.label: method
        for method in (
            *(_same(name, "printed", PRINTED, PRINTED_GAINS[name]) for name in ("hybrid", "smc", "pid", "adrc")),
            *(_same(name, "printed, raw input", PRINTED, gains) for name, gains in RAW_INPUT.items()),
            _law("hybrid", {}),
            _law("smc", {"observer_rad_s": 0.0, "switching_m_s2": 3.0, "layer_m_s": 0.5}),
            _same("pid", "tuned", PRINTED, TUNED_PID),
            _law("adrc", {"switching_m_s2": 0.0}),
            _same("px4", "default", CASCADE, CascadeGains()),
        )
    }
)
"""`raw input`: the observer is fed with the command before limiting, which the source leaves open."""
