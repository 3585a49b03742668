"""A TCP listener that opens late and then carries a mock's MAVLink: an autopilot behind a network that is not up yet."""

from __future__ import annotations

import contextlib
import select
import socket
import threading


class TcpGate(threading.Thread):
    """The mock sends to UDP `mock_port`; `open` starts to listen on TCP `port` and passes bytes both ways."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self._mock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._mock.bind(("127.0.0.1", 0))
        self.mock_port: int = self._mock.getsockname()[1]
        self._listener = socket.socket()
        self._listener.bind(("127.0.0.1", 0))  # Bound, not listening: connections are refused, the port stays ours.
        self.port: int = self._listener.getsockname()[1]
        self._opened, self._stopping = threading.Event(), threading.Event()

    def open(self) -> None:
        self._opened.set()

    def run(self) -> None:
        self._opened.wait()
        if self._stopping.is_set():
            return
        self._listener.listen()
        self._listener.settimeout(10.0)
        with contextlib.suppress(OSError):
            companion, _ = self._listener.accept()
            with companion:
                self._carry(companion)

    def _carry(self, companion: socket.socket) -> None:
        mock_address = None
        while not self._stopping.is_set():
            for ready in select.select([self._mock, companion], [], [], 0.05)[0]:
                if ready is self._mock:
                    data, mock_address = self._mock.recvfrom(65535)
                    companion.sendall(data)
                elif mock_address is not None and (data := companion.recv(65535)):
                    self._mock.sendto(data, mock_address)

    def stop(self) -> None:
        self._stopping.set()
        self._opened.set()
        self.join()
        self._mock.close()
        self._listener.close()
