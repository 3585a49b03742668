"""A Zenoh session with explicit endpoints and nothing found by multicast."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence

import zenoh

from flightapp.core.errors import FlightError


def zenoh_config(listen: Sequence[str], connect: Sequence[str], *, wait_for_peers: bool = True) -> zenoh.Config:
    """Peer configuration: no multicast, no gossip, quick retry, a lease of 1.5 s (default 10 s).

    wait_for_peers: opening waits up to half a second for those that are connected to, also when one of them is dead.
    """
    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "listen/endpoints": list(listen),
        "connect/endpoints": list(connect),
        "connect/exit_on_failure": False,
        "open/return_conditions/connect_scouted": wait_for_peers,
        "connect/retry": {"period_init_ms": 200, "period_max_ms": 500, "period_increase_factor": 1.5},
        "transport/link/tx/lease": 1500,
        "transport/unicast/open_timeout": 500,
        "transport/unicast/accept_timeout": 500,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return config


async def open_session(listen: Sequence[str], connect: Sequence[str], *, wait_for_peers: bool = True) -> zenoh.Session:
    """Open a session without blocking the loop (it takes ~0.5 s while peers are absent)."""
    try:
        return await asyncio.to_thread(zenoh.open, zenoh_config(listen, connect, wait_for_peers=wait_for_peers))
    except zenoh.ZError as error:
        raise FlightError(
            f"fleet network cannot be opened on {list(listen)}: {error}; check network.listen_endpoints in the profile"
        ) from None
