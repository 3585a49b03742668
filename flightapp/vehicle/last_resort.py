"""The last thing that is done for a vehicle whose process has died, or lost the link, in its climb: it is landed, unless somebody
else flies it.

Once OFFBOARD is flown, PX4's own failsafe brings a vehicle down when the setpoints end. Before, in TAKEOFF and the HOLD that
follows, nothing of PX4's own would ever end the flight. The deadman starts this as a process of its own when the vehicle process,
and with it MAVSDK, is gone and the link is free; raw MAVLink, nothing of the app's state. A link that is silent is waited for:
nobody else will land that vehicle. Whatever mode is flown that the climb did not ask for is somebody's choice: then nothing is
commanded.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from enum import Enum
from typing import Any

from flightapp.core.clock import monotonic_ns

os.environ.setdefault("MAVLINK20", "1")

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

TIMEOUT_S = 900.0
"""As long as a battery lasts: who comes back later need not be landed any more."""
RETRY_S = 0.5
SILENCE_MAX_S = 5.0
"""Then the link is opened anew: one that the other side has closed stays silent for good."""
COMPANION = 191
"""MAVLink component id of an onboard computer."""
AUTO, TAKEOFF, LOITER, LAND = 4, 2, 3, 6
"""Main and sub modes of PX4."""


class Advice(Enum):
    """What the autopilot's heartbeat asks for."""

    LAND = "land"
    LANDS_ALREADY = "it lands"
    DISARMED = "it is disarmed"
    LEAVE_ALONE = "it flies a mode that the climb did not ask for; nothing was commanded"


def advice(base_mode: int, custom_mode: int) -> Advice:
    """Judge one heartbeat of PX4."""
    if not base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED:
        return Advice.DISARMED
    main, sub = custom_mode >> 16 & 0xFF, custom_mode >> 24 & 0xFF
    if main == AUTO and sub == LAND:
        return Advice.LANDS_ALREADY
    return Advice.LAND if main == AUTO and sub in (TAKEOFF, LOITER) else Advice.LEAVE_ALONE


def bring_down(url: str, system_id: int, timeout_s: float = TIMEOUT_S) -> str:
    """Command LAND over the MAVSDK `url` until the autopilot flies it; one sentence on how that went.

    A link that cannot be opened, breaks or is silent is tried again until `timeout_s` have passed.
    """
    give_up_ns = monotonic_ns() + round(timeout_s * 1e9)
    talk = _Talk(url, system_id)
    try:
        while monotonic_ns() < give_up_ns:
            told = talk.once()
            if told is not None and told is not Advice.LAND:
                return f"autopilot {system_id}: {told.value}"
        return f"autopilot {system_id}: {talk.found} within {timeout_s:g} s"
    finally:
        talk.close()


class _Talk:
    """What is said to and heard from one autopilot, and said of it where a person may read it."""

    def __init__(self, url: str, system_id: int) -> None:
        self._url, self._system_id = url, system_id
        self._link: Any = None
        self._heard_ns = 0
        self.found = ""
        """How far it has come."""

    def once(self) -> Advice | None:
        """Wait for one heartbeat, half a second at most, and answer it; None where there was none."""
        try:
            return self._answered()
        except OSError as error:
            self._say(f"{self._url} does not work: {error.strerror or error}")
            self.close()
            time.sleep(RETRY_S)
            return None

    def close(self) -> None:
        if self._link is not None:
            self._link.close()
            self._link = None

    def _answered(self) -> Advice | None:
        if self._link is None:
            self._link = _open(self._url, self._system_id)
            self._heard_ns = monotonic_ns()
        link = self._link
        link.mav.heartbeat_send(mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        heard = link.recv_match(type="HEARTBEAT", blocking=True, timeout=0.5)
        if heard is None or heard.get_srcSystem() != self._system_id or heard.autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            self._say(self.found or "not heard")
            if monotonic_ns() - self._heard_ns > SILENCE_MAX_S * 1e9:
                self.close()
            return None
        self._heard_ns = monotonic_ns()
        told = advice(heard.base_mode, heard.custom_mode)
        if told is Advice.LAND:
            self._say("LAND was commanded and not seen")
            link.mav.command_long_send(self._system_id, mavlink.MAV_COMP_ID_AUTOPILOT1, mavlink.MAV_CMD_NAV_LAND, 0, *(0.0,) * 7)
        return told

    def _say(self, found: str) -> None:
        """Once for each change."""
        if found != self.found:
            self.found = found
            sys.stderr.write(f"last resort: autopilot {self._system_id}: {found}; going on until it lands, Ctrl-C ends this\n")


def _open(url: str, system_id: int) -> Any:
    """A pymavlink connection for MAVSDK's `url`."""
    scheme, _, rest = url.partition("://")
    if scheme == "serial":
        device, _, baud = rest.rpartition(":")
        return mavutil.mavlink_connection(device, baud=int(baud), source_system=system_id, source_component=COMPANION)
    kind = {"tcpout": "tcp"}.get(scheme, scheme)
    return mavutil.mavlink_connection(f"{kind}:{rest}", source_system=system_id, source_component=COMPANION)


def main() -> None:
    """`python -m flightapp.vehicle.last_resort URL SYSTEM_ID`."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # The deadman passes it on; a terminal's Ctrl-C comes by itself.
    try:
        sentence = bring_down(sys.argv[1], int(sys.argv[2]))
    except KeyboardInterrupt:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.SIG_IGN)
        sentence = "ended by a person; nothing more is commanded"
    sys.stderr.write(f"last resort: {sentence}\n")


if __name__ == "__main__":
    main()
