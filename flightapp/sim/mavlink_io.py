"""The mock's socket: packs and parses MAVLink over UDP, and runs the vehicle in real time."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable
from pathlib import Path

from flightapp.core.clock import monotonic_ns
from flightapp.sim.autopilot_core import STEP_S, AutopilotCore
from flightapp.sim.autopilot_protocol import COMPONENT_ID, Protocol
from flightapp.sim.autopilot_telemetry import Outgoing, Telemetry
from flightapp.sim.fault_script import FaultEngine
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.packet_path import PacketPath
from flightapp.sim.truth import Truth, TruthWriter

_STEP_NS = round(STEP_S * 1e9)
_STEPS_PER_CYCLE = 2
"""Steps between two looks at the socket: waking up costs more than a step."""
_DATAGRAM_MAX_BYTES = 1400
_BEHIND_MAX_NS = 250_000_000
"""Farther behind than this (a stopped process) the vehicle's time stands still instead of running after the clock."""


class Station:
    """One autopilot with its protocol, telemetry and faulty link; bytes in, bytes out; no clock."""

    def __init__(self, core: AutopilotCore, faults: FaultEngine, system_id: int) -> None:
        self.core = core
        self.telemetry = Telemetry(core)
        self.protocol = Protocol(core, self.telemetry, system_id)
        self._packer = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=COMPONENT_ID)
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True
        self._up = PacketPath("link_up", faults)
        self._down = PacketPath("link_down", faults)

    def receive(self, datagram: bytes) -> None:
        """A datagram from the companion enters the link."""
        self._up.push(self.core.t_s, datagram)
        self._deliver()

    def step(self) -> list[bytes]:
        """Advance by one step; the packets that leave."""
        core = self.core
        core.step()
        self._deliver()
        for outgoing in self.telemetry.poll():
            self._pack(outgoing)
        return self.answers()

    def answers(self) -> list[bytes]:
        """The packets that leave now, without advancing time."""
        for outgoing in self.protocol.poll():
            self._pack(outgoing)
        return self._down.pop(self.core.t_s)

    def _deliver(self) -> None:
        for packet in self._up.pop(self.core.t_s):
            for message in self._parser.parse_buffer(packet) or ():
                if message.get_type() != "BAD_DATA":
                    self.protocol.handle(message)

    def _pack(self, outgoing: Outgoing) -> None:
        packet = outgoing.message.pack(self._packer)
        self._packer.seq = (self._packer.seq + 1) % 256
        if outgoing.broken:
            packet = packet[:-1] + bytes((packet[-1] ^ 0x5A,))
        self._down.push(self.core.t_s, packet, outgoing.delay_s)


class RealTime:
    """Runs a station against the clock until told to stop."""

    def __init__(self, station: Station, send_to: tuple[str, int], truth: Path | None) -> None:
        self._station = station
        self._send_to = send_to
        self._truth = TruthWriter(truth) if truth is not None else None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.bind(("", 0))

    def run(self, stopped: Callable[[], bool], duration_s: float | None) -> None:
        """Step the vehicle in real time; returns when `stopped` or after `duration_s`."""
        station, step_at_ns = self._station, monotonic_ns()
        last_step = None if duration_s is None else round(duration_s / STEP_S)
        while not stopped() and (last_step is None or station.core.steps < last_step):
            now_ns = monotonic_ns()
            if now_ns - step_at_ns > _BEHIND_MAX_NS:
                step_at_ns = now_ns
            self._receive()
            packets = station.answers()
            while step_at_ns <= now_ns:
                packets += station.step()
                self._write_truth(step_at_ns)
                step_at_ns += _STEP_NS
            self._send(packets)
            left_ns = step_at_ns + (_STEPS_PER_CYCLE - 1) * _STEP_NS - monotonic_ns()
            if left_ns > 0:
                time.sleep(left_ns * 1e-9)

    def close(self) -> None:
        self._socket.close()
        if self._truth is not None:
            self._truth.close()

    def _receive(self) -> None:
        """Everything that has come."""
        with contextlib.suppress(BlockingIOError, ConnectionError):
            while True:
                self._station.receive(self._socket.recv(65535))

    def _send(self, packets: list[bytes]) -> None:
        """Several packets share a datagram, as PX4 does it."""
        datagram = b""
        for packet in (*packets, b""):
            if datagram and (not packet or len(datagram) + len(packet) > _DATAGRAM_MAX_BYTES):
                # A full buffer or nobody listening loses the datagram, as a radio does.
                with contextlib.suppress(OSError):
                    self._socket.sendto(datagram, self._send_to)
                datagram = b""
            datagram += packet

    def _write_truth(self, at_ns: int) -> None:
        if self._truth is None:
            return
        vehicle = self._station.core.vehicle
        self._truth.write(
            Truth(
                at_ns,
                vehicle.position_ned_m,
                vehicle.velocity_ned_m_s,
                vehicle.roll_rad,
                vehicle.pitch_rad,
                vehicle.yaw_rad,
                self._station.core.armed,
                vehicle.on_ground,
            )
        )
