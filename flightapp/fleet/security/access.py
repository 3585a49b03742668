"""Zenoh's TLS and access-control configuration of one member of a fleet.

What comes in (`ingress`) is filtered by who it comes from: the receiver protects itself, a malicious sender would not filter its
own output. Who somebody is says the common name of the certificate with which the link was opened, in whichever direction.
Nothing is allowed that is not named here: each member writes and answers under its own name, everybody may listen, operators
may ask commands. Whoever has a certificate of the fleet's authority hears what is said in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.config.mission import Mission
from flightapp.fleet.messages.keys import CLOCK, COMMAND, key
from flightapp.fleet.security.credentials import Credentials, load_credentials

OPERATOR = "operator"
OWN_MESSAGES = ("put", "delete", "reply", "declare_queryable", "liveliness_token")
LISTENING = ("declare_subscriber", "declare_liveliness_subscriber", "liveliness_query")
ALL_MESSAGES = (*OWN_MESSAGES, *LISTENING, "query")


@dataclass(frozen=True, slots=True)
class Membership:
    """Who joins which fleet, and who else belongs to it."""

    fleet: str
    vehicles: tuple[str, ...]
    credentials: Credentials
    operators: tuple[str, ...] = (OPERATOR,)
    access_control: bool = True


def membership_of(mission: Mission, certificates: Path | None, *, access_control: bool = True) -> Membership | None:
    """Of whoever has `certificates`, in the fleet of `mission`; None: an open fleet. InputError for unusable files."""
    if certificates is None:
        return None
    vehicles = tuple(vehicle.name for vehicle in mission.vehicles)
    return Membership(mission.fleet, vehicles, load_credentials(certificates), access_control=access_control)


def tls_settings(credentials: Credentials) -> dict[str, Any]:
    """Both sides of a link show their certificate. A link does not end in flight because its certificate does."""
    own = {"certificate": str(credentials.certificate), "private_key": str(credentials.key)}
    return {
        "root_ca_certificate": str(credentials.authority),
        **{f"{side}_{name}": path for side in ("listen", "connect") for name, path in own.items()},
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": False,
    }


def access_settings(fleet: str, vehicles: Sequence[str], operators: Sequence[str]) -> dict[str, Any]:
    """Rules by certificate for whatever arrives; the same on every member."""
    everybody = (*vehicles, *operators)
    whole_fleet = key(fleet, "*", "**")
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [
            {"id": "say", "permission": "allow", "flows": ["egress"], "messages": list(ALL_MESSAGES), "key_exprs": [whole_fleet]},
            _incoming("listen", LISTENING, [whole_fleet]),
            _incoming("ask", ("query",), [key(fleet, "*", CLOCK)]),
            _incoming("command", ("query",), [key(fleet, "*", COMMAND)]),
            *(_incoming(f"own {name}", OWN_MESSAGES, [key(fleet, name, "**")]) for name in everybody),
        ],
        "subjects": [
            {"id": "everybody", "cert_common_names": list(everybody)},
            {"id": "operators", "cert_common_names": list(operators)},
            *({"id": f"the {name}", "cert_common_names": [name]} for name in everybody),
        ],
        "policies": [
            {"rules": ["say", "listen", "ask"], "subjects": ["everybody"]},
            {"rules": ["command"], "subjects": ["operators"]},
            *({"rules": [f"own {name}"], "subjects": [f"the {name}"]} for name in everybody),
        ],
    }


def _incoming(name: str, messages: Sequence[str], keys: Sequence[str]) -> dict[str, Any]:
    return {"id": name, "permission": "allow", "flows": ["ingress"], "messages": list(messages), "key_exprs": list(keys)}
