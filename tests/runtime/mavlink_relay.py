"""A UDP relay between a mock autopilot and MAVSDK that notes what crosses the wire, and when."""

from __future__ import annotations

import selectors
import socket
import struct
import threading
import time

HEARTBEAT = 0
COMMAND_LONG = 76
MODE_COMMANDS = (20, 21, 22, 176)
"""RETURN_TO_LAUNCH, LAND, TAKEOFF, DO_SET_MODE."""
SET_POSITION_TARGET_LOCAL_NED = 84
VELOCITY_OFFSET = 16
AUTOPILOT_COMPONENT = 1


class MavlinkRelay(threading.Thread):
    """The mock sends to `mock_port`; everything is passed on to MAVSDK at `companion_port`, and back."""

    def __init__(self, companion_port: int) -> None:
        super().__init__(daemon=True)
        self._to_mock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._to_mock.bind(("127.0.0.1", 0))
        self.mock_port: int = self._to_mock.getsockname()[1]
        self._to_companion = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._to_companion.connect(("127.0.0.1", companion_port))
        for each in (self._to_mock, self._to_companion):
            each.setblocking(False)
        self._mock: tuple[str, int] | None = None
        self._stopping = False
        self.setpoints_s: list[float] = []
        """Monotonic times of setpoints on their way to the autopilot."""
        self.velocities_m_s: list[tuple[float, float, float]] = []
        """Velocity north, east, down of each of these setpoints."""
        self.mode_commands_s: list[float] = []
        """Monotonic times of commands that ask the autopilot for another mode."""
        self.modes: list[tuple[float, int]] = []
        """(monotonic time, custom_mode >> 16) at each change; main mode in the low byte, sub mode in the next."""

    def run(self) -> None:
        selector = selectors.DefaultSelector()
        selector.register(self._to_mock, selectors.EVENT_READ)
        selector.register(self._to_companion, selectors.EVENT_READ)
        while not self._stopping:
            for key, _ in selector.select(0.05):
                try:
                    if key.fileobj is self._to_mock:
                        data, self._mock = self._to_mock.recvfrom(65535)
                        self._note_from_mock(data)
                        self._to_companion.send(data)
                    else:
                        data = self._to_companion.recv(65535)
                        self._note_to_mock(data)
                        if self._mock is not None:
                            self._to_mock.sendto(data, self._mock)
                except (ConnectionRefusedError, BlockingIOError):
                    continue  # MAVSDK is not listening yet, or no more.

    def stop(self) -> None:
        self._stopping = True
        self.join()
        self._to_mock.close()
        self._to_companion.close()

    def mode(self) -> int | None:
        return self.modes[-1][1] if self.modes else None

    def _note_to_mock(self, data: bytes) -> None:
        for number, _, payload in _messages(data):
            if number == SET_POSITION_TARGET_LOCAL_NED:
                self.setpoints_s.append(time.monotonic())
                self.velocities_m_s.append(struct.unpack_from("<3f", payload.ljust(53, b"\0"), VELOCITY_OFFSET))
            elif number == COMMAND_LONG and int.from_bytes(payload[28:30].ljust(2, b"\0"), "little") in MODE_COMMANDS:
                self.mode_commands_s.append(time.monotonic())

    def _note_from_mock(self, data: bytes) -> None:
        for number, component, payload in _messages(data):
            if number == HEARTBEAT and component == AUTOPILOT_COMPONENT:
                mode = int.from_bytes(payload[:4].ljust(4, b"\0"), "little") >> 16
                if mode != self.mode():
                    self.modes.append((time.monotonic(), mode))


def _messages(data: bytes) -> list[tuple[int, int, bytes]]:
    """(message id, component, payload) of every MAVLink 2 frame in a datagram."""
    found, at = [], 0
    while at + 12 <= len(data) and data[at] == 0xFD:
        length = data[at + 1]
        found.append((int.from_bytes(data[at + 7 : at + 10], "little"), data[at + 6], data[at + 10 : at + 10 + length]))
        at += 12 + length + (13 if data[at + 2] & 1 else 0)
    return found
