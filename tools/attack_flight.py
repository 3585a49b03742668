"""Flies a closed fleet in real time twice, left alone and under attack, and tells what was refused and what the attack changed.

    .venv/bin/python tools/attack_flight.py

Each flight is a `flightapp sim --certificates KEYS` of its own: real MAVLink and Zenoh, every vehicle its own process. Attackers
from the arming on until the end, all connected to every vehicle:

member      the certificate of p2 and no manners: states in p1's and e1's name, noise of up to 5000 bytes under every key, its own
            included, recorded operator commands (land, hold) with the recorded stamps
stranger    an operator's certificate of another authority
plain peer  no certificate, UDP
operator    the real one, sending a `hold` that is a minute old

Exit status 0 if the attacked flight ends like the other, every kind of refusal is on record, and nobody obeyed a command.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson
import zenoh

from flightapp.config.mission import Mission, load_mission
from flightapp.core.clock import SystemClock
from flightapp.fleet.messages.codec import Header, encode
from flightapp.fleet.messages.command import Command, decode_acknowledgement, encode_command
from flightapp.fleet.messages.keys import COMMAND, key
from flightapp.fleet.messages.state import STATE, State
from flightapp.fleet.security.access import OPERATOR, membership_of
from flightapp.fleet.session import zenoh_config
from flightapp.recording.reader import read_recording
from flightapp.sim.fleet_keys import temporary_keys

HOST = ("127.0.0.1",)
LIAR = "p2"
PERIOD_S = 0.02
COMMANDS_EVERY = 25
NOISE_BYTES = (0, 3, 40, 200, 900, 5000)
OLD_S = 60.0
START_TIMEOUT_S = 120.0
EXPECTED = (f"'{LIAR}' may not put on", f"'{LIAR}' may not query on", "a connection without a valid certificate")


@dataclass(frozen=True, slots=True)
class Flight:
    """What became of one flight."""

    outcome: str
    capture_time_s: float | None
    setpoint_gap_max_ms: float
    setpoint_gap_p99_ms: float
    cpu_mean: float
    refused: tuple[str, ...]
    """Sentences of all recordings, with the vehicle's name."""
    obeyed: tuple[str, ...]
    sent: int
    """By the attackers."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mission", type=Path, default=Path("missions/demo_two_pursuers.toml"))
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="attack-flight-") as folder:
        calm = fly(given.mission, Path(folder) / "calm", given.seed, attacked=False)
        told("left alone", calm)
        attacked = fly(given.mission, Path(folder) / "attacked", given.seed, attacked=True)
        told("under attack", attacked)
    for sentence in attacked.refused:
        print(f"  {sentence}")
    missing = [text for text in EXPECTED if not any(text in sentence for sentence in attacked.refused)]
    wrong = [f"not on record: {text}" for text in missing] + [f"OBEYED: {text}" for text in attacked.obeyed]
    wrong += [f"ended {attacked.outcome} instead of {calm.outcome}"] if attacked.outcome != calm.outcome else []
    print("verdict: " + ("; ".join(wrong) if wrong else "refused, recorded, flight unaffected"))
    return 1 if wrong else 0


def told(name: str, flight: Flight) -> None:
    after = "" if flight.capture_time_s is None else f" after {flight.capture_time_s:.2f} s"
    print(
        f"{name}: {flight.outcome}{after}, setpoint gap p99 {flight.setpoint_gap_p99_ms:.1f} ms, largest "
        f"{flight.setpoint_gap_max_ms:.1f} ms, {flight.cpu_mean:.2f} of a core a vehicle, {flight.sent} messages of attackers",
        flush=True,
    )


def fly(mission_path: Path, run: Path, seed: int, *, attacked: bool) -> Flight:
    mission = load_mission(mission_path)
    names = [vehicle.name for vehicle in mission.vehicles]
    hosts = dict.fromkeys(names, HOST)
    with temporary_keys(mission, hosts) as keys, temporary_keys(mission, hosts) as foreign:
        command = [sys.executable, "-m", "flightapp", "sim", str(mission_path), "--certificates", str(keys)]
        command += ["--run", str(run), "--seed", str(seed), "--json"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as launcher:
            try:
                _wait_for_arming(launcher, run, names)
                sent = _attack(launcher, mission, _endpoints(run, names), keys, foreign) if attacked else 0
                summary = orjson.loads(launcher.communicate()[0])
            finally:
                launcher.terminate()
    return _judged(run, names, summary, sent)


def _wait_for_arming(launcher: subprocess.Popen[bytes], run: Path, names: list[str]) -> None:
    deadline_s = time.monotonic() + START_TIMEOUT_S
    logs = [run / f"{name}.log" for name in names]
    while not all(log.exists() and "phase arm" in log.read_text(errors="replace") for log in logs):
        if launcher.poll() is not None or time.monotonic() > deadline_s:
            raise RuntimeError(f"the vehicles do not arm: {[log.read_text()[-200:] for log in logs if log.exists()]}")
        time.sleep(PERIOD_S)


def _endpoints(run: Path, names: list[str]) -> list[str]:
    """Where all vehicles listen, by the profiles of the run."""
    return [
        endpoint
        for name in names
        for endpoint in tomllib.loads((run / f"profile-{name}.toml").read_text())["network"]["listen_endpoints"]
    ]


def _attack(launcher: subprocess.Popen[bytes], mission: Mission, endpoints: list[str], keys: Path, foreign: Path) -> int:
    """Until the simulation has ended; how many messages were sent."""
    clock, fleet = SystemClock(), mission.fleet
    recorded = {
        action: encode_command(Command(action, f"recorded {action}", clock.now_s(), "ann@tower")) for action in ("land", "hold")
    }
    with _sessions(mission, endpoints, keys, foreign) as (member, stranger, plain, operator):
        places = (key(fleet, "p1", "state"), key(fleet, "e1", "state"), key(fleet, LIAR, "state"), f"flightapp/{fleet}/**")
        lies = [member.declare_publisher(place) for place in places]
        others = [session.declare_publisher(places[0]) for session in (stranger, plain)]
        sent = 0
        while launcher.poll() is None:
            now_s = clock.now_s()
            state = State(now_s, (999.0, 0.0, -5.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome="aborted")
            lies[0].put(encode(STATE, state, Header("p1", 1_000_000 + sent, now_s)))
            lies[1].put(encode(STATE, state, Header("e1", 1_000_000 + sent, now_s)))
            for publisher in (*lies, *others):
                publisher.put(random.randbytes(random.choice(NOISE_BYTES)))
            if sent // 8 % COMMANDS_EVERY == 0:
                for session in (member, stranger, plain):
                    for payload in recorded.values():
                        session.get(f"flightapp/{fleet}/*/{COMMAND}", payload=payload, timeout=0.2)
                _send_old_hold(operator, fleet, now_s)
            sent += 8
            time.sleep(PERIOD_S)
    return sent


def _send_old_hold(operator: zenoh.Session, fleet: str, now_s: float) -> None:
    """Nobody may obey it; what would be obeyed is found in the recordings."""
    old = encode_command(Command("hold", f"old {now_s}", now_s - OLD_S, "ann@tower"))
    for reply in operator.get(key(fleet, "p1", COMMAND), payload=old, timeout=0.3):
        if reply.ok is not None and decode_acknowledgement(reply.ok.payload.to_bytes()).accepted:
            print("an old command was accepted", file=sys.stderr)


@contextlib.contextmanager
def _sessions(mission: Mission, endpoints: list[str], keys: Path, foreign: Path) -> Iterator[tuple[zenoh.Session, ...]]:
    """Of the member, the stranger, the plain peer and the operator."""
    member = membership_of(mission, keys / LIAR, access_control=False)
    stranger = membership_of(mission, foreign / OPERATOR, access_control=False)
    operator = membership_of(mission, keys / OPERATOR)
    plain = [endpoint.replace("quic/", "udp/") for endpoint in endpoints]
    wanted = ((endpoints, member), (endpoints, stranger), (plain, None), (endpoints, operator))
    sessions = [zenoh.open(zenoh_config([], at, wait_for_peers=False, membership=who)) for at, who in wanted]
    try:
        yield tuple(sessions)
    finally:
        for session in sessions:
            session.close()


def _judged(run: Path, names: list[str], summary: dict[str, Any], sent: int) -> Flight:
    refused, obeyed = [], []
    for name in names:
        for event in read_recording(run / f"{name}.mcap").topic("/event").messages:
            if event["text"].startswith("refused: ") or "at most" in event["text"]:
                refused.append(f"{name}: {event['text']}")
            elif event["name"] == "command" and " accepted: " in event["text"]:
                obeyed.append(f"{name}: {event['text']}")
    return Flight(
        summary["outcome"],
        summary["capture_time_s"],
        summary["setpoint_gap_max_ms"],
        summary["setpoint_gap_p99_ms"],
        sum(one["cpu_fraction"]["mean"] for one in summary["vehicles"].values()) / len(names),
        tuple(dict.fromkeys(refused)),
        tuple(obeyed),
        sent,
    )


if __name__ == "__main__":
    sys.exit(main())
