"""One real flight over one kind of network; a process of its own, which is put into a network namespace of its own."""

from __future__ import annotations

import argparse
import asyncio
from pathlib import Path

from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import load_profile
from flightapp.sim.fleet_keys import temporary_keys
from flightapp.sim.link_shaper import LinkQuality, LinkShaper
from flightapp.sim.network_campaign.conditions import side_of
from flightapp.sim.network_campaign.observer import SPLIT_AFTER_S, SPLIT_FOR_S
from flightapp.sim.network_campaign.real.launcher import NamespaceWiring, ProxyWiring, WiredLauncher, Wiring
from flightapp.sim.network_campaign.real.namespaces import NamespaceSwitch
from flightapp.sim.network_campaign.real.udp_proxy import UdpProxy
from flightapp.sim.progress import Progress

POLL_S = 0.1


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m flightapp.sim.network_campaign.real", description=__doc__)
    parser.add_argument("mission", type=Path)
    parser.add_argument("profile", type=Path)
    parser.add_argument("run", type=Path, help="New folder, which must exist.")
    parser.add_argument("--delay-ms", type=float, default=5.0)
    parser.add_argument("--jitter-ms", type=float, default=0.0)
    parser.add_argument("--loss-percent", type=float, default=0.0)
    parser.add_argument("--partition", choices=("none", "one", "halves"), default="none")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--namespaces", action="store_true", help="In namespaces, instead of through the proxy.")
    asyncio.run(_fly(parser.parse_args()))


async def _fly(options: argparse.Namespace) -> None:
    mission = load_mission(options.mission)
    quality = LinkQuality(options.delay_ms * 1e-3, options.jitter_ms * 1e-3, options.loss_percent * 1e-2)
    shaper = LinkShaper(quality, options.seed)
    splitting = asyncio.create_task(_split_and_heal(shaper, mission, options.partition, options.run))
    if options.namespaces:
        with NamespaceSwitch(shaper, [vehicle.name for vehicle in mission.vehicles]) as switch:
            await _launch(mission, NamespaceWiring(switch), options)
    else:
        proxy = UdpProxy(shaper)
        try:
            await _launch(mission, ProxyWiring(proxy), options)
        finally:
            proxy.close()
    splitting.cancel()


async def _launch(mission: Mission, wiring: Wiring, options: argparse.Namespace) -> None:
    profile, run = load_profile(options.profile), options.run
    hosts = wiring.hosts([vehicle.name for vehicle in mission.vehicles])
    with temporary_keys(mission, hosts) as keys, Progress(mission.name) as progress:
        launcher = WiredLauncher(mission, profile, options.mission, run, options.seed, progress, keys)
        launcher.wiring = wiring
        await launcher.run()


async def _split_and_heal(shaper: LinkShaper, mission: Mission, partition: str, run: Path) -> None:
    names = {role: [one.name for one in mission.vehicles if one.role == role] for role in ("pursuer", "evader")}
    while not all(_pursues(run / f"{name}.log") for name in names["pursuer"]):
        await asyncio.sleep(POLL_S)
    await asyncio.sleep(SPLIT_AFTER_S)
    shaper.split(side_of("one" if partition == "one" else "halves" if partition == "halves" else "none", *names.values()))
    await asyncio.sleep(SPLIT_FOR_S)
    shaper.heal()


def _pursues(log: Path) -> bool:
    return log.exists() and "phase pursue" in log.read_text(errors="replace")


if __name__ == "__main__":
    main()
