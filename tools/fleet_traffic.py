"""What a fleet sends: bytes of each kind, cost of coding, and what its processes put on the wire as a full unicast mesh.

    .venv/bin/python tools/fleet_traffic.py --vehicles 10 --seconds 10

Every vehicle is a process with a real Zenoh session, all of them in a network namespace of this run where the machine allows it:
then the interface's own counters tell all bytes on the wire, UDP and IP headers, keep-alives and acknowledgements included. Each
packet counts once for every receiver, as on a radio that sends to each of them. Zenoh's UDP multicast between peers is not
offered: with 1.10 and the fleet's lease of 1.5 s receivers fell silent for good, and it carries neither questions nor tokens.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import orjson
import psutil
import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.messages.codec import Header, Kind, decode, encode
from flightapp.fleet.messages.discs import DISCS, Disc, Discs
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.sighting import SIGHTING, Sighting
from flightapp.fleet.messages.state import STATE, State
from flightapp.fleet.roster import Roster
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team

DISCS_PERIOD_S = 0.5
SIGHTING_PERIOD_S = 0.2
FIRST_PORT = 18_400
BUDGET_KBIT_S = 1000.0
INTENT_NOW = Intent("pursuer", "0123456789ab", 2, "coarse", (21.5, -33.25, -5.0), 12.5, 23.4, 1.8, 0.034, ("obstacle_stop",))


def state_at(t_s: float) -> State:
    return State(t_s - 0.013, (12.34, -123.45, -5.02), (4.12, -2.21, 0.05), 1.234, airborne=True, phase="pursue", outcome=None)


def discs_at(t_s: float) -> Discs:
    return Discs(t_s - 0.03, tuple(Disc(12.0 + k, -40.5 - k, 0.35, 0.0, 0.0) for k in range(12)))


def sighting_at(t_s: float) -> Sighting:
    return Sighting(t_s - 0.03, 21.5, -33.25, 0.7, 0.35, 0.06)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicles", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--member", type=int, default=None, help=argparse.SUPPRESS)
    parser.add_argument("--state-rate", type=float, default=20.0, help="network.state_rate_hz of the profile")
    options = parser.parse_args()
    if options.member is not None:
        asyncio.run(fly(options.member, options.vehicles, options.seconds, 1.0 / options.state_rate))
        return
    if os.environ.get("FLEET_TRAFFIC_ALONE") is None:
        print_sizes()
        raise SystemExit(in_namespace())
    print_wire(options.vehicles, options.seconds, options.state_rate)


def print_sizes() -> None:
    print(f"{'kind':<10}{'bytes':>7}{'JSON':>7}{'encode us':>11}{'decode us':>11}")
    for kind, message in (
        (STATE, state_at(1.7e9)),
        (INTENT, replace(INTENT_NOW, arrival_s=1.7e9 + 4.2)),
        (SIGHTING, sighting_at(1.7e9)),
        (DISCS, discs_at(1.7e9)),
    ):
        print_size(kind, message)


def print_size(kind: Kind[Any, Any], message: object) -> None:
    header = Header("p1", 100_000, 1.7e9)
    payload = encode(kind, message, header)
    as_json = orjson.dumps({"version": 1, "vehicle": "p1", "sequence": 100_000, "sent_s": 1.7e9 + 0.123456, **as_fields(message)})
    encoded_us, decoded_us = cost_us(lambda: encode(kind, message, header)), cost_us(lambda: decode(kind, payload))
    print(f"{kind.name:<10}{len(payload):>7}{len(as_json):>7}{encoded_us:>11.1f}{decoded_us:>11.1f}")


def as_fields(message: object) -> dict[str, object]:
    return orjson.loads(orjson.dumps(message))


def cost_us(call: Callable[[], object], count: int = 5000) -> float:
    best = math.inf
    for _ in range(5):
        began = time.perf_counter()
        for _ in range(count):
            call()
        best = min(best, (time.perf_counter() - began) / count)
    return best * 1e6


def in_namespace() -> int:
    """This again where nobody else uses the loopback interface; its exit status."""
    again = [sys.executable, *sys.argv]
    alone = 'ip link set lo up && exec "$@"'
    environment = {**os.environ, "FLEET_TRAFFIC_ALONE": "1"}
    if subprocess.run(["unshare", "--net", "true"], check=False, stderr=subprocess.DEVNULL).returncode == 0:
        return subprocess.run(["unshare", "--net", "sh", "-c", alone, "sh", *again], check=False, env=environment).returncode
    print("no network namespace on this machine: other traffic on the loopback interface is counted as well")
    return subprocess.run(again, check=False, env=environment).returncode


def print_wire(vehicles: int, seconds: float, state_rate_hz: float) -> None:
    arguments = [sys.executable, __file__, "--vehicles", str(vehicles), "--seconds", str(seconds)]
    arguments += ["--state-rate", str(state_rate_hz)]
    processes = [
        subprocess.Popen([*arguments, "--member", str(number)], stdout=subprocess.PIPE, stdin=subprocess.PIPE)
        for number in range(vehicles)
    ]
    for process in processes:
        process.stdout.readline()
    before, began = psutil.net_io_counters(pernic=True)["lo"], time.monotonic()
    for process in processes:
        process.stdin.close()
    time.sleep(seconds)
    after, took_s = psutil.net_io_counters(pernic=True)["lo"], time.monotonic() - began
    told = [json.loads(process.stdout.read()) for process in processes]
    for process in processes:
        process.wait()
    kbit_s = (after.bytes_sent - before.bytes_sent) * 8e-3 / took_s
    packets_s = (after.packets_sent - before.packets_sent) / took_s
    cpu = sum(one["cpu_fraction"] for one in told) / vehicles
    heard = sum(one["heard_hz"] for one in told) / vehicles
    ahead_ms = max(one["ahead_ms"] for one in told)
    verdict = "meets" if kbit_s <= BUDGET_KBIT_S else "does not meet"
    print(f"{vehicles} vehicles, states at {state_rate_hz:g} Hz: {kbit_s:.0f} kbit/s and {packets_s:.0f} packets/s in all")
    print(f"a vehicle: {kbit_s / vehicles:.0f} kbit/s, {cpu * 100:.1f} % of a core; each state is heard at {heard:.1f} Hz")
    print(f"clocks of one machine agree to {ahead_ms:.1f} ms; {verdict} 1 Mbit/s")


async def fly(number: int, vehicles: int, seconds: float, state_period_s: float) -> None:
    """One vehicle's part: state, intent, discs 2 Hz, sightings 5 Hz, questions for the time, tokens."""
    endpoints = [f"udp/127.0.0.1:{FIRST_PORT + k}" for k in range(vehicles)]
    others = [f"p{k}" for k in range(vehicles) if k != number]
    connect = [endpoint for k, endpoint in enumerate(endpoints) if k != number]
    session = zenoh.open(zenoh_config([endpoints[number]], connect, wait_for_peers=False))
    clock = SystemClock()
    team = Team(session, "f", f"p{number}", others, lambda *_: None)
    watch, roster = ClockWatch(team.post, clock), Roster(team.post)
    shared, seen = team.post.outlet(DISCS), team.post.outlet(SIGHTING)
    inlets = team.post.inlet(DISCS), team.post.inlet(SIGHTING, depth=4)
    asking = asyncio.create_task(watch.run())
    started = asyncio.get_running_loop().run_in_executor(None, sys.stdin.buffer.read)
    discs_s = sighting_s = 0.0
    began_s: float | None = None
    cpu_s = 0.0
    taken = 0
    ready = False
    due_s = clock.now_s()
    while began_s is None or clock.now_s() < began_s + seconds:
        now_s = clock.now_s()
        watch.poll(now_s)
        roster.poll()
        team.poll(now_s)
        for inlet in inlets:
            inlet.take(now_s)
        team.publish(state_at(now_s), replace(INTENT_NOW, arrival_s=now_s + 4.2), now_s)
        if now_s - discs_s >= DISCS_PERIOD_S:
            discs_s = now_s
            shared.put(discs_at(now_s), now_s)
        if now_s - sighting_s >= SIGHTING_PERIOD_S:
            sighting_s = now_s
            seen.put(sighting_at(now_s), now_s)
        if not ready and len(watch.offsets) == len(others) and all(peer.state is not None for peer in team.peers.values()):
            ready = True
            print("ready", flush=True)
        if began_s is None and started.done():
            began_s, cpu_s = now_s, time.process_time()
            taken = states_taken(team)
        due_s += state_period_s
        await asyncio.sleep(max(0.0, due_s - clock.now_s()))
    asking.cancel()
    found = {
        "cpu_fraction": (time.process_time() - cpu_s) / seconds,
        "heard_hz": (states_taken(team) - taken) / seconds / len(others),
        "ahead_ms": max(abs(offset.ahead_s) for offset in watch.offsets.values()) * 1e3,
    }
    await asyncio.sleep(1.0)
    session.close()
    print(json.dumps(found), flush=True)


def states_taken(team: Team) -> int:
    return sum(peer.taken for peer in team.peers.values())


if __name__ == "__main__":
    main()
