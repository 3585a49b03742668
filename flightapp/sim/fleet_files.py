"""What one simulated run needs on disk: free ports, shared-memory files, and a profile for each vehicle."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from pathlib import Path

import tomli_w

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile

HOST = "127.0.0.1"


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

    @property
    def fleet_endpoint(self) -> str:
        return f"udp/{HOST}:{self.fleet_port}"


def free_udp_ports(count: int) -> list[int]:
    """`count` different UDP ports that nobody uses, held until all are known."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    try:
        for each in sockets:
            each.bind((HOST, 0))
        return [int(each.getsockname()[1]) for each in sockets]
    finally:
        for each in sockets:
            each.close()


def prepare(mission: Mission, profile: Profile, run: Path, shared: Path) -> list[VehicleFiles]:
    """Choose ports and write each vehicle's profile: the given one with the links of this run filled in."""
    ports = free_udp_ports(2 * len(mission.vehicles))
    files = [
        VehicleFiles(
            vehicle,
            ports[2 * index],
            ports[2 * index + 1],
            shared / f"{vehicle.name}.truth",
            shared / f"{vehicle.name}.depth",
            run / f"profile-{vehicle.name}.toml",
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
    tables["camera"]["source"] = "shared-memory" if own.vehicle.camera else "none"
    tables["camera"]["path"] = str(own.camera)
    return dict(tables)
