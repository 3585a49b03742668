"""`flightapp sim`'s launcher, with a bad network between the vehicle processes."""

from __future__ import annotations

import tomllib
from abc import ABC, abstractmethod
from collections.abc import Sequence

import tomli_w

from flightapp.sim.fleet_files import HOST, VehicleFiles
from flightapp.sim.launcher import Launcher
from flightapp.sim.network_campaign.real.namespaces import NamespaceSwitch
from flightapp.sim.network_campaign.real.udp_proxy import UdpProxy


class Wiring(ABC):
    """How vehicle processes reach one another: over QUIC, as a radio needs it. Plain UDP leaves vehicles deaf under loss."""

    @abstractmethod
    def hosts(self, vehicles: Sequence[str]) -> dict[str, tuple[str, ...]]:
        """Under which addresses each of `vehicles` is reached."""

    @abstractmethod
    def listen(self, own: VehicleFiles) -> str:
        """Endpoint on which a vehicle listens."""

    @abstractmethod
    def connect(self, own: VehicleFiles, other: VehicleFiles) -> str:
        """Endpoint under which `own` reaches `other`."""

    def enter(self, vehicle: str) -> list[str]:  # noqa: ARG002
        """What to write before the commands of a vehicle's processes."""
        return []


class ProxyWiring(Wiring):
    def __init__(self, proxy: UdpProxy) -> None:
        self._proxy = proxy

    def hosts(self, vehicles: Sequence[str]) -> dict[str, tuple[str, ...]]:
        return dict.fromkeys(vehicles, (HOST,))

    def listen(self, own: VehicleFiles) -> str:
        return own.fleet_endpoint

    def connect(self, own: VehicleFiles, other: VehicleFiles) -> str:
        return f"quic/{HOST}:{self._proxy.through(own.vehicle.name, other.vehicle.name, other.fleet_port)}"


class NamespaceWiring(Wiring):
    """The launcher's own session, which only shows progress, reaches nobody."""

    def __init__(self, switch: NamespaceSwitch) -> None:
        self._switch = switch

    def hosts(self, vehicles: Sequence[str]) -> dict[str, tuple[str, ...]]:
        return {vehicle: (self._switch.address(vehicle),) for vehicle in vehicles}

    def listen(self, own: VehicleFiles) -> str:
        return f"quic/{self._switch.address(own.vehicle.name)}:{own.fleet_port}"

    def connect(self, own: VehicleFiles, other: VehicleFiles) -> str:  # noqa: ARG002
        return self.listen(other)

    def enter(self, vehicle: str) -> list[str]:
        return self._switch.enter(vehicle)


class WiredLauncher(Launcher):
    """Set `wiring` before `run`."""

    wiring: Wiring

    async def _start(self, files: list[VehicleFiles]) -> None:
        for own in files:
            tables = tomllib.loads(own.profile.read_text())
            tables["network"]["listen_endpoints"] = [self.wiring.listen(own)]
            tables["network"]["connect_endpoints"] = [self.wiring.connect(own, other) for other in files if other is not own]
            own.profile.write_text(tomli_w.dumps(tables))
        await super()._start(files)

    def _command(self, name: str, arguments: list[str]) -> list[str]:
        """`name` is that of a vehicle, or begins with it."""
        vehicle = max((one.name for one in self._mission.vehicles if f"{name}-".startswith(f"{one.name}-")), key=len)
        return [*self.wiring.enter(vehicle), *super()._command(name, arguments)]
