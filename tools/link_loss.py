"""Which pairs of vehicles stay deaf to each other over a lossy link, by the kind of link; and how old the states are that arrive.

    sudo .venv/bin/python tools/link_loss.py --link udp --link quic --loss 0.1 --sessions 6

Three peers in network namespaces of their own (root and TUN are needed) send 20 Hz states for `--seconds`; 50 +- 25 ms, `--loss`
each way. A pair is deaf when its last state came more than 1.5 s before the end. `mixed` has a TCP and a UDP link at once.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.security.access import Membership
from flightapp.fleet.security.credentials import load_credentials
from flightapp.fleet.security.keys import KeyWish, make_keys
from flightapp.fleet.session import zenoh_config
from flightapp.sim.link_shaper import LinkQuality, LinkShaper
from flightapp.sim.network_campaign.real.namespaces import NamespaceSwitch

NAMES = ("p1", "p2", "p3")
FLEET = "f"
PORT = 7447
PERIOD_S = 0.05
DEAF_S = 1.5
LINKS = ("udp", "tcp", "mixed", "quic")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--link", action="append", choices=LINKS, help="udp and quic where it is not given")
    parser.add_argument("--loss", type=float, default=0.1)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--sessions", type=int, default=6)
    parser.add_argument("--member", nargs=4, metavar=("NAME", "LINK", "ADDRESSES", "KEYS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.member is not None:
        name, link, addresses, keys = options.member
        print(json.dumps(fly(name, link, json.loads(addresses), Path(keys), options.seconds)), flush=True)
        return
    print(f"{'link':<7}{'deaf pairs':>12}{'age median / 99 %':>24}")
    for link in options.link or ["udp", "quic"]:
        asyncio.run(judge(link, options))


async def judge(link: str, options: argparse.Namespace) -> None:
    deaf = pairs = 0
    ages_s: list[float] = []
    for session in range(options.sessions):
        for found in await run(link, session, options):
            pairs += len(found["last_s"])
            deaf += sum(last_s < options.seconds - DEAF_S for last_s in found["last_s"].values())
            ages_s += found["ages_s"]
    ages_s.sort()
    age = f"{ages_s[len(ages_s) // 2]:.2f} / {ages_s[len(ages_s) * 99 // 100]:.2f} s" if ages_s else "nothing heard"
    print(f"{link:<7}{f'{deaf} of {pairs}':>12}{age:>24}", flush=True)


async def run(link: str, session: int, options: argparse.Namespace) -> list[dict[str, Any]]:
    shaper = LinkShaper(LinkQuality(0.05, 0.025, options.loss), session)
    with tempfile.TemporaryDirectory() as folder, NamespaceSwitch(shaper, list(NAMES)) as switch:
        addresses = {name: switch.address(name) for name in NAMES}
        keys = Path(folder) / "keys"
        hosts = {name: (address,) for name, address in addresses.items()}
        make_keys(KeyWish(keys, FLEET, NAMES, hosts, 1.0), SystemClock().now_s())
        again = [sys.executable, __file__, "--seconds", str(options.seconds), "--member"]
        processes = [
            await asyncio.create_subprocess_exec(
                *switch.enter(name), *again, name, link, json.dumps(addresses), str(keys), stdout=asyncio.subprocess.PIPE
            )
            for name in NAMES
        ]
        return [json.loads((await process.communicate())[0]) for process in processes]


def fly(name: str, link: str, addresses: dict[str, str], keys: Path, seconds: float) -> dict[str, Any]:
    """When the last state of each other was heard, from the start, and the ages of all that were taken."""
    others = [other for other in NAMES if other != name]
    config = config_of(name, link, addresses, keys)
    with zenoh.open(config) as session:
        publisher = session.declare_publisher(
            f"flightapp/{FLEET}/{name}/state",
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
            reliability=zenoh.Reliability.BEST_EFFORT,
        )
        inlets = {
            other: session.declare_subscriber(f"flightapp/{FLEET}/{other}/state", zenoh.handlers.RingChannel(1))
            for other in others
        }
        last_s, ages_s = dict.fromkeys(others, 0.0), []
        began_s = time.monotonic()
        while (now_s := time.monotonic() - began_s) < seconds:
            publisher.put(json.dumps(time.time()).ljust(52).encode())
            time.sleep(PERIOD_S)
            for other, inlet in inlets.items():
                sample = inlet.handler.try_recv()
                if sample is not None:
                    last_s[other] = now_s
                    ages_s.append(time.time() - json.loads(sample.payload.to_bytes()))
    return {"last_s": last_s, "ages_s": ages_s}


def config_of(name: str, link: str, addresses: dict[str, str], keys: Path) -> zenoh.Config:
    def endpoints(host: str) -> list[str]:
        return [f"tcp/{host}:{PORT}?rel=1", f"udp/{host}:{PORT}?rel=0"] if link == "mixed" else [f"{link}/{host}:{PORT}"]

    connect = [endpoint for other, host in addresses.items() if other != name for endpoint in endpoints(host)]
    membership = Membership(FLEET, NAMES, load_credentials(keys / name)) if link == "quic" else None
    config = zenoh_config(endpoints(addresses[name]), connect, wait_for_peers=False, membership=membership)
    if link == "mixed":
        config.insert_json5("transport/unicast/max_links", "2")
    return config


if __name__ == "__main__":
    main()
