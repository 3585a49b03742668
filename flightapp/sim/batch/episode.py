"""One episode: the planners of the application in the fast simulation. No network, no wall clock, one thread."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np

from flightapp.core.clock import monotonic_ns, thread_ns
from flightapp.core.types import Array, Assignment, Decision, Observation, TargetTrack, VehicleState
from flightapp.planning.api import Planner
from flightapp.planning.plane import nearest_on, segments
from flightapp.planning.registry import UNLED, known_parameters, make_evader, make_planner
from flightapp.sim.batch.assigning import Assigning
from flightapp.sim.batch.facts import evader_parameters, planner_parameters
from flightapp.sim.batch.failing import Failing
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.records import CAPTURED, ESCAPED, FLYING, OUTCOMES
from flightapp.sim.batch.result import Outcome, RunResult
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.seeds import Stream, key
from flightapp.sim.batch.setup import lay_out
from flightapp.sim.batch.target_sight import TargetSight
from flightapp.sim.batch.team_link import TeamLink
from flightapp.sim.batch.world import World

if TYPE_CHECKING:
    from flightapp.sim.batch.depth_sensing import DepthSensing

FIRST_MODE = "hold"
LOST_MODE = "lost"
"""Of a pursuer that failed."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What no planner sees: the true states, pursuers first and the evader last, and the world that they fly in."""

    states: list[VehicleState]
    layout: Layout


class Watcher(Protocol):
    """Sees every control period, before the vehicles move, and the end."""

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        """Observations and decisions of the pursuers, the evader's last."""
        ...

    def end(self, truth: Truth) -> None:
        """Where everything is at the event that ends the episode, or at the time limit."""
        ...


def fly(
    scenario: Scenario,
    planner: str,
    seed: int,
    parameters: Mapping[str, object] | None = None,
    watcher: Watcher | None = None,
) -> RunResult:
    """The episode of `seed` with every pursuer under `planner` with `parameters` over those of the scenario.

    InputError on an unknown planner or evader policy, bad parameters, or a layout without room.
    """
    began_ns = monotonic_ns()
    layout = lay_out(scenario, seed)
    flight = _Flight(scenario, layout, planner, seed, parameters, watcher)
    outcome = flight.fly()
    result = flight.result(outcome, began_ns)
    if watcher is not None:
        watcher.end(Truth(flight.states(result.duration_s), layout))
    return result


def _depth_sensing(scenario: Scenario, world: World, stream: int) -> DepthSensing | None:
    """Loaded only where it is wanted: renderer and perception double the time that the import takes."""
    if scenario.sensing.kind != "depth":
        return None
    from flightapp.sim.batch.depth_sensing import DepthSensing

    return DepthSensing(scenario, world, stream)


def _world(scenario: Scenario, layout: Layout, wind_key: int, sensing_key: int, sees_walls: bool) -> World:
    """The world in space is loaded only where it is wanted."""
    if scenario.volume is None:
        return World(scenario, layout, wind_key, sensing_key, sees_walls)
    from flightapp.sim.batch.volume.world import VolumeWorld

    return VolumeWorld(scenario, scenario.volume, layout, wind_key, sensing_key)


