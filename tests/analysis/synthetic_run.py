"""A made-up run with the real recorder: two pursuers close in on one evader for a minute, with everything that is recorded.

Run as a script to look at its report: `python tests/analysis/synthetic_run.py FOLDER`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flightapp.config.mission import Mission, load_mission
from flightapp.core.types import Array
from flightapp.recording import messages
from flightapp.recording.recorder import Recorder

ROOT = Path(__file__).resolve().parents[2]
MISSION = ROOT / "missions" / "demo_two_pursuers.toml"
PROFILE = ROOT / "profiles" / "sim.toml"
T0_S = 1_750_000_000.0
TAKEOFF_S, READY_S, PURSUE_S, CAPTURED_S, LAND_S, DONE_S = 2.0, 8.0, 12.0, 45.0, 53.0, 60.0
STEP_S = 1.0 / 30.0
HEIGHT_M = 5.0


@dataclass(frozen=True)
class Motion:
    """Position and velocity NED over time since T0."""

    start: tuple[float, float]
    end: tuple[float, float]
    bend_m: float

    def position(self, t_s: float) -> Array:
        share = min(1.0, max(0.0, (t_s - PURSUE_S) / (CAPTURED_S - PURSUE_S)))
        share = share * share * (3 - 2 * share)
        north = self.start[0] + share * (self.end[0] - self.start[0])
        east = self.start[1] + share * (self.end[1] - self.start[1]) + self.bend_m * math.sin(math.pi * share)
        up = min(1.0, max(0.0, (t_s - TAKEOFF_S) / 5.0)) - min(1.0, max(0.0, (t_s - LAND_S) / 6.0))
        return np.array([north, east, -HEIGHT_M * up])

    def velocity(self, t_s: float) -> Array:
        return (self.position(t_s + 0.01) - self.position(t_s - 0.01)) / 0.02


MOTIONS = {
    "p1": Motion((0.0, -8.0), (18.2, -0.8), 1.0),
    "p2": Motion((0.0, 8.0), (21.8, 2.8), 4.5),
    "e1": Motion((55.0, 2.0), (20.0, 1.0), 3.0),
}
PHASES = (
    (0.0, "preflight", ""),
    (1.0, "arm", ""),
    (TAKEOFF_S, "takeoff", ""),
    (READY_S, "ready", "height reached"),
    (PURSUE_S, "pursue", "all vehicles are ready"),
    (CAPTURED_S, "return", "the evader is captured"),
    (LAND_S, "land", "back home"),
    (DONE_S - 0.5, "done", ""),
)


def write_run(folder: Path, duration_s: float = DONE_S) -> Path:
    """Write the whole run folder and return it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mission.toml").write_bytes(MISSION.read_bytes())
    (folder / "profile.toml").write_bytes(PROFILE.read_bytes())
    mission = load_mission(MISSION)
    for number, name in enumerate(MOTIONS):
        write_vehicle(folder / f"{name}.mcap", name, mission, seed=number, duration_s=duration_s)
    with Recorder(folder / "truth.mcap", buffer_messages=1_000_000) as recorder:
        recorder.metadata("run", {"mission": mission.name, "seed": 7, "vehicle": "truth"})
        for step in range(int(duration_s * 50)):
            t_s = step * 0.02
            for name in MOTIONS:
                recorder.log("/truth", truth(name, t_s), T0_S + t_s)
    return folder


def truth(name: str, t_s: float) -> messages.TruthRecord:
    position, velocity = MOTIONS[name].position(t_s), MOTIONS[name].velocity(t_s)
    on_ground = not TAKEOFF_S < t_s < LAND_S + 6.0
    return messages.TruthRecord(
        T0_S + t_s, name, position.tolist(), velocity.tolist(), yaw(velocity), 1.0 < t_s < DONE_S - 1, on_ground
    )


def yaw(velocity: Array) -> float:
    return math.atan2(velocity[1], velocity[0])


def write_vehicle(path: Path, name: str, mission: Mission, seed: int, duration_s: float) -> None:
    """Everything that one vehicle records."""
    random = np.random.default_rng(seed)
    vehicle = mission.vehicle(name)
    with Recorder(path, mission=mission, buffer_messages=1_000_000) as recorder:
        recorder.metadata("run", {"mission": mission.name, "seed": 7, "vehicle": name, "role": vehicle.role})
        recorder.attach("mission.toml", MISSION)
        recorder.attach("profile.toml", PROFILE)
        phases = list(PHASES)
        mode = ""
        for step in range(int(duration_s / STEP_S)):
            t_s = step * STEP_S
            while phases and phases[0][0] <= t_s:
                outcome = "captured" if phases[0][0] >= CAPTURED_S and vehicle.role == "pursuer" else None
                recorder.log("/phase", messages.Phase(T0_S + t_s, phases[0][1], phases[0][2], outcome), T0_S + t_s)
                phases.pop(0)
            mode = write_step(recorder, name, vehicle.camera, step, t_s, mode, mission, random)
            if step % 30 == 0:
                write_slow(recorder, t_s, step, random)
        write_events(recorder, name)


