"""A Zenoh session with explicit endpoints and nothing found by multicast."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from typing import Any

import zenoh

from flightapp.core.errors import FlightError
from flightapp.fleet.security.access import Membership, access_settings, tls_settings

MESSAGE_MAX_BYTES = 65_536
"""Zenoh itself drops what is larger than this; what is smaller and still too large is refused by name, see `messages.codec`."""
DATAGRAMS_AND_STREAMS = "?mixed_rel=1"
"""Of a QUIC endpoint: best-effort publications are datagrams. TLS brings them late, in a burst, after an outage of the link."""
OPENING_MS = 500
"""Of a link over UDP, which repeats nothing: an attempt whose packet is lost ends, and the next one begins."""
SECURE_OPENING_MS = 2000
"""Of QUIC and TLS: some four round trips, and repetitions. With 500 ms a fleet 100 ms apart never gets a link at all."""
_NOTHING_HUGE = {
    "id": "nothing huge",
    "flows": ["ingress"],
    "messages": ["put", "delete", "query", "reply"],
    "key_exprs": ["**"],
    "size_limit": MESSAGE_MAX_BYTES,
}


def zenoh_config(
    listen: Sequence[str], connect: Sequence[str], *, wait_for_peers: bool = True, membership: Membership | None = None
) -> zenoh.Config:
    """Peer configuration: no multicast, no gossip, quick retry, a lease of 1.5 s (default 10 s).

    membership: with it only certificates of its authority are talked to; without it anybody.
    wait_for_peers: opening waits up to half a second for those that are connected to, also when one of them is dead.
    """
    opening_ms = OPENING_MS if membership is None else SECURE_OPENING_MS
    settings: dict[str, Any] = {
        "mode": "peer",
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "listen/endpoints": [_endpoint(text) for text in listen],
        "connect/endpoints": [_endpoint(text) for text in connect],
        "connect/exit_on_failure": False,
        "open/return_conditions/connect_scouted": wait_for_peers,
        "connect/retry": {"period_init_ms": 200, "period_max_ms": 500, "period_increase_factor": 1.5},
        "transport/link/tx/lease": 1500,
        "transport/unicast/open_timeout": opening_ms,
        "transport/unicast/accept_timeout": opening_ms,
        "low_pass_filter": [_NOTHING_HUGE],
    }
    if membership is not None:
        settings["transport/link/protocols"] = ["quic", "tls"]
        settings["transport/link/tls"] = tls_settings(membership.credentials)
        if membership.access_control:
            settings["access_control"] = access_settings(membership.fleet, membership.vehicles, membership.operators)
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _endpoint(text: str) -> str:
    return text + DATAGRAMS_AND_STREAMS if text.startswith("quic/") else text


async def open_session(
    listen: Sequence[str], connect: Sequence[str], *, wait_for_peers: bool = True, membership: Membership | None = None
) -> zenoh.Session:
    """Open a session without blocking the loop (it takes ~0.5 s while peers are absent)."""
    try:
        config = zenoh_config(listen, connect, wait_for_peers=wait_for_peers, membership=membership)
        return await asyncio.to_thread(zenoh.open, config)
    except zenoh.ZError as error:
        raise FlightError(
            f"fleet network cannot be opened on {list(listen)}: {error}; check network.listen_endpoints in the profile"
        ) from None