class _Flight:
    """The loop and what it keeps."""

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        planner: str,
        seed: int,
        parameters: Mapping[str, object] | None,
        watcher: Watcher | None,
    ) -> None:
        self._scenario, self._layout, self._name, self._seed, self._watcher = scenario, layout, planner, seed, watcher
        self._count = scenario.pursuers.count

        def stream(of: Stream) -> int:
            return key(scenario.family, seed, of)

        given, limits = planner_parameters(scenario, planner, parameters, layout), scenario.pursuers.limits()
        sees_walls = "polygons_m" not in given
        self._world = _world(scenario, layout, stream(Stream.WIND), stream(Stream.SENSING), sees_walls)
        self._cameras = _depth_sensing(scenario, self._world, stream(Stream.SENSING))
        self._link = TeamLink(scenario, stream(Stream.MESSAGES))
        self._assigning: Assigning | None = None
        if scenario.messages.assignment:
            plans = watcher is not None or planner not in UNLED
            self._assigning = Assigning(scenario, stream(Stream.MESSAGES), planner, given, limits, plans)
        self._sight = TargetSight(scenario, stream(Stream.TARGET))
        target = scenario.target
        self._target_is_truth = not (target.position_noise_m or target.velocity_noise_m_s or target.latency_s)
        self._target_is_truth = self._target_is_truth and not (target.needs_sight or target.filter)
        own = stream(Stream.PLANNER)
        self._planners = [make_planner(planner, limits=limits, parameters=given, seed=own + i) for i in range(self._count)]
        self._failing = Failing(scenario, stream(Stream.FAILURES))
        evader = scenario.evader
        evader_given = evader_parameters(scenario, known_parameters(evader.policy) or frozenset(), layout)
        self._evader = make_evader(evader.policy, limits=evader.limits(), parameters=evader_given, seed=stream(Stream.EVADER))
        self._decision_ns: list[int] = []
        self._decisions = 0
        self._modes: Counter[str] = Counter()
        self._flags: Counter[str] = Counter()

    def fly(self) -> int:
        """To the event that ends the episode (its code), or to the time limit (FLYING)."""
        scenario, world = self._scenario, self._world
        period_s, boundary = scenario.control_period_s, self._layout.boundary
        modes, etas = [FIRST_MODE] * self._count, cast(list[float | None], [None] * self._count)
        covariance = np.eye(6) * 1e-4
        for tick in range(round(scenario.time_limit_s / period_s)):
            t_s = tick * period_s
            self._fail(t_s)
            alive = self._failing.alive
            states = world.states(t_s)
            teams = self._link.teams(tick, states, modes, etas, alive)
            seen = world.obstacles(tick)
            target = self._target(tick, t_s, states[-1], covariance)
            if self._cameras is not None:
                seen[:-1] = self._cameras.obstacles(tick, teams, target)
            assigned: list[Assignment | None] = [None] * self._count
            if self._assigning is not None:
                assigned = self._assigning.assignments(tick, states[:-1], teams[:-1], target, seen[:-1], alive)
            observations = [
                Observation(t_s, period_s, states[i], teams[i], target, seen[i], boundary, assigned[i])
                for i in range(self._count)
            ]
            observations.append(Observation(t_s, period_s, states[-1], teams[-1], None, seen[-1], boundary))
            decisions = []
            for i, planner in enumerate(self._planners):
                if not alive[i]:
                    decisions.append(Decision(np.zeros(3), None, states[i].yaw_rad, LOST_MODE, None))
                    modes[i], etas[i] = LOST_MODE, None
                    if self._watcher is not None:
                        self._decision_ns.append(0)
                    continue
                decision = self._decided(planner, observations[i], timed=tick % self._count == i)
                decisions.append(decision)
                modes[i] = decision.mode
                eta = decision.diagnostics.get("eta_s")
                etas[i] = eta if isinstance(eta, float) else None
                self._flags.update(cast(list[str], decision.diagnostics.get("flags", ())))
            decisions.append(self._evader.step(observations[-1]))
            self._modes.update(modes)
            if self._watcher is not None:
                self._watcher.step(t_s, observations, decisions, Truth(states, self._layout))
            outcome = world.advance(tick, decisions)
            if outcome != FLYING:
                return outcome
        return FLYING

    def _decided(self, planner: Planner, observation: Observation, *, timed: bool) -> Decision:
        """With the only look at the clock within an episode: the processor time is a system call, which costs like a decision."""
        self._decisions += 1
        if not timed and self._watcher is None:
            return planner.step(observation)
        began_ns = thread_ns()
        decision = planner.step(observation)
        self._decision_ns.append(thread_ns() - began_ns)
        return decision

    def _fail(self, t_s: float) -> None:
        for index in self._failing.step(t_s, self._leader):
            self._world.remove(index)

    def _leader(self) -> int | None:
        if self._assigning is not None:
            return self._assigning.leader
        return 0 if self._failing.alive[0] else None

    def _target(self, tick: int, t_s: float, evader: VehicleState, covariance: Array) -> TargetTrack | None:
        if self._target_is_truth:
            return TargetTrack(t_s, evader.position_ned_m, evader.velocity_ned_m_s, covariance, 0.0)
        return self._sight.track(tick, t_s, self._world.poses, self._world.target_seen)

    def states(self, t_s: float) -> list[VehicleState]:
        """Where the vehicles are now, which is `t_s`."""
        return self._world.states(t_s)

    def result(self, outcome: int, began_ns: int) -> RunResult:
        record, pursuers = self._world.record[0], self._world.vehicles[:-1]
        evader = self._world.vehicles[-1]
        end_s = float(record["end_s"])
        place = (float(evader["n"]), float(evader["e"]))
        nearest = nearest_on(place, segments(self._layout.boundary))
        total = sum(self._modes.values())
        periods = np.maximum(pursuers["periods"], 1)
        return RunResult(
            scenario=self._scenario.name,
            planner=self._name,
            seed=self._seed,
            outcome=cast(Outcome, OUTCOMES[outcome]),
            collided_with=self._world.collided_with,
            duration_s=end_s,
            capture_time_s=end_s if outcome == CAPTURED else None,
            path_length_m=float(pursuers["path_m"].mean()),
            mean_jerk_m_s3=float((pursuers["jerk_sum"] / periods).mean()),
            boundary_distance_m=0.0 if outcome == ESCAPED else float(np.hypot(place[0] - nearest[0], place[1] - nearest[1])),
            min_clearance_m=float(record["clearance"]),
            min_separation_m=float(record["separation"]),
            decision_ns=np.array(self._decision_ns, dtype=np.int64),
            mode_share={mode: self._modes[mode] / total for mode in sorted(self._modes)},
            shortest_path_m=self._layout.shortest_path_m,
            sim_wall_ns=monotonic_ns() - began_ns,
            encircled_first_s=None if np.isnan(record["encircled_first_s"]) else float(record["encircled_first_s"]),
            encircled_share=float(record["encircled_s"]) / end_s if end_s > 0.0 else 0.0,
            encircled_at_capture=bool(record["encircled"]) if outcome == CAPTURED else None,
            travel_m=float(pursuers["path_m"].sum()),
            turning_rad=float(pursuers["turning"].sum()),
            lost=int(pursuers["gone"].sum()),
            decisions=self._decisions,
            flag_share={flag: self._flags[flag] / self._decisions for flag in sorted(self._flags)},
        )
