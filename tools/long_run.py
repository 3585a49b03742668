"""Writes a long made-up run with the real recorder, to measure what reading and reporting it costs.

Three vehicles (two pursuers, one evader) circle at 25 Hz with discs, unseen sectors and the diagnostics of real decisions.

    python tools/long_run.py FOLDER --minutes 20
    /usr/bin/time -v flightapp report FOLDER
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from flightapp.config.mission import Mission, load_mission
from flightapp.recording import messages
from flightapp.recording.recorder import Recorder
from flightapp.recording.small_log import SUFFIX

ROOT = Path(__file__).resolve().parents[1]
MISSION, PROFILE = ROOT / "missions" / "demo_two_pursuers.toml", ROOT / "profiles" / "sim.toml"
START_S = 1_750_000_000.0
RATE_HZ = 25.0
CLIMB_S, GROUND_S = 5.0, 5.0
HEIGHT_M = 5.0
CLOSE_TIMEOUT_S = 600.0
UNLIMITED_BYTES = 1 << 50
"""A made-up run is written whole, however full the disk is."""
ORBITS = {"p1": (8.0, -4.0, 3.0, 0.0), "p2": (8.0, -4.0, 3.0, math.pi), "e1": (50.0, 3.0, 4.0, 1.0)}
"""Centre north and east, radius, phase: clear of the demo mission's obstacles and of each other."""
SPEED_M_S = 2.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--minutes", type=float, default=20.0)
    arguments = parser.parse_args()
    write_long_run(arguments.folder, arguments.minutes * 60.0)


def write_long_run(folder: Path, duration_s: float) -> None:
    """One recording a vehicle in the new folder `folder`."""
    mission = load_mission(MISSION)
    folder.mkdir(parents=True)
    for name in ORBITS:
        recorder = Recorder(
            folder / f"{name}.mcap",
            mission=mission,
            small_path=folder / f"{name}{SUFFIX}",
            buffer_messages=10_000_000,
            free_bytes=lambda _: UNLIMITED_BYTES,
        )
        recorder.open()
        recorder.metadata("run", {"mission": mission.name, "seed": 0, "vehicle": name, "role": mission.vehicle(name).role})
        recorder.attach("mission.toml", MISSION)
        recorder.attach("profile.toml", PROFILE)
        _Story(recorder, mission, name, duration_s).write()
        recorder.close(CLOSE_TIMEOUT_S)
        if recorder.dropped:
            raise SystemExit(f"{recorder.path}: {recorder.dropped} messages were dropped")


