"""A run of a campaign as recordings: one MCAP a vehicle and the truth, with the mission and the profiles that it stands for."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import tomli_w
from pydantic import ValidationError

from flightapp.analysis.campaign.trace import Period, Trace
from flightapp.config import mission as told
from flightapp.config.profile import Autopilot, Profile, VehicleLimits
from flightapp.core.types import Decision, Observation, VehicleState
from flightapp.recording import messages
from flightapp.recording.recorder import Recorder
from flightapp.safety.parameters import SafetyParameters
from flightapp.sim.batch.scenario import Vehicle

HEIGHT_M, OBSTACLE_HEIGHT_M, CEILING_M = 5.0, 8.0, 500.0
"""Scenarios are flat; these are the heights at which they are told."""
_BUFFER_MESSAGES = 10_000_000
"""Nobody waits for this recorder: it may keep all there is."""
_OUTCOMES = {"captured": "captured", "escaped": "escaped", "timed_out": "timeout", "collided": "fault"}


def record(trace: Trace, folder: Path) -> None:
    """Write `folder`, which `flightapp report` opens. Times are seconds since the start of the run."""
    folder.mkdir(parents=True)
    names = [*(f"p{number + 1}" for number in range(trace.pursuers)), "e1"]
    mission = _mission(trace, names)
    if mission is not None:
        path = folder / "mission.toml"
        path.write_text(tomli_w.dumps(mission.model_dump(mode="json", exclude_none=True)))
    for index, name in enumerate(names):
        profile = folder / f"profile-{name}.toml"
        kind: Vehicle = trace.scenario.evader if name == "e1" else trace.scenario.pursuers
        profile.write_text(tomli_w.dumps(_profile(kind).model_dump(mode="json", exclude_none=True)))
        with Recorder(folder / f"{name}.mcap", mission=mission, buffer_messages=_BUFFER_MESSAGES) as recorder:
            recorder.metadata("run", _about(trace, name))
            recorder.attach("profile.toml", profile)
            if mission is not None:
                recorder.attach("mission.toml", path)
            _Vehicle(trace, names, index, recorder).write()
    with Recorder(folder / "truth.mcap", buffer_messages=_BUFFER_MESSAGES) as recorder:
        recorder.metadata("run", _about(trace, "truth"))
        for t_s, row in zip(trace.times_s().tolist(), trace.states(), strict=True):
            for name, state in zip(names, row, strict=True):
                recorder.log("/truth", _truth(name, t_s, state), t_s)


class _Vehicle:
    """What one vehicle would have recorded."""

    def __init__(self, trace: Trace, names: Sequence[str], index: int, recorder: Recorder) -> None:
        self._trace, self._names, self._index, self._recorder = trace, names, index, recorder
        self._pursues = index < trace.pursuers

    def write(self) -> None:
        result = self._trace.result
        self._log("/phase", messages.Phase(0.0, "pursue", f"seed {result.seed} of {result.scenario}", None), 0.0)
        for number, period in enumerate(self._trace.periods):
            self._period(number, period)
        last, end_s = self._trace.end[self._index], result.duration_s
        self._log("/own", _own(end_s, last), end_s)
        if result.outcome == "collided" and self._pursues:
            text = f"a pursuer collided with {result.collided_with or 'something'}"
            self._log("/event", messages.Event(end_s, "error", "collision", text), end_s)
        outcome = _OUTCOMES[result.outcome] if self._pursues else None
        self._log("/phase", messages.Phase(end_s, "done", result.outcome, outcome), end_s)

    def _period(self, number: int, period: Period) -> None:
        t_s, seen, decision = period.t_s, period.observations[self._index], period.decisions[self._index]
        self._log("/own", _own(t_s, seen.own), t_s)
        if seen.target is not None:
            target = seen.target
            sigma_m = math.sqrt(max(0.0, float(target.covariance[0, 0] + target.covariance[1, 1])))
            position, velocity = target.position_ned_m.tolist(), target.velocity_ned_m_s.tolist()
            self._log("/target", messages.Target(target.t_s, position, velocity, sigma_m, target.age_s), t_s)
        self._log("/team", messages.Team(t_s, _teammates(seen)), t_s)
        self._log("/obstacles", _obstacles(number, t_s, seen), t_s)
        latency_s = (
            float(self._trace.result.decision_ns[number * self._trace.pursuers + self._index]) * 1e-9 if self._pursues else 0.0
        )
        self._log("/decision", _decision(t_s, decision, latency_s), t_s)

    def _log(self, topic: str, message: object, t_s: float) -> None:
        self._recorder.log(topic, message, t_s)


def _own(t_s: float, state: VehicleState) -> messages.OwnState:
    position, velocity = state.position_ned_m.tolist(), state.velocity_ned_m_s.tolist()
    return messages.OwnState(state.t_s, position, velocity, 0.0, 0.0, state.yaw_rad, t_s - state.t_s)


def _truth(name: str, t_s: float, state: VehicleState) -> messages.TruthRecord:
    position, velocity = state.position_ned_m.tolist(), state.velocity_ned_m_s.tolist()
    return messages.TruthRecord(t_s, name, position, velocity, state.yaw_rad, True, False)


def _teammates(seen: Observation) -> list[messages.Teammate]:
    return [
        messages.Teammate(
            member.name,
            "pursuer",
            member.state.position_ned_m.tolist(),
            member.state.velocity_ned_m_s.tolist(),
            member.mode,
            "pursue",
            member.eta_s,
            member.age_s,
            0,
        )
        for member in seen.team
    ]


def _obstacles(number: int, t_s: float, seen: Observation) -> messages.Obstacles:
    rows = [[value if math.isfinite(value) else None for value in row] for row in seen.obstacles.discs.tolist()]
    return messages.Obstacles(t_s, seen.obstacles.t_s, number, rows, seen.obstacles.unseen.tolist(), 0.0, 0, [])


def _decision(t_s: float, decision: Decision, latency_s: float) -> messages.DecisionRecord:
    goal = None if decision.goal_ned_m is None else decision.goal_ned_m.tolist()
    velocity, diagnostics = decision.velocity_ned_m_s.tolist(), dict(decision.diagnostics)
    return messages.DecisionRecord(t_s, velocity, decision.yaw_rad, decision.mode, goal, decision.reason, latency_s, diagnostics)


def _about(trace: Trace, name: str) -> dict[str, object]:
    role = {"e1": "evader", "truth": "truth"}.get(name, "pursuer")
    result = trace.result
    about = {"vehicle": name, "role": role, "mission": result.scenario, "strategy": result.planner, "seed": result.seed}
    return {**about, "network": "none"}


def _profile(kind: Vehicle) -> Profile:
    limits = kind.limits()
    return Profile(
        name=f"scenario-{kind.model}",
        limits=VehicleLimits.model_validate({name: getattr(limits, name) for name in VehicleLimits.model_fields}),
        autopilot=Autopilot(connection_url="udpin://127.0.0.1:14540"),
        safety=SafetyParameters(separation_min_m=2.0 * kind.body_radius_m),
    )


def _mission(trace: Trace, names: Sequence[str]) -> told.Mission | None:
    """The run as a mission, with the obstacles that stand still; None where starts are too near to obstacles for one."""
    layout, scenario = trace.layout, trace.scenario
    corners = trace.positions_m().reshape(-1, 2)
    area = layout.area
    low = corners.min(axis=0).clip(max=(area.north_min_m, area.east_min_m)) - 1.0
    high = corners.max(axis=0).clip(min=(area.north_max_m, area.east_max_m)) + 1.0
    (south, west), (north, east) = low.tolist(), high.tolist()
    starts = (*layout.pursuers, layout.evader)
    standing = layout.discs[(layout.discs[:, 3:5] == 0.0).all(axis=1)]
    try:
        return told.Mission(
            name=re.sub(r"[^A-Za-z0-9_-]", "-", scenario.name)[:64],
            description=scenario.description,
            height_m=HEIGHT_M,
            return_height_m=OBSTACLE_HEIGHT_M + 1.0,
            time_limit_s=scenario.time_limit_s,
            evader_speed_assumed_m_s=scenario.evader.speed_max_m_s,
            datum=told.Datum(latitude_deg=0.0, longitude_deg=0.0, altitude_m=0.0),
            flight_volume=told.FlightVolume(
                vertices_m=((south, west), (north, west), (north, east), (south, east)), height_max_m=CEILING_M
            ),
            boundary=told.ProtectedBoundary(
                vertices_m=tuple((float(n), float(e)) for n, e in layout.boundary.vertices_m), closed=layout.boundary.closed
            ),
            capture=told.Capture.model_validate(
                {name: getattr(scenario.capture, name) for name in told.Capture.model_fields if hasattr(scenario.capture, name)}
            ),
            vehicles=tuple(
                told.Vehicle(
                    name=name,
                    role="evader" if name == "e1" else "pursuer",
                    system_id=number + 1,
                    start=told.Start(north_m=start.north_m, east_m=start.east_m, heading_deg=math.degrees(start.heading_rad)),
                    strategy=told.Strategy(name=scenario.evader.policy if name == "e1" else trace.result.planner),
                )
                for number, (name, start) in enumerate(zip(names, starts, strict=True))
            ),
            obstacles=told.Obstacles(
                cylinders=tuple(
                    told.Cylinder(north_m=row[0], east_m=row[1], radius_m=row[2], height_m=OBSTACLE_HEIGHT_M)
                    for row in standing.tolist()
                )
            ),
        )
    except ValidationError:
        return None
