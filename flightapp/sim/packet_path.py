"""One direction of the link between the mock autopilot and its companion, with the faults on it. Pure, on bytes."""

from __future__ import annotations

from collections import deque
from typing import Literal

from flightapp.sim.fault_script import ActiveFault, FaultEngine
from flightapp.sim.mavlink_dialect import mavlink

_BACKLOG_S = 2.0
"""A slow link keeps this much in its buffer and loses the rest."""
_HEADER = 10


class PacketPath:
    """Packets go in with `push` and come out of `pop` when they arrive."""

    def __init__(self, direction: Literal["link_up", "link_down"], faults: FaultEngine) -> None:
        self._direction = direction
        self._faults = faults
        self._waiting: deque[tuple[float, bytes]] = deque()
        self._line_free_s = 0.0
        self._last: bytes | None = None
        self._stuck: bytes | None = None

    def push(self, t_s: float, packet: bytes, delay_s: float = 0.0) -> None:
        """Send one packet at `t_s`."""
        fault = self._faults.on(self._direction)
        due_s = t_s + delay_s
        if fault is None:
            self._stuck = None
        else:
            altered = self._suffer(fault, t_s, packet)
            if altered is None:
                return
            due_s, packet = max(due_s, altered[0]), altered[1]
        self._last = packet
        self._waiting.append((due_s, packet))

    def pop(self, t_s: float) -> list[bytes]:
        """The packets that have arrived by `t_s`."""
        waiting = self._waiting
        if not waiting:
            return []
        arrived = [packet for due_s, packet in waiting if due_s <= t_s]
        if len(arrived) == len(waiting):
            waiting.clear()
        else:
            self._waiting = deque(item for item in waiting if item[0] > t_s)
        return arrived

    def _suffer(self, fault: ActiveFault, t_s: float, packet: bytes) -> tuple[float, bytes] | None:
        """Arrival time and content of the packet under the fault; None: lost."""
        verb = fault.verb
        if verb == "off" or (verb == "intermittent" and fault.bites()):
            fault.felt("packet lost")
            return None
        if verb == "stuck":
            if self._stuck is None:
                self._stuck = self._last or packet
            if self._stuck != packet:
                fault.felt("old packet repeated")
            return t_s, self._stuck
        if verb == "garbage" and fault.random.random() < fault.get("fraction"):
            fault.felt("bits flipped")
            return t_s, flip_bits(packet, fault)
        if verb == "wrong":
            fault.felt("foreign system id")
            return t_s, with_system_id(packet, fault.get("system_id"), self._direction)
        if verb == "slow":
            start_s = max(t_s, self._line_free_s)
            if start_s - t_s > _BACKLOG_S:
                fault.felt("packet lost in a full buffer")
                return None
            self._line_free_s = start_s + len(packet) / float(fault.get("rate_bytes_s"))
            if self._line_free_s - t_s > 0.02:
                fault.felt("packet waited")
            return self._line_free_s, packet
        if verb == "delayed":
            fault.felt("packet delayed")
            return t_s + float(fault.get("delay_s")), packet
        return t_s, packet


def flip_bits(packet: bytes, fault: ActiveFault) -> bytes:
    """The packet with one bit to eight wrong, its checksum as it was."""
    broken = bytearray(packet)
    for _ in range(fault.random.randint(1, 8)):
        broken[fault.random.randrange(len(broken))] ^= 1 << fault.random.randrange(8)
    if bytes(broken) == packet:
        broken[-1] ^= 0xFF
    return bytes(broken)


def with_system_id(packet: bytes, system_id: int, direction: Literal["link_up", "link_down"]) -> bytes:
    """The MAVLink 2 packets with another sender (link_down) or another addressee (link_up), checksum made good."""
    out = bytearray()
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    for message in parser.parse_buffer(packet) or []:
        if message.get_type() == "BAD_DATA":
            continue
        sender = system_id if direction == "link_down" else message.get_srcSystem()
        if direction == "link_up":
            if not hasattr(message, "target_system"):
                continue
            message.target_system = system_id
        packer = mavlink.MAVLink(None, srcSystem=sender, srcComponent=message.get_srcComponent())
        packer.seq = message.get_seq()
        out += message.pack(packer)
    return bytes(out)
