"""Will the others let this vehicle into the fleet, and until when?"""

from __future__ import annotations

from datetime import UTC, datetime

from flightapp.fleet.security.credentials import Credentials
from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "certificates"
REASON = "with certificates only this fleet's vehicles and its operator can speak in it"
LAST_FLIGHT_S = 3600.0
"""A link that breaks in flight is opened again, and that takes a certificate that is still valid."""
SOON_S = 24 * 3600.0
RENEW = "make new ones with 'flightapp keys' for every machine, in a new folder"


def judge(facts: Facts) -> tuple[Result, ...]:
    own = facts.credentials
    if own is None:
        return (Result(NAME, Level.NOTED, "none: anybody on the network can join, and land the vehicles", REASON),)
    return (_judge(own, facts),)


def _judge(own: Credentials, facts: Facts) -> Result:
    until = f"valid until {_text(own.ends_s)}"
    if own.name != facts.vehicle.name:
        remedy = f"copy the folder that 'flightapp keys' made for {facts.vehicle.name} to this machine"
        return Result(NAME, Level.FAILED, f"they are those of '{own.name}'", REASON, remedy)
    if facts.t_s < own.begins_s:
        found = f"not valid before {_text(own.begins_s)}, and this machine's clock says {_text(facts.t_s)}"
        return Result(NAME, Level.FAILED, found, REASON, "set the clock (chrony)")
    if facts.t_s >= own.ends_s:
        return Result(NAME, Level.FAILED, f"expired at {_text(own.ends_s)}", REASON, f"look at the clock; else {RENEW}")
    if own.ends_s - facts.t_s < LAST_FLIGHT_S:
        return Result(NAME, Level.FAILED, f"{until}, in less than an hour", REASON, RENEW)
    if own.ends_s - facts.t_s < SOON_S:
        return Result(NAME, Level.WARNING, f"{until}, in less than a day", REASON, RENEW)
    if not facts.profile.network.access_control:
        found = f"{until}; without access control: every vehicle can speak as every other one, and command"
        return Result(NAME, Level.WARNING, found, REASON, "set network.access_control = true in the profile")
    return Result(NAME, Level.PASSED, f"'{own.name}', {until}", REASON)


def _text(unix_s: float) -> str:
    return datetime.fromtimestamp(unix_s, UTC).strftime("%Y-%m-%d %H:%M UTC")
