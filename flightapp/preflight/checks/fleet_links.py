"""Do the links between the vehicles survive lost packets?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "fleet-links"
REASON = "over plain UDP nobody repeats a lost handshake or subscription: a vehicle can stay deaf to another for good"
ON_THIS_MACHINE = ("127.", "localhost", "[::1]")


def judge(facts: Facts) -> tuple[Result, ...]:
    endpoints = facts.profile.network.connect_endpoints
    lossy = [text for text in endpoints if text.startswith("udp/") and not text.removeprefix("udp/").startswith(ON_THIS_MACHINE)]
    if not lossy:
        found = ", ".join(sorted({text.partition("/")[0] for text in endpoints})) or "no other vehicle is connected to"
        return (Result(NAME, Level.PASSED, found, REASON),)
    remedy = "quic/ endpoints with certificates ('flightapp keys'), or tcp/ without"
    return (Result(NAME, Level.WARNING, ", ".join(lossy), REASON, remedy),)
