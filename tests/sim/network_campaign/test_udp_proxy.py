"""Real bytes through the proxy, both ways: late, lost, cut off and back."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable

from flightapp.sim.link_shaper import LinkQuality, LinkShaper
from flightapp.sim.network_campaign.real.udp_proxy import HOST, UdpProxy

DEADLINE_S = 10.0


class Ends:
    """p1, who sends through the proxy to p2 and is answered."""

    def __init__(self, quality: LinkQuality) -> None:
        self.shaper = LinkShaper(quality, 1)
        self.proxy = UdpProxy(self.shaper)
        self.p1, self.p2 = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self.p2.bind((HOST, 0))
        for end in (self.p1, self.p2):
            end.setblocking(False)
        self.p1.connect((HOST, self.proxy.through("p1", "p2", self.p2.getsockname()[1])))

    async def send(self, count: int) -> None:
        """One by one, so that no buffer of the kernel is full."""
        for number in range(count):
            done = self.proxy.lost + self.proxy.passed
            self.p1.send(b"%d" % number)
            await until(lambda done=done: self.proxy.lost + self.proxy.passed > done)  # type: ignore[misc]

    def close(self) -> None:
        self.proxy.close()
        self.p1.close()
        self.p2.close()


async def until(is_true: Callable[[], bool]) -> None:
    async with asyncio.timeout(DEADLINE_S):
        while not is_true():
            await asyncio.sleep(0.001)


def received(end: socket.socket) -> list[bytes]:
    taken = []
    while True:
        try:
            taken.append(end.recv(100))
        except BlockingIOError:
            return taken


def test_bytes_pass_both_ways_no_sooner_than_the_delay() -> None:
    async def story() -> None:
        ends, loop = Ends(LinkQuality(0.05)), asyncio.get_running_loop()
        began_s = loop.time()
        ends.p1.send(b"question")
        datagram, entrance = await loop.sock_recvfrom(ends.p2, 100)
        asked_s = loop.time() - began_s
        await loop.sock_sendto(ends.p2, b"answer", entrance)
        assert datagram == b"question"
        assert await loop.sock_recv(ends.p1, 100) == b"answer"
        assert asked_s >= 0.05 - 1e-3
        assert loop.time() - began_s >= 0.1 - 2e-3
        ends.close()

    asyncio.run(story())


def test_as_many_are_lost_as_the_shaper_says_and_no_others() -> None:
    async def story() -> None:
        ends, twin = Ends(LinkQuality(0.0, 0.0, 0.3)), LinkShaper(LinkQuality(0.0, 0.0, 0.3), 1)
        await ends.send(200)
        expected = [b"%d" % number for number in range(200) if twin.delay_s("p1", "p2") is not None]
        assert received(ends.p2) == expected
        assert 30 < ends.proxy.lost < 90
        ends.close()

    asyncio.run(story())


def test_a_partition_is_felt_and_heals() -> None:
    async def story() -> None:
        ends = Ends(LinkQuality(0.0))
        await ends.send(3)
        assert len(received(ends.p2)) == 3
        ends.shaper.split({"p2"})
        await ends.send(3)
        assert received(ends.p2) == []
        ends.shaper.heal()
        await ends.send(1)
        assert received(ends.p2) == [b"0"]
        ends.close()

    asyncio.run(story())
