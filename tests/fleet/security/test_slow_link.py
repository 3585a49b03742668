"""A closed fleet over a link as slow as radios are: it gets connected."""

from __future__ import annotations

import asyncio
from pathlib import Path

import zenoh

from flightapp.fleet.messages.keys import key
from flightapp.sim.link_shaper import LinkQuality, LinkShaper
from flightapp.sim.network_campaign.real.udp_proxy import UdpProxy
from tests.fleet.security.members import FLEET, Loopback, make_fleet_keys

DEADLINE_S = 20.0


def test_members_a_tenth_of_a_second_apart_hear_each_other(tmp_path: Path) -> None:
    async def story() -> None:
        loopback = Loopback(make_fleet_keys(tmp_path / "keys"))
        proxy = UdpProxy(LinkShaper(LinkQuality(0.1, 0.05), 1))
        try:
            there = f"quic/127.0.0.1:{proxy.through('p2', 'p1', loopback.ports.numbers[0])}"
            p1 = await asyncio.to_thread(loopback.member, "p1", [loopback.endpoint(0)], [])
            p2 = await asyncio.to_thread(loopback.member, "p2", [], [there])
            heard = p1.declare_subscriber(key(FLEET, "p2", "state"), zenoh.handlers.RingChannel(4))
            publisher = p2.declare_publisher(key(FLEET, "p2", "state"))
            async with asyncio.timeout(DEADLINE_S):
                while heard.try_recv() is None:
                    publisher.put(b"here")
                    await asyncio.sleep(0.02)
        finally:
            await asyncio.to_thread(loopback.close)
            proxy.close()

    asyncio.run(story())
