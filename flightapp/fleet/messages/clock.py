"""A vehicle's answer to "what time is it?": the header says it all."""

from __future__ import annotations

import math

import msgspec

from flightapp.fleet.messages.codec import SAFETY, Kind


class Now(msgspec.Struct, array_like=True, frozen=True):
    """The sender's fleet time is the header's `sent_s`."""


CLOCK = Kind("clock", Now, lambda now, _: now, lambda now, _: now, SAFETY, age_max_s=math.inf)