class _Story:
    """Everything that one vehicle records in `duration_s`."""

    def __init__(self, recorder: Recorder, mission: Mission, name: str, duration_s: float) -> None:
        self._recorder, self._name, self._duration_s = recorder, name, duration_s
        self._is_pursuer = mission.vehicle(name).role == "pursuer"
        self._roles = {vehicle.name: vehicle.role for vehicle in mission.vehicles}
        self._random = np.random.default_rng(len(name) + ord(name[-1]))
        self._cylinders = [(c.north_m, c.east_m, c.radius_m) for c in mission.obstacles.cylinders]
        self._phases = [
            (0.0, "preflight"),
            (1.0, "takeoff"),
            (1.0 + CLIMB_S, "pursue"),
            (duration_s - GROUND_S - CLIMB_S, "land"),
            (duration_s - GROUND_S, "done"),
        ]

    def write(self) -> None:
        for step in range(round(self._duration_s * RATE_HZ)):
            t_s = step / RATE_HZ
            while self._phases and self._phases[0][0] <= t_s:
                phase = self._phases.pop(0)[1]
                outcome = "timeout" if phase in ("land", "done") else None
                self._log("/phase", messages.Phase(START_S + t_s, phase, "", outcome), t_s)
            self._write_step(step, t_s)
            if step % round(RATE_HZ) == 0:
                self._write_second(step, t_s)

    def _write_step(self, step: int, t_s: float) -> None:
        now_s = START_S + t_s
        position, velocity = _motion(self._name, t_s, self._duration_s)
        position = (np.array(position) + self._random.normal(0.0, 0.01, 3)).tolist()
        yaw = math.atan2(velocity[1], velocity[0])
        self._log("/own", messages.OwnState(now_s - 0.01, position, velocity, 0.02, -0.1, yaw, 0.01), t_s)
        if step % 2 == 0:
            members = [
                messages.Teammate(
                    other, self._roles[other], *_motion(other, t_s - 0.03, self._duration_s), "coarse", "pursue", 4.0, 0.03, 0
                )
                for other in ORBITS
                if other != self._name
            ]
            self._log("/team", messages.Team(now_s, members), t_s)
        if not self._is_pursuing(t_s):
            return
        if self._is_pursuer:
            self._write_senses(step, t_s)
        self._write_decision(t_s, velocity, yaw)
        acting = [["yaw-rate", "turn of -3 deg wanted, -1.7 deg fit into this period"]] if step % 3 == 0 else []
        setpoint = messages.SetpointRecord(
            now_s + 0.002, velocity, yaw, now_s - 0.03 if self._is_pursuer else None, self._is_pursuer, acting, 1.4
        )
        self._log("/setpoint", setpoint, t_s + 0.002)

    def _write_senses(self, step: int, t_s: float) -> None:
        now_s = START_S + t_s
        prey, fleeing = _motion("e1", t_s, self._duration_s)
        self._log("/target", messages.Target(now_s, prey, fleeing, 0.05, 0.03), t_s)
        discs: list[list[float | None]] = [
            [*row, 0.0, 0.0, -9.0 + noise, 0.0]
            for row, noise in zip(self._cylinders, self._random.normal(0.0, 0.05, len(self._cylinders)).tolist(), strict=True)
        ]
        count = len(discs)
        unseen = [[-3.141592653589793, -0.7534], [0.7621, 3.141592653589793]]
        frame = messages.Obstacles(
            now_s, now_s - 0.03, step, discs, unseen, 0.012, 0, [], [0.12] * count, [0.93] * count, 0.028, step
        )
        self._log("/obstacles", frame, t_s)

    def _write_decision(self, t_s: float, velocity: list[float], yaw: float) -> None:
        noise = self._random.normal(0.0, 1.0, 8).tolist()
        diagnostics: dict[str, object] = {
            "stage": "fine",
            "target_distance_m": 27.0 + noise[0],
            "eta_s": 3.7 + 0.1 * noise[1],
            "contested": True,
            "game_point": [35.4 + noise[2], noise[3]],
            "circles": [[52.9 + noise[4], 6.3, 19.3], [52.7, noise[5], 17.3]],
            "clearance_m": 1.4 + 0.1 * noise[6],
            "encircled": False,
            "captured": False,
            "memory_weight": 0.0,
            "guidance": "",
            "terms": {f"term_{number}": [value, 1.0] for number, value in enumerate(noise)},
        }
        decision = messages.DecisionRecord(
            START_S + t_s, velocity, yaw, "fine", [36.5, -7.1, -HEIGHT_M], "", 0.003 + 0.0005 * abs(noise[7]), diagnostics
        )
        self._log("/decision", decision, t_s)

    def _write_second(self, step: int, t_s: float) -> None:
        now_s, flying = START_S + t_s, 1.0 <= t_s < self._duration_s - GROUND_S
        mode = "OFFBOARD" if self._is_pursuing(t_s) else "LAND" if flying else "HOLD"
        landed = "IN_AIR" if flying else "ON_GROUND"
        self._log("/autopilot", messages.AutopilotStatus(now_s, True, mode, flying, landed, 0.4), t_s)
        charge = 1.0 - 0.6 * t_s / self._duration_s
        self._log("/battery", messages.Battery(now_s, 14.0 + 2.8 * charge, charge), t_s)
        self._log("/health", messages.Health(now_s, 0.3, 150.0, 1.0, 0, step, 40.0, 42.0, 45.0), t_s)

    def _is_pursuing(self, t_s: float) -> bool:
        return 1.0 + CLIMB_S <= t_s < self._duration_s - GROUND_S - CLIMB_S

    def _log(self, topic: str, message: object, t_s: float) -> None:
        self._recorder.log(topic, message, START_S + t_s)


def _motion(name: str, t_s: float, duration_s: float) -> tuple[list[float], list[float]]:
    """Position and velocity, NED, on the circle of `name`."""
    north, east, radius, phase = ORBITS[name]
    angle = phase + SPEED_M_S / radius * t_s
    height = HEIGHT_M * min(1.0, max(0.0, (t_s - 1.0) / CLIMB_S), max(0.0, (duration_s - GROUND_S - t_s) / CLIMB_S))
    position = [north + radius * math.cos(angle), east + radius * math.sin(angle), -height]
    return position, [-SPEED_M_S * math.sin(angle), SPEED_M_S * math.cos(angle), 0.0]


if __name__ == "__main__":
    main()
