"""A teammate's process is killed, frozen and continued: how soon the others notice, and whose clock is how wrong."""

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh

from flightapp.config.profile import Network, load_profile
from flightapp.core.clock import SystemClock
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.roster import Roster
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team
from flightapp.runtime.teamwork import Teamwork
from flightapp.safety.parameters import SafetyParameters
from flightapp.sim.fleet_files import ReservedPorts

AHEAD_S = 30.0
POLL_S = 0.01
DEADLINE_S = 90.0
LEASE_S = 1.5
SLACK_S = 1.0
"""For a machine that does other things as well."""


@dataclass
class Events:
    """The journal's part that is used here."""

    heard: list[tuple[str, str]] = field(default_factory=list)

    def event(self, _level: str, name: str, _text: str, **data: object) -> None:
        self.heard.append((name, str(data.get("peer"))))


class Watching:
    """Vehicle p1 in this process; p2 is a process of its own, whose clock is ahead."""

    def __init__(self, endpoints: list[str]) -> None:
        self.session = zenoh.open(zenoh_config([endpoints[0]], [endpoints[1]], wait_for_peers=False))
        self.clock, self.events = SystemClock(), Events()
        self.team = Team(self.session, "f", "p1", ["p2"], lambda *_: None)
        rooms: Any = SimpleNamespace(
            team=self.team,
            journal=self.events,
            profile=SimpleNamespace(safety=SafetyParameters(), network=Network()),
            mission=SimpleNamespace(vehicles=[SimpleNamespace(name="p2", role="pursuer")]),
            limits=load_profile(Path("profiles/sim.toml")).limits,
        )
        self.teamwork = Teamwork(rooms)
        self.roster = Roster(self.team.post)
        self.watch = ClockWatch(self.team.post, self.clock)

    async def until(self, condition: Callable[[], bool]) -> float:
        """Poll as the control loop does; seconds until `condition` held."""
        asking = asyncio.create_task(self.watch.run())
        began_s = self.clock.now_s()
        while not condition():
            assert self.clock.now_s() < began_s + DEADLINE_S, f"not within {DEADLINE_S} s; heard {self.events.heard}"
            self.watch.poll(self.clock.now_s())
            self.team.poll(self.clock.now_s())
            self.teamwork.note_silence(self.clock.now_s())
            self.roster.poll()
            await asyncio.sleep(POLL_S)
        asking.cancel()
        return self.clock.now_s() - began_s

    def is_well(self) -> bool:
        state = self.team.peers["p2"].state
        return state is not None and "p2" in self.roster.here and "p2" in self.watch.offsets


@pytest.fixture
def endpoints() -> Iterator[list[str]]:
    ports = ReservedPorts(2)
    yield [f"udp/127.0.0.1:{port}" for port in ports.numbers]
    ports.release()


def start(endpoints: list[str]) -> subprocess.Popen[bytes]:
    script = Path(__file__).with_name("sharing_vehicle.py")
    return subprocess.Popen([sys.executable, script, "p2", "p1", endpoints[1], endpoints[0], str(AHEAD_S)])


def test_a_frozen_and_a_killed_process_are_noticed_and_its_clock_is_measured(endpoints: list[str]) -> None:
    process = start(endpoints)
    p1 = Watching(endpoints)
    heard = p1.events.heard

    async def story() -> None:
        await p1.until(p1.is_well)
        offset = p1.watch.offsets["p2"]
        assert abs(offset.ahead_s - AHEAD_S) <= offset.uncertainty_s + 0.001, "both processes read one system's clock"
        state = p1.team.peers["p2"].state
        assert state is not None
        assert abs(state.t_s - p1.clock.now_s()) < 5.0, "its stamps are on this clock"

        process.send_signal(signal.SIGSTOP)
        frozen_s = await p1.until(lambda: ("teammate_lost", "p2") in heard)
        gone_s = frozen_s + await p1.until(lambda: "p2" in p1.roster.left)
        process.send_signal(signal.SIGCONT)
        await p1.until(lambda: ("teammate_back", "p2") in heard and "p2" in p1.roster.here)

        heard.clear()
        process.kill()
        killed_s = await p1.until(lambda: ("teammate_lost", "p2") in heard)
        measured = f"noticed after {frozen_s:.2f} s frozen and {killed_s:.2f} s killed, token gone after {gone_s:.2f} s"
        sys.stdout.write(measured + "\n")
        assert max(frozen_s, killed_s) < 1.0 + SLACK_S, measured
        assert gone_s < LEASE_S + SLACK_S, measured

    try:
        asyncio.run(story())
    finally:
        os.kill(process.pid, signal.SIGCONT)
        process.kill()
        process.wait()
        p1.session.close()
