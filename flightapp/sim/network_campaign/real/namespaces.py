"""A network namespace a vehicle, joined by a switch of this process, which does to IP packets what a radio link would.

Every namespace has one TUN device, whose other end is a file of this process: delay, loss and partition need no kernel module
(`sch_netem` is missing on many machines) and are the same as those of the proxy and of the virtual network, seed by seed.
Needs the rights of an administrator and must run in a network namespace of its own, for which `unshare --net` is enough.
"""

from __future__ import annotations

import asyncio
import fcntl
import os
import shutil
import struct
import subprocess
from collections.abc import Sequence
from functools import partial

from flightapp.core.errors import FlightError
from flightapp.sim.link_shaper import LinkShaper

PACKET_MAX_BYTES = 65_535
READ_AT_ONCE = 64
SUBNET = "10.77.0"
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
DESTINATION = slice(16, 20)
"""Of an IPv4 header."""
PROBE = "ip link set lo up && ip tuntap add dev probe mode tun && ip netns add {0} && ip netns delete {0}"


def can_use_namespaces() -> bool:
    """Whether this machine lets this user make namespaces and TUN devices; found out by making some."""
    if shutil.which("ip") is None or shutil.which("unshare") is None:
        return False
    probe = PROBE.format(f"flightapp-probe-{os.getpid()}")
    return subprocess.run(["unshare", "--net", "sh", "-c", probe], check=False, capture_output=True).returncode == 0


class NamespaceSwitch:
    """Opens a namespace for each of `names`; use as a context manager, in a running event loop."""

    def __init__(self, shaper: LinkShaper, names: Sequence[str]) -> None:
        self._shaper = shaper
        self._loop = asyncio.get_running_loop()
        self._names = tuple(names)
        self._files: dict[str, int] = {}
        self._at = {bytes(map(int, self.address(name).split("."))): name for name in names}
        self.passed = self.lost = 0
        """Packets."""

    def __enter__(self) -> NamespaceSwitch:
        try:
            for name in self._names:
                self._add(name)
        except (OSError, subprocess.CalledProcessError) as error:
            self.close()
            raise FlightError(f"a network namespace cannot be made: {error}; try --proxy") from None
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def address(self, name: str) -> str:
        return f"{SUBNET}.{self._names.index(name) + 1}"

    def enter(self, name: str) -> list[str]:
        """What to write before a command so that it runs where `name` is."""
        return ["ip", "netns", "exec", _namespace(name)]

    def close(self) -> None:
        for name, file in self._files.items():
            self._loop.remove_reader(file)
            os.close(file)
            subprocess.run(["ip", "netns", "delete", _namespace(name)], check=False, capture_output=True)
        self._files.clear()

    def _add(self, name: str) -> None:
        device, namespace = f"fa{self._names.index(name)}", _namespace(name)
        file = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        self._files[name] = file
        fcntl.ioctl(file, TUNSETIFF, struct.pack("16sH22x", device.encode(), IFF_TUN | IFF_NO_PI))
        for arguments in (
            ("netns", "add", namespace),
            ("link", "set", device, "netns", namespace),
            ("-n", namespace, "link", "set", "lo", "up"),
            ("-n", namespace, "addr", "add", f"{self.address(name)}/24", "dev", device),
            ("-n", namespace, "link", "set", device, "up"),
        ):
            subprocess.run(["ip", *arguments], check=True, capture_output=True)
        self._loop.add_reader(file, partial(self._read, file, name))

    def _read(self, file: int, sender: str) -> None:
        for _ in range(READ_AT_ONCE):
            try:
                packet = os.read(file, PACKET_MAX_BYTES)
            except BlockingIOError:
                return
            receiver = self._at.get(packet[DESTINATION])
            if receiver is None:  # IPv6 neighbours and multicast: nobody of the fleet.
                continue
            delay_s = self._shaper.delay_s(sender, receiver)
            if delay_s is None:
                self.lost += 1
            else:
                self._loop.call_later(delay_s, self._write, receiver, packet)

    def _write(self, receiver: str, packet: bytes) -> None:
        try:
            os.write(self._files[receiver], packet)
            self.passed += 1
        except (OSError, KeyError):
            self.lost += 1


def _namespace(name: str) -> str:
    """Names are the machine's: two campaigns must not share them."""
    return f"flightapp-{os.getpid()}-{name}"
