"""What a fleet sends: bytes of each kind, cost of coding, and what its processes put on the wire as a full unicast mesh.

    .venv/bin/python tools/fleet_traffic.py --vehicles 10 --seconds 10
    .venv/bin/python tools/fleet_traffic.py --vehicles 10 --layout ring --secure

It tells what vehicles tell each other in a pursuit, by the code that does it in flight: states (StateTelling), intent, discs,
sightings by three that see the evader, a real election and its leader's plan, questions for the time, tokens. `chase`: all fly
the same way, 8 to 10 m apart, weaving; `ring`: the pursuers encircle the evader 3.2 m away or more, 2.3 m apart.

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
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import orjson
import psutil
import zenoh

from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock
from flightapp.core.types import Limits
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.coordination.plan import Plan, Seat
from flightapp.fleet.election.core import Election
from flightapp.fleet.election.timing import Timing
from flightapp.fleet.messages.codec import Header, Kind, decode, encode
from flightapp.fleet.messages.discs import DISCS, Disc, Discs
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.plan import PLAN
from flightapp.fleet.messages.sighting import SIGHTING, Sighting
from flightapp.fleet.messages.state import STATE, State
from flightapp.fleet.roster import Roster
from flightapp.fleet.security.access import Membership
from flightapp.fleet.security.credentials import load_credentials
from flightapp.fleet.security.keys import KeyWish, make_keys
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.state_rates import StateRates
from flightapp.fleet.team import Team
from flightapp.fleet.telling import BeaconTelling, StateTelling
from flightapp.runtime.team_rates import state_rates

DISCS_PERIOD_S = 1.0
DISCS_TOLD = 8
SIGHTING_PERIOD_S = 0.2
FIRST_PORT = 18_400
FLEET = "f"
READY_MAX_S = 90.0
TICK_S = 0.04
"""Of a control loop."""
SETTLED_S = 3.0
"""For the election, and the first quick questions for the time."""
BUDGET_KBIT_S = 1000.0
INTENT_NOW = Intent("pursuer", "0123456789ab", 2, "coarse", (21.5, -33.25, -5.0), 12.5, 23.4, 1.8, 0.034, ("obstacle_stop",))


SIGHTING_BY = 3
PLAN_PERIOD_S = 0.2
ROW, COLUMN_M, ROW_M, WEAVE_M, WEAVE_RAD_S = 3, 10.0, 8.0, 2.0, 0.7
RING_M, RING_GAP_M = 3.2, 2.3
SPEED_M_S = 4.0
HOST = "127.0.0.1"
PROFILE = Path(__file__).resolve().parents[1] / "profiles/sim.toml"


def state_at(t_s: float, number: int = 1, vehicles: int = 2, layout: str = "chase") -> State:
    """Vehicle 0 is the evader."""
    along_m = SPEED_M_S * (t_s % 100.0)
    if layout == "ring":
        radius_m = 0.0 if number == 0 else max(RING_M, RING_GAP_M * (vehicles - 1) / math.tau)
        turn = math.tau * number / max(1, vehicles - 1)
        position = (along_m + radius_m * math.cos(turn), radius_m * math.sin(turn), -5.02)
        velocity = (SPEED_M_S, 0.0, 0.05)
    else:
        phase = WEAVE_RAD_S * t_s + 1.7 * number
        position = (along_m - ROW_M * (number // ROW), COLUMN_M * (number % ROW) + WEAVE_M * math.sin(phase), -5.02)
        velocity = (SPEED_M_S, WEAVE_M * WEAVE_RAD_S * math.cos(phase), 0.05)
    return State(t_s - 0.013, position, velocity, 1.234, airborne=True, phase="pursue", outcome=None, due_s=0.2)


def discs_at(t_s: float) -> Discs:
    return Discs(t_s - 0.03, tuple(Disc(12.0 + k, -40.5 - k, 0.35, 0.0, 0.0) for k in range(DISCS_TOLD)))


def sighting_at(t_s: float) -> Sighting:
    return Sighting(t_s - 0.03, 21.5, -33.25, 0.7, 0.35, 0.06)


def plan_at(t_s: float, vehicles: int) -> Plan:
    seats = tuple(Seat(f"p{k}", 0.3 * k, 12.0, -40.0, t_s + 4.0) for k in range(1, vehicles))
    return Plan(1, 1 + round(t_s % 1e4), seats)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicles", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--member", type=int, default=None, help=argparse.SUPPRESS)
    parser.add_argument("--state-rate", type=float, default=20.0, help="network.state_rate_hz of the profile")
    parser.add_argument("--budget", type=float, default=BUDGET_KBIT_S, help="network.fleet_kbit_s_max of the profile")
    parser.add_argument("--layout", choices=("chase", "ring"), default="chase")
    parser.add_argument("--secure", action="store_true", help="QUIC with certificates that last as long as the run")
    parser.add_argument("--discs", action="store_true", help="network.share_discs of the profile: 8 a second from each pursuer")
    parser.add_argument("--keys", type=Path, default=None, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.member is not None:
        asyncio.run(fly(options.member, options))
        return
    if os.environ.get("FLEET_TRAFFIC_ALONE") is None:
        print_sizes()
        raise SystemExit(in_namespace())
    if not options.secure:
        print_wire(options, [])
        return
    names = tuple(name_of(number) for number in range(options.vehicles))
    with tempfile.TemporaryDirectory() as folder:
        keys = Path(folder) / "keys"
        make_keys(KeyWish(keys, FLEET, names, dict.fromkeys(names, (HOST,)), 1.0), SystemClock().now_s())
        print_wire(options, ["--keys", str(keys)])


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


def print_wire(options: argparse.Namespace, more: list[str]) -> None:
    vehicles, seconds = options.vehicles, options.seconds
    arguments = [sys.executable, __file__, "--vehicles", str(vehicles), "--seconds", str(seconds), "--layout", options.layout]
    arguments += ["--state-rate", str(options.state_rate), "--budget", str(options.budget), *more]
    arguments += ["--discs"] * options.discs
    processes = [
        subprocess.Popen([*arguments, "--member", str(number)], stdout=subprocess.PIPE, stdin=subprocess.PIPE)
        for number in range(vehicles)
    ]
    for process in processes:
        process.stdout.readline()
    time.sleep(SETTLED_S)
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
    verdict = "meets" if kbit_s <= options.budget else "does not meet"
    link = "quic" if options.secure else "udp"
    print(f"{vehicles} vehicles, {options.layout}, {link}, states at {options.state_rate:g} Hz: ", end="")
    print(f"{kbit_s:.0f} kbit/s and {packets_s:.0f} packets/s in all")
    print(f"a vehicle: {kbit_s / vehicles:.0f} kbit/s, {cpu * 100:.1f} % of a core; states are heard at {heard:.1f} Hz (mean)")
    print(f"clocks of one machine agree to {ahead_ms:.1f} ms; {verdict} {options.budget:g} kbit/s")


def name_of(number: int) -> str:
    return "e1" if number == 0 else f"p{number}"


def open_session(number: int, options: argparse.Namespace) -> zenoh.Session:
    protocol = "udp" if options.keys is None else "quic"
    endpoints = [f"{protocol}/{HOST}:{FIRST_PORT + k}" for k in range(options.vehicles)]
    names = tuple(map(name_of, range(options.vehicles)))
    membership = None
    if options.keys is not None:
        membership = Membership(FLEET, names, load_credentials(options.keys / names[number]))
    connect = [endpoint for k, endpoint in enumerate(endpoints) if k != number]
    return zenoh.open(zenoh_config([endpoints[number]], connect, wait_for_peers=False, membership=membership))


def rates_of(options: argparse.Namespace) -> StateRates:
    profile = load_profile(PROFILE)
    changes = {"state_rate_hz": options.state_rate, "fleet_kbit_s_max": options.budget, "certificates": options.keys}
    profile = profile.model_copy(update={"network": profile.network.model_copy(update=changes)})
    return state_rates(options.vehicles, profile, Limits(**profile.limits.model_dump()))


class Member:
    """One vehicle's part."""

    def __init__(self, number: int, options: argparse.Namespace) -> None:
        self._number, self._options = number, options
        self.session = open_session(number, options)
        self.clock = SystemClock()
        names = [name_of(k) for k in range(options.vehicles)]
        self.others = [name for name in names if name != name_of(number)]
        self.team = Team(self.session, FLEET, name_of(number), self.others, lambda *_: None)
        post = self.team.post
        self.watch, self._roster = ClockWatch(post, self.clock), Roster(post)
        self._telling = StateTelling(self.team, rates_of(options))
        self._discs, self._sightings = post.outlet(DISCS), post.outlet(SIGHTING)
        self._inlets = [post.inlet(DISCS), post.inlet(SIGHTING, depth=4)]
        self._due_s: dict[str, float] = {}
        self._election: Election | None = None
        if number > 0:
            pursuers, now_s = [name for name in names if name != name_of(0)], self.clock.now_s()
            self._election = Election(name_of(number), pursuers, Timing(), now_s, seed=number)
            self._beacons, self._beacons_in = BeaconTelling(post), post.inlet(ELECTION, depth=4, addressed=True)
            self._plans = post.outlet(PLAN)
            self._inlets.append(post.inlet(PLAN, depth=4))

    def tick(self, now_s: float) -> None:
        self.watch.poll(now_s)
        self._roster.poll()
        self.team.poll(now_s)
        for inlet in self._inlets:
            inlet.take(now_s)
        if self._election is not None:
            for beacon in self._election.step(now_s, self._beacons_in.take(now_s)):
                self._beacons.tell(beacon, now_s)
            if self._election.is_leader(now_s) and self._is_due("plan", PLAN_PERIOD_S, now_s):
                self._plans.put(plan_at(now_s, self._options.vehicles), now_s)
        if 0 < self._number <= SIGHTING_BY and self._is_due("sighting", SIGHTING_PERIOD_S, now_s):
            self._sightings.put(sighting_at(now_s), now_s)
        if self._options.discs and self._number > 0 and self._is_due("discs", DISCS_PERIOD_S, now_s):
            self._discs.put(discs_at(now_s), now_s)
        if self._is_due("state", 1.0 / self._options.state_rate, now_s):
            state = state_at(now_s, self._number, self._options.vehicles, self._options.layout)
            self._telling.tell(state, replace(INTENT_NOW, arrival_s=now_s + 4.2), now_s)

    def hears_all(self) -> bool:
        return len(self.watch.offsets) == len(self.others) and all(peer.state is not None for peer in self.team.peers.values())

    def _is_due(self, what: str, period_s: float, now_s: float) -> bool:
        due_s = self._due_s.get(what, now_s)
        if now_s < due_s:
            return False
        self._due_s[what] = max(due_s + period_s, now_s)
        return True


