"""From a URL to the one autopilot behind it: open the link, try again while it is absent, find the vehicle by its system id."""

from __future__ import annotations

import asyncio
import logging
import socket
from typing import Any

import mavsdk
from mavsdk import logging as mavsdk_logging
from mavsdk.exceptions import ConnectionError as LinkError

from flightapp.config.profile import Autopilot as AutopilotConfig
from flightapp.core.clock import Clock
from flightapp.core.errors import FlightError

COMPANION_COMPONENT_ID = 191
RETRY_PERIOD_S = 0.5
"""A flight controller that is plugged in shows up as a serial device within seconds."""
FIND_PERIOD_S = 0.05
PROBE_TIMEOUT_S = 1.0
REMEDIES = {
    "serial": "is the autopilot powered and plugged in, may this user open the device (group dialout), is the rate the port's?",
    "udpin": "does the autopilot send MAVLink to this port, and does no other program listen on it?",
    "udpout": "does the autopilot listen there?",
    "tcpin": "does the autopilot connect to this port?",
    "tcpout": "does the autopilot, or the radio in between, listen there?",
}


class Connection:
    """One MAVSDK instance for one vehicle: several vehicles on one instance would each get every setpoint."""

    def __init__(self, config: AutopilotConfig, system_id: int, clock: Clock) -> None:
        self._config = config
        self._system_id = system_id
        self._clock = clock
        self._mavsdk: Any = None
        self._log = logging.getLogger(f"autopilot {system_id}")

    async def open(self) -> Any:
        """MAVSDK's system for the autopilot; FlightError after `connect_timeout_s` with what was tried and heard."""
        mavsdk_logging.log_subscribe(lambda _level, _message, _file, _line: True)
        configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.COMPANION_COMPUTER)
        configuration.system_id = self._system_id
        configuration.component_id = COMPANION_COMPONENT_ID
        self._mavsdk = mavsdk.Mavsdk(configuration)
        deadline_s = self._clock.now_s() + self._config.connect_timeout_s
        await self._open_link(deadline_s)
        return await self._find_system(deadline_s)

    def system_ids_heard(self) -> tuple[int, ...]:
        """Every MAVLink system on the link."""
        return tuple(sorted({system.get_system_id() for system in self._mavsdk.get_systems()}))

    def close(self) -> None:
        """End the instance and with it its own repeats of the last setpoint."""
        if self._mavsdk is not None:
            self._mavsdk.destroy()
            self._mavsdk = None

    async def _open_link(self, deadline_s: float) -> None:
        """A serial device that is absent is refused at once, so it is tried again; TCP is tried again by MAVSDK itself."""
        url, told = self._config.connection_url, False
        while True:
            try:
                self._mavsdk.add_any_connection_with_handle(url)
                return
            except LinkError as error:
                if not told:
                    told = True
                    wait_s = self._config.connect_timeout_s
                    self._log.warning("'%s' is not there (%s); trying again for %g s", url, error, wait_s)
                if self._clock.now_s() > deadline_s:
                    raise self._failure(f"cannot be opened ({error})") from None
            await asyncio.sleep(RETRY_PERIOD_S)

    async def _find_system(self, deadline_s: float) -> Any:
        """The autopilot with the mission's system id; other vehicles on the same link are not touched."""
        while self._clock.now_s() < deadline_s:
            for system in self._mavsdk.get_systems():
                if system.has_autopilot() and system.get_system_id() == self._system_id:
                    return system
            await asyncio.sleep(FIND_PERIOD_S)
        heard = self.system_ids_heard()
        if heard:
            raise FlightError(
                f"no autopilot with system id {self._system_id} on '{self._config.connection_url}' within "
                f"{self._config.connect_timeout_s:g} s; heard system ids {list(heard)}: MAV_SYS_ID and the mission's "
                "system_id must be the same"
            )
        raise self._failure(await self._silence())

    async def _silence(self) -> str:
        """Why nothing was heard; for TCP, where MAVSDK keeps a refused connection to itself, it is asked for."""
        scheme, _, address = self._config.connection_url.partition("://")
        if scheme != "tcpout":
            return "heard nothing at all"
        host, _, port = address.rpartition(":")
        try:
            await asyncio.to_thread(_probe, host, int(port))
        except OSError as error:
            return f"nothing answers at {address} ({error.strerror or error})"
        return "it accepts connections, but no MAVLink was heard"

    def _failure(self, found: str) -> FlightError:
        url, timeout_s = self._config.connection_url, self._config.connect_timeout_s
        remedy = REMEDIES[url.partition("://")[0]]
        return FlightError(
            f"autopilot link '{url}': {found} within {timeout_s:g} s; {remedy} (autopilot.connection_url in the profile)"
        )


def _probe(host: str, port: int) -> None:
    socket.create_connection((host, port), timeout=PROBE_TIMEOUT_S).close()
