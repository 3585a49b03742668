"""The last resort over a real UDP link: it waits for whoever is silent, lands who climbs, and leaves everybody else alone."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

os.environ.setdefault("MAVLINK20", "1")

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from flightapp.sim.autopilot_modes import Mode
from flightapp.vehicle import last_resort
from flightapp.vehicle.last_resort import bring_down

SYSTEM_ID = 7


class Climber(threading.Thread):
    """An armed autopilot in `mode`, silent for the first of its periods, that lands when it is told to."""

    def __init__(self, port: int, mode: Mode, silent: int) -> None:
        super().__init__(daemon=True)
        self._link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=SYSTEM_ID, source_component=1)
        self._silent = silent
        self.mode = mode
        self.commands: list[int] = []
        self.ended = threading.Event()

    def run(self) -> None:
        while not self.ended.wait(0.05):
            if self._silent > 0:
                self._silent -= 1
                continue
            armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
            self._link.mav.heartbeat_send(2, mavlink.MAV_AUTOPILOT_PX4, armed, self.mode.custom_mode, 4)
            message = self._link.recv_match(type="COMMAND_LONG", blocking=False)
            if message is not None:
                self.commands.append(message.command)
                self.mode = Mode.LAND
        self._link.close()


@contextmanager
def flying(mode: Mode, silent: int) -> Iterator[tuple[str, Climber]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    climber = Climber(port, mode, silent)
    climber.start()
    try:
        yield f"udpin://127.0.0.1:{port}", climber
    finally:
        climber.ended.set()
        climber.join()


@pytest.mark.parametrize("mode", [Mode.TAKEOFF, Mode.HOLD])
def test_a_silent_climber_is_landed_once_it_is_heard(mode: Mode, capsys: pytest.CaptureFixture[str]) -> None:
    with flying(mode, silent=14) as (url, climber):
        assert bring_down(url, SYSTEM_ID, 20.0) == "autopilot 7: it lands"
        assert mavlink.MAV_CMD_NAV_LAND in climber.commands
    assert "not heard" in capsys.readouterr().err


def test_whoever_chose_another_mode_meanwhile_keeps_it() -> None:
    with flying(Mode.POSCTL, silent=4) as (url, climber):
        assert "nothing was commanded" in bring_down(url, SYSTEM_ID, 20.0)
        assert climber.commands == []


def test_a_device_that_is_not_there_is_tried_until_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    assert "does not work" in bring_down("serial:///dev/no-such-autopilot:57600", SYSTEM_ID, 0.7)
    assert "/dev/no-such-autopilot" in capsys.readouterr().err


def test_a_link_that_the_other_side_has_closed_is_opened_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(last_resort, "SILENCE_MAX_S", 0.2)
    came = []

    def serve() -> None:
        first, _ = server.accept()
        first.close()
        came.append(server.accept()[0])

    with socket.create_server(("127.0.0.1", 0)) as server:
        serving = threading.Thread(target=serve, daemon=True)
        serving.start()
        bring_down(f"tcpout://127.0.0.1:{server.getsockname()[1]}", SYSTEM_ID, 2.0)
        serving.join(2.0)
        assert len(came) == 1
        came[0].close()
