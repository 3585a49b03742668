"""Do the links between the vehicles survive lost packets, and can the fleet keep its budget?"""

from __future__ import annotations

import math

from flightapp.fleet.state_rates import least_kbit_s
from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "fleet-links"
BUDGET = "fleet-budget"
REASON = "over plain UDP nobody repeats a lost handshake or subscription: a vehicle can stay deaf to another for good"
ON_THIS_MACHINE = ("127.", "localhost", "[::1]")


def judge(facts: Facts) -> tuple[Result, ...]:
    return (_endpoints(facts), *_budget(facts))


def _endpoints(facts: Facts) -> Result:
    endpoints = facts.profile.network.connect_endpoints
    lossy = [text for text in endpoints if text.startswith("udp/") and not text.removeprefix("udp/").startswith(ON_THIS_MACHINE)]
    if not lossy:
        found = ", ".join(sorted({text.partition("/")[0] for text in endpoints})) or "no other vehicle is connected to"
        return Result(NAME, Level.PASSED, found, REASON)
    remedy = "quic/ endpoints with certificates ('flightapp keys'), or tcp/ without"
    return Result(NAME, Level.WARNING, ", ".join(lossy), REASON, remedy)


def _budget(facts: Facts) -> tuple[Result, ...]:
    """A warning where what the fleet may send is less than it sends while no vehicle is near another."""
    network, count = facts.profile.network, len(facts.mission.vehicles)
    least = math.ceil(least_kbit_s(count, network.state_rate_hz, closed=network.certificates is not None))
    if network.fleet_kbit_s_max >= least:
        return ()
    found = f"network.fleet_kbit_s_max = {network.fleet_kbit_s_max:g}, {count} vehicles send {least} kbit/s or more"
    remedy = f"a network.state_rate_hz below {network.state_rate_hz:g}, or a budget of {least}"
    return (Result(BUDGET, Level.WARNING, found, "a radio that is asked for more than it carries loses states", remedy),)
