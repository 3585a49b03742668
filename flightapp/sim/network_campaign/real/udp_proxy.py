"""A bad network between processes of one machine: a UDP port for every directed pair, shaped. Needs no rights."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from functools import partial

from flightapp.sim.link_shaper import LinkShaper

HOST = "127.0.0.1"
DATAGRAM_MAX_BYTES = 65_535
READ_AT_ONCE = 64
"""Datagrams, before the loop goes on to others."""


class UdpProxy:
    """Whoever sends to the port of `through(a, b, port)` reaches b's `port` as over a bad link, and is answered the same way."""

    def __init__(self, shaper: LinkShaper) -> None:
        self._shaper = shaper
        self._loop = asyncio.get_running_loop()
        self._sockets: list[socket.socket] = []
        self._returns: dict[tuple[int, tuple[str, int]], socket.socket] = {}
        """By entrance and by who came in there: the socket that talks to the other side for it."""
        self.passed = self.lost = 0
        """Datagrams."""

    def through(self, sender: str, receiver: str, port: int) -> int:
        """Open an entrance for `sender` to `receiver`, who listens on `port`; the number of the entrance's own port."""
        entrance = self._open()
        entrance.bind((HOST, 0))
        self._loop.add_reader(entrance, partial(self._enter, entrance, sender, receiver, port))
        return int(entrance.getsockname()[1])

    def close(self) -> None:
        for each in self._sockets:
            self._loop.remove_reader(each)
            each.close()
        self._sockets.clear()

    def _open(self) -> socket.socket:
        opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        opened.setblocking(False)
        self._sockets.append(opened)
        return opened

    def _enter(self, entrance: socket.socket, sender: str, receiver: str, port: int) -> None:
        for _ in range(READ_AT_ONCE):
            try:
                datagram, client = entrance.recvfrom(DATAGRAM_MAX_BYTES)
            except (BlockingIOError, ConnectionRefusedError):
                return
            onward = self._returns.get((entrance.fileno(), client))
            if onward is None:
                onward = self._returns[entrance.fileno(), client] = self._open()
                onward.connect((HOST, port))
                self._loop.add_reader(onward, partial(self._answer, onward, entrance, client, receiver, sender))
            self._pass(sender, receiver, partial(onward.send, datagram))

    def _answer(
        self, onward: socket.socket, entrance: socket.socket, client: tuple[str, int], sender: str, receiver: str
    ) -> None:
        for _ in range(READ_AT_ONCE):
            try:
                datagram = onward.recv(DATAGRAM_MAX_BYTES)
            except (BlockingIOError, ConnectionRefusedError):
                return
            self._pass(sender, receiver, partial(entrance.sendto, datagram, client))

    def _pass(self, sender: str, receiver: str, send: Callable[[], int]) -> None:
        delay_s = self._shaper.delay_s(sender, receiver)
        if delay_s is None:
            self.lost += 1
            return
        self._loop.call_later(delay_s, self._send, send)

    def _send(self, send: Callable[[], int]) -> None:
        """A receiver that is not there, or whose buffer is full, is a loss like any other."""
        try:
            send()
            self.passed += 1
        except OSError:
            self.lost += 1
