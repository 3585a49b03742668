"""A pursuer's own view that the evader is captured, sent as long as it holds it: ten times a second."""

from __future__ import annotations

from typing import Annotated

import msgspec

from flightapp.fleet.coordination.agreement import Verdict
from flightapp.fleet.messages.codec import Header, Kind
from flightapp.fleet.messages.lanes import VERDICTS
from flightapp.fleet.messages.plan import SEATS_MAX
from flightapp.fleet.messages.units import Name


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    by: Annotated[tuple[Name, ...], msgspec.Meta(min_length=1, max_length=SEATS_MAX)]


def _pack(verdict: Verdict, _: Header) -> _Wire:
    return _Wire(tuple(sorted(verdict.by)))


def _unpack(wire: _Wire, _: Header) -> Verdict:
    return Verdict(frozenset(wire.by))


VERDICT = Kind("verdict", _Wire, _pack, _unpack, VERDICTS, age_max_s=0.5)