async def fly(number: int, options: argparse.Namespace) -> None:
    """Until `options.seconds` after standard input was closed."""
    member = Member(number, options)
    clock, team = member.clock, member.team
    asking = asyncio.create_task(member.watch.run())
    started = asyncio.get_running_loop().run_in_executor(None, sys.stdin.buffer.read)
    began_s: float | None = None
    cpu_s, taken, ready = 0.0, 0, False
    born_s = due_s = clock.now_s()
    while began_s is None or clock.now_s() < began_s + options.seconds:
        now_s = clock.now_s()
        member.tick(now_s)
        if not ready and member.hears_all():
            ready = True
            print("ready", flush=True)
        if began_s is None and started.done():
            began_s, cpu_s = now_s, time.process_time()
            taken = states_taken(team)
        if not ready and now_s > born_s + READY_MAX_S:
            raise SystemExit(f"{name_of(number)} does not hear everybody within {READY_MAX_S:g} s")
        due_s = max(due_s + TICK_S, now_s)
        await asyncio.sleep(max(0.0, due_s - clock.now_s()))
    asking.cancel()
    found = {
        "cpu_fraction": (time.process_time() - cpu_s) / options.seconds,
        "heard_hz": (states_taken(team) - taken) / options.seconds / len(member.others),
        "ahead_ms": max(abs(offset.ahead_s) for offset in member.watch.offsets.values()) * 1e3,
        "mb": psutil.Process().memory_info().rss / 1e6,
    }
    await asyncio.sleep(1.0)
    member.session.close()
    print(json.dumps(found), flush=True)


def states_taken(team: Team) -> int:
    return sum(peer.taken for peer in team.peers.values())


if __name__ == "__main__":
    main()
