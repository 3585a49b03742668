"""What one simulated run needs on disk: free ports, shared-memory files, and a profile for each vehicle."""

from __future__ import annotations

import os
import random
import shutil
import socket
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil
import tomli_w

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.errors import FlightError

HOST = "127.0.0.1"
SHARED_PREFIX = "flightapp-"


@dataclass(frozen=True, slots=True)
class VehicleFiles:
    """Ports and files of one simulated vehicle."""

    vehicle: Vehicle
    mavlink_port: int
    fleet_port: int
    truth: Path
    camera: Path
    profile: Path
    """The profile as this vehicle flies it, written into the run folder."""
    certificates: Path | None = None
    """Its folder of `flightapp keys`."""

    @property
    def fleet_endpoint(self) -> str:
        return f"{'udp' if self.certificates is None else 'quic'}/{HOST}:{self.fleet_port}"


def shared_folder() -> Path:
    """A new folder in memory for the files that processes share; those of launchers that were killed are removed."""
    root = Path("/dev/shm") if Path("/dev/shm").is_dir() else Path(tempfile.gettempdir())
    for old in root.glob(f"{SHARED_PREFIX}*"):
        owner = old.name.removeprefix(SHARED_PREFIX).partition("-")[0]
        if owner.isdigit() and not psutil.pid_exists(int(owner)):
            shutil.rmtree(old, ignore_errors=True)
    return Path(tempfile.mkdtemp(prefix=f"{SHARED_PREFIX}{os.getpid()}-", dir=root))


class ReservedPorts:
    """UDP ports that nobody uses and no other run on this machine will choose while this object lives.

    They lie below the range from which the system gives ports to sockets that do not ask for one, so that the mocks' own
    sockets cannot take them. The UDP port itself must stay free for the vehicle; what is held is its TCP namesake.
    """

    FIRST, LAST = 20_000, 32_000

    def __init__(self, count: int) -> None:
        self._held: list[socket.socket] = []
        self.numbers: list[int] = []
        candidates = random.SystemRandom().sample(range(self.FIRST, self.LAST), self.LAST - self.FIRST)
        for port in candidates:
            if len(self.numbers) == count:
                return
            if self._hold(port):
                self.numbers.append(port)
        self.release()
        raise FlightError(f"no {count} free UDP ports between {self.FIRST} and {self.LAST} on {HOST}")

    def release(self) -> None:
        for each in self._held:
            each.close()
        self._held.clear()

    def _hold(self, port: int) -> bool:
        reservation = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            reservation.bind((HOST, port))
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind((HOST, port))
        except OSError:
            reservation.close()
            return False
        self._held.append(reservation)
        return True


def prepare(
    mission: Mission, profile: Profile, run: Path, shared: Path, ports: Sequence[int], keys: Path | None = None
) -> list[VehicleFiles]:
    """Write each vehicle's profile: the given one with the links of this run filled in. Takes two ports a vehicle.

    keys: folder of `flightapp keys` for this mission's vehicles; None: an open fleet.
    """
    files = [
        VehicleFiles(
            vehicle,
            ports[2 * index],
            ports[2 * index + 1],
            shared / f"{vehicle.name}.truth",
            shared / f"{vehicle.name}.depth",
            run / f"profile-{vehicle.name}.toml",
            None if keys is None else (keys / vehicle.name).resolve(),
        )
        for index, vehicle in enumerate(mission.vehicles)
    ]
    for own in files:
        others = [other.fleet_endpoint for other in files if other is not own]
        own.profile.write_text(tomli_w.dumps(_resolved(profile, own, others)))
    return files


def _resolved(profile: Profile, own: VehicleFiles, others: list[str]) -> dict[str, object]:
    tables = profile.model_dump(mode="json", exclude_none=True)
    tables["autopilot"]["connection_url"] = f"udpin://{HOST}:{own.mavlink_port}"
    tables["network"]["listen_endpoints"] = [own.fleet_endpoint]
    tables["network"]["connect_endpoints"] = others
    tables["network"].pop("certificates", None)
    if own.certificates is not None:
        tables["network"]["certificates"] = str(own.certificates)
    tables["camera"]["source"] = "shared-memory" if own.vehicle.camera else "none"
    tables["camera"]["path"] = str(own.camera)
    return dict(tables)
