"""Flies a pursuit in real time, kills the leader's process in the chase, and tells how long the team was without a leader's plan.

    .venv/bin/python tools/kill_leader.py --runs 5

Each run is a `flightapp sim` of its own: real MAVLink, MAVSDK and Zenoh, every vehicle its own process. The leader is whoever the
vehicles' logs name; it gets SIGKILL some seconds into the pursuit. All times come from the recordings of those that are left.
"""

from __future__ import annotations

import argparse
import re
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import orjson
import psutil

from flightapp.core.clock import SystemClock
from flightapp.recording.reader import read_recording

POLL_S = 0.02
START_TIMEOUT_S = 180.0
END_TIMEOUT_S = 300.0
FLIES = "flightapp.runtime.vehicle_process"
LEADS = re.compile(r"leader: (\w+) leads in term (\d+)")


@dataclass(frozen=True, slots=True)
class Failover:
    """One run; times in s from the kill."""

    killed: str
    elected_s: float
    """Somebody else leads, as the last of the vehicles left has understood."""
    planned_s: float
    """The new leader's first plan is in force at all that are left."""
    without_s: float
    """A plan without the dead is."""
    outcome: dict[str, str | None]
    text: str
    """The event that ended the pursuit at whoever concluded it."""
    captured_s: float | None


def main() -> int:
    """Print each run and the summary; exit status 0 if the evader was captured in every one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mission", type=Path, default=Path("missions/demo_three_pursuers.toml"))
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0, help="of the first run; each further run has the next")
    parser.add_argument("--after", type=float, default=3.0, help="seconds of pursuit before the leader is killed")
    parser.add_argument("--json", action="store_true", help="print JSON for machines")
    given = parser.parse_args()
    told = []
    for number in range(given.runs):
        with tempfile.TemporaryDirectory(prefix="kill-leader-") as folder:
            told.append(fly(given.mission, Path(folder) / "run", given.seed + number, given.after))
        if not given.json:
            print(_line(told[-1]), flush=True)
    captured = sum(set(one.outcome.values()) == {"captured"} for one in told)
    if given.json:
        print(orjson.dumps({"runs": [asdict(one) for one in told], "captured": captured}).decode())
    else:
        for name in ("elected_s", "planned_s", "without_s"):
            values = [getattr(one, name) for one in told]
            print(f"{name}: p50 {statistics.median(values):.2f} max {max(values):.2f}")
        print(f"captured in {captured} of {len(told)} runs")
    return 0 if captured == len(told) else 1


def fly(mission: Path, run: Path, seed: int, after_s: float) -> Failover:
    """One run; RuntimeError where there was no chase to kill in."""
    command = (sys.executable, "-m", "flightapp", "sim", str(mission), "--run", str(run), "--seed", str(seed), "--json")
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as launcher:
        try:
            pursuers = _pursuing(launcher, run)
            time.sleep(after_s)
            killed, killed_s = _kill(psutil.Process(launcher.pid), _leader(run, pursuers))
            _over(launcher, run, [name for name in pursuers if name != killed])
            launcher.terminate()  # Everybody lands where it is.
            launcher.wait(END_TIMEOUT_S)
        finally:
            launcher.terminate()
    return _told(run, [name for name in pursuers if name != killed], killed, killed_s)


def _pursuing(launcher: subprocess.Popen[str], run: Path) -> list[str]:
    """Names of the pursuers, once all of them pursue."""
    deadline_s = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline_s and launcher.poll() is None:
        logs = {path.stem: path.read_text(errors="replace") for path in run.glob("p?.log")}
        if logs and all("phase pursue" in text for text in logs.values()):
            return sorted(logs)
        time.sleep(POLL_S)
    said = launcher.stderr.read() if launcher.poll() is not None and launcher.stderr else ""
    raise RuntimeError(f"the vehicles of {run} do not pursue: {said[-500:]}")


def _over(launcher: subprocess.Popen[str], run: Path, left: list[str]) -> None:
    """Wait until everybody that is left has an outcome."""
    deadline_s = time.monotonic() + END_TIMEOUT_S
    while time.monotonic() < deadline_s and launcher.poll() is None:
        if all("outcome: " in (run / f"{name}.log").read_text(errors="replace") for name in left):
            return
        time.sleep(POLL_S)


def _leader(run: Path, pursuers: list[str]) -> str:
    """Whom the newest term has, by the logs."""
    found: list[list[tuple[str, str]]] = [LEADS.findall((run / f"{name}.log").read_text(errors="replace")) for name in pursuers]
    (name, _) = max((one for ones in found for one in ones), key=lambda one: int(one[1]))
    return name


def _kill(launcher: psutil.Process, leader: str) -> tuple[str, float]:
    """SIGKILL for the process that flies the leader, below the launcher that this run started; its deadman is spared."""
    for process in launcher.children(recursive=True):
        arguments = process.cmdline()
        if arguments[1:3] == ["-m", FLIES] and arguments[arguments.index("--vehicle") + 1] == leader:
            killed_s = SystemClock().now_s()
            process.kill()
            return leader, killed_s
    raise RuntimeError(f"no process flies {leader}")


def _told(run: Path, left: list[str], killed: str, killed_s: float) -> Failover:
    recordings = {name: read_recording(run / f"{name}.mcap") for name in left}
    plans = {name: recording.topic("/plan").messages for name, recording in recordings.items()}
    events = {name: recording.topic("/event").messages for name, recording in recordings.items()}
    outcome: dict[str, str | None] = {}
    for name, recording in recordings.items():
        ended = [phase for phase in recording.topic("/phase").messages if phase["outcome"]]
        outcome[name] = ended[-1]["outcome"] if ended else None
    new = [[one["t_s"] for one in plans[name] if one["t_s"] > killed_s and one["leader"] != killed] for name in left]
    without = [
        [one["t_s"] for one in plans[name] if one["t_s"] > killed_s and killed not in [seat["vehicle"] for seat in one["seats"]]]
        for name in left
    ]
    elected = [
        [
            one["t_s"]
            for one in events[name]
            if one["name"] == "leader" and one["t_s"] > killed_s and one["data"]["leader"] in left
        ]
        for name in left
    ]
    ends = sorted(
        (one["t_s"], one["text"]) for name in left for one in events[name] if one["name"] == "outcome" and one["t_s"] > killed_s
    )
    return Failover(
        killed,
        _last(elected) - killed_s,
        _last(new) - killed_s,
        _last(without) - killed_s,
        outcome,
        ends[0][1] if ends else "",
        ends[0][0] - killed_s if ends else None,
    )


def _last(times_s: list[list[float]]) -> float:
    """When the last of the vehicles had its first; infinite if one never had."""
    return max(min(times, default=float("inf")) for times in times_s)


def _line(one: Failover) -> str:
    when = "" if one.captured_s is None else f" {one.captured_s:.1f} s after the kill"
    return (
        f"{one.killed} killed: elected after {one.elected_s:.2f} s, new leader's plan after {one.planned_s:.2f} s, "
        f"plan without it after {one.without_s:.2f} s; {one.text or 'no outcome'}{when}"
    )


if __name__ == "__main__":
    sys.exit(main())