def write_step(
    recorder: Recorder, name: str, camera: bool, step: int, t_s: float, mode: str, mission: Mission, random: np.random.Generator
) -> str:
    now_s = T0_S + t_s
    position, velocity = MOTIONS[name].position(t_s), MOTIONS[name].velocity(t_s)
    noisy = position + random.normal(0, 0.02, 3)
    recorder.log("/own", messages.OwnState(now_s - 0.01, noisy.tolist(), velocity.tolist(), 0, 0, yaw(velocity), 0.01), now_s)
    if not TAKEOFF_S <= t_s <= LAND_S:
        return mode
    prey = MOTIONS["e1"].position(t_s) + random.normal(0, 0.15, 3)
    distance = float(np.linalg.norm(MOTIONS["e1"].position(t_s) - position))
    if camera:
        recorder.log(
            "/target",
            messages.Target(now_s, prey.tolist(), MOTIONS["e1"].velocity(t_s).tolist(), 0.2, abs(random.normal(0.05, 0.02))),
            now_s,
        )
        discs = [
            [c.north_m + random.normal(0, 0.05), c.east_m, c.radius_m, 0.0, 0.0, None, None]
            for c in mission.obstacles.cylinders
            if math.dist((c.north_m, c.east_m), position[:2]) < 10.0
        ]
        delay_s = 0.004 + abs(random.normal(0, 0.001))
        recorder.log("/obstacles", messages.Obstacles(now_s, now_s - delay_s, step, discs, [], delay_s, 0, []), now_s)
    if step % 3 == 0:
        others = [other for other in MOTIONS if other != name]
        team = [
            messages.Teammate(
                other,
                "evader" if other == "e1" else "pursuer",
                MOTIONS[other].position(t_s).tolist(),
                MOTIONS[other].velocity(t_s).tolist(),
                "pursue",
                "pursue",
                4.0,
                abs(random.normal(0.04, 0.015)) + (0.6 if 30.0 < t_s < 30.6 else 0.0),
                0,
            )
            for other in others
        ]
        recorder.log("/team", messages.Team(now_s, team), now_s)
    if not PURSUE_S <= t_s <= LAND_S:
        return mode
    new_mode = "return" if t_s >= CAPTURED_S else "hold" if distance < 3.2 else "encircle" if distance < 14.0 else "approach"
    stage = "coarse" if new_mode == "approach" else "fine"
    latency_s = abs(random.normal(0.0008 if stage == "coarse" else 0.0031, 0.0004))
    recorder.log(
        "/decision",
        messages.DecisionRecord(
            now_s,
            velocity.tolist(),
            yaw(velocity),
            new_mode,
            prey.tolist(),
            "closer than the encirclement distance" if new_mode != mode else "",
            latency_s,
            {"stage": stage, "cost": 1.25},
        ),
        now_s,
    )
    clearance = min(math.dist((c.north_m, c.east_m), position[:2]) - c.radius_m - 0.35 for c in mission.obstacles.cylinders)
    recorder.log(
        "/setpoint",
        messages.SetpointRecord(
            now_s, velocity.tolist(), yaw(velocity), now_s - 0.031 if camera else None, camera, [], clearance
        ),
        now_s,
    )
    return new_mode


def write_slow(recorder: Recorder, t_s: float, step: int, random: np.random.Generator) -> None:
    now_s = T0_S + t_s
    flying = TAKEOFF_S <= t_s < DONE_S - 1
    mode = "OFFBOARD" if PURSUE_S <= t_s < LAND_S else "HOLD"
    recorder.log(
        "/autopilot", messages.AutopilotStatus(now_s, True, mode, flying, "in_air" if flying else "on_ground", 0.4), now_s
    )
    recorder.log("/battery", messages.Battery(now_s, 15.9 - 0.01 * t_s, 0.95 - 0.002 * t_s), now_s)
    recorder.log(
        "/health", messages.Health(now_s, 0.22 + 0.03 * random.random(), 142.0 + 0.05 * t_s, 1.8, 0, max(0, step - 360)), now_s
    )


def write_events(recorder: Recorder, name: str) -> None:
    for t_s, level, event, text in (
        (8.0, "info", "ready", "height reached, waiting for the others"),
        (30.1, "warning", "link-stale", "nothing heard from p2 for 0.6 s; planning without it"),
        (CAPTURED_S, "info", "captured", "the evader was inside the capture radius for 1.0 s"),
    ):
        if name == "p1" or level == "info":
            recorder.log("/event", messages.Event(T0_S + t_s, level, event, text, {}), T0_S + t_s)


if __name__ == "__main__":
    write_run(Path(sys.argv[1]))
