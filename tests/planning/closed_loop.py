"""Closed loop without sleeping: planners, velocity-lagged vehicles, disc sensing; the test bed of this folder.

Vehicles follow the commanded velocity with a first-order lag under acceleration and jerk limits, planar. Sensing is ideal
within its range, or a camera: field of view, noise, latency, and a short memory of what left the view. With `supervised_by`
every setpoint passes the supervisor of that mission, and the multirotor of the simulation flies it in the mission's wind, as in
the application.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flightapp.config.mission import Box, Mission, load_mission
from flightapp.config.profile import load_profile
from flightapp.core.angles import wrap_pi
from flightapp.core.clearance import clearance_m
from flightapp.core.types import (
    Array,
    Boundary,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    Setpoint,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.planning.api import Planner
from flightapp.planning.capture import CaptureRule
from flightapp.planning.plane import crosses, segments
from flightapp.planning.registry import make_evader, make_planner
from flightapp.safety.api import SafetyContext
from flightapp.safety.supervisor import Supervisor, make_supervisor
from flightapp.sim.multirotor import Command, Multirotor, MultirotorLimits, Wind
from tests.planning.capture_reference import Dwell, encircled

DT_S = 1.0 / 30.0
LAG_S = 0.25
TEAM_DELAY_S = 0.06
FRAME_LIMITS = MultirotorLimits(acceleration_max_m_s2=6.5, jerk_max_m_s3=52.0)
FRAME_STEPS, LINK_STEPS = 7, 3
PROFILE = Path(__file__).parents[2] / "profiles" / "sim.toml"
DEMO = Path(__file__).parents[2] / "missions" / "demo_two_pursuers.toml"


def limits(speed_max_m_s: float = 5.0) -> Limits:
    """The multirotor of the simulation profile."""
    return Limits(speed_max_m_s, 5.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45)


@dataclass
class Body:
    """One vehicle: planar lag with acceleration and jerk limit, yaw with rate limit."""

    position: Array
    velocity: Array
    yaw_rad: float
    limits: Limits
    acceleration: Array = field(default_factory=lambda: np.zeros(2))

    def move(self, command: Array, yaw_rad: float, wind: Array) -> None:
        wanted = (command[:2] - self.velocity) / LAG_S + wind
        wanted = wanted * min(1.0, self.limits.acceleration_max_m_s2 / max(float(np.hypot(*wanted)), 1e-12))
        change = wanted - self.acceleration
        reach = self.limits.jerk_max_m_s3 * DT_S
        self.acceleration = self.acceleration + change * min(1.0, reach / max(float(np.hypot(*change)), 1e-12))
        self.velocity = self.velocity + self.acceleration * DT_S
        self.position = self.position + self.velocity * DT_S
        turn = wrap_pi(yaw_rad - self.yaw_rad)
        limit = self.limits.yaw_rate_max_rad_s * DT_S
        self.yaw_rad = wrap_pi(self.yaw_rad + max(-limit, min(limit, turn)))

    def state(self, t_s: float) -> VehicleState:
        return VehicleState(t_s, np.array((*self.position, -5.0)), np.array((*self.velocity, 0.0)), self.yaw_rad)


class Drone(Body):
    """The multirotor of the simulation, which answers later than `Body`: velocity loop, tilting, link, gusts."""

    def __init__(self, start: tuple[float, float, float], limits: Limits, mission: Mission, seed: int) -> None:
        super().__init__(np.array(start[:2]), np.zeros(2), start[2], limits)
        simulation = mission.simulation
        self._frame = Multirotor(
            FRAME_LIMITS,
            position_ned_m=(start[0], start[1], -5.0),
            yaw_rad=start[2],
            wind=Wind(simulation.wind_north_m_s, simulation.wind_east_m_s, simulation.gust_m_s),
            ground_down_m=0.0,
            seed=seed,
        )
        self._frame.motors.running = True
        self._command = Command()

    def move(self, command: Array, yaw_rad: float, wind: Array) -> None:
        frame = self._frame
        for step in range(FRAME_STEPS):
            if step == LINK_STEPS:
                climb = -5.0 - frame.position_ned_m[2]
                self._command = Command((float(command[0]), float(command[1]), climb), yaw_rad=yaw_rad)
            frame.step(DT_S / FRAME_STEPS, self._command)
        self.position, self.velocity = np.array(frame.position_ned_m[:2]), np.array(frame.velocity_ned_m_s[:2])
        self.yaw_rad = frame.yaw_rad


@dataclass(frozen=True)
class Sensing:
    """How obstacles are seen; the default is ideal."""

    range_m: float = 10.0
    field_of_view_rad: float = 2.0 * math.pi
    latency_s: float = 0.0
    noise_m: float = 0.0
    memory_s: float = 0.0
    sees_vehicles: bool = False


CAMERA = Sensing(field_of_view_rad=math.radians(87.0), latency_s=0.06, noise_m=0.05, memory_s=2.0, sees_vehicles=True)


class Eye:
    """Discs of one vehicle through `Sensing`."""

    def __init__(self, sensing: Sensing, world: Array, random: np.random.Generator) -> None:
        self._sensing = sensing
        self._world = world
        self._random = random
        self._seen_s = np.full(len(world), -math.inf)
        self._pipe: deque[tuple[float, Array, Array]] = deque()

    def look(self, t_s: float, body: Body, vehicles: list[Body]) -> ObstacleSet:
        sensing = self._sensing
        offset = self._world[:, :2] - body.position
        distance = np.hypot(offset[:, 0], offset[:, 1])
        bearing = np.arctan2(offset[:, 1], offset[:, 0]) - body.yaw_rad
        bearing = np.abs((bearing + math.pi) % (2 * math.pi) - math.pi)
        visible = (distance - self._world[:, 2] < sensing.range_m) & (bearing < sensing.field_of_view_rad / 2)
        self._seen_s[visible] = t_s
        known = self._world[t_s - self._seen_s <= sensing.memory_s + 1e-9].copy()
        if sensing.sees_vehicles:
            sightings = [[*(v.position), 0.3, 0.0, 0.0, -np.inf, np.inf] for v in vehicles]
            known = np.vstack((known, np.array(sightings).reshape(-1, 7)))
        if sensing.noise_m > 0.0:
            known[:, :2] += self._random.normal(0.0, sensing.noise_m, (len(known), 2))
        half = sensing.field_of_view_rad / 2
        unseen = np.zeros((0, 2))
        if half < math.pi - 1e-9:
            unseen = np.array([[wrap_pi(body.yaw_rad + half), wrap_pi(body.yaw_rad - half)]])
        self._pipe.append((t_s, known, unseen))
        while len(self._pipe) > 1 and self._pipe[1][0] <= t_s - sensing.latency_s + 1e-9:
            self._pipe.popleft()
        stamp, discs, sectors = self._pipe[0]
        return ObstacleSet(stamp, discs, sectors)


@dataclass
class Flight:
    """What happened."""

    captured_s: float | None = None
    crossed_s: float | None = None
    clearance_m: float = math.inf
    separation_m: float = math.inf
    evader_distance_m: float = math.inf
    guards: list[Counter[str]] = field(default_factory=list)
    """Ticks in which each guard of each vehicle acted."""
    modes: list[set[str]] = field(default_factory=list)
    log: list[tuple[float, list[Array], list[Decision]]] = field(default_factory=list)
    observations: list[list[Observation]] = field(default_factory=list)

    @property
    def success(self) -> bool:
        return self.captured_s is not None and self.clearance_m > 0.0 and self.crossed_s is None


@dataclass
class Scenario:
    """One flight to fly: world discs (n, 7), starts (north, east, yaw), the last being the evader's."""

    world: Array
    pursuers: list[tuple[float, float, float]]
    evader: tuple[float, float, float]
    boundary: Boundary
    rule: CaptureRule
    evader_name: str = "boundary-seeking"
    evader_parameters: dict[str, object] = field(default_factory=dict)
    evader_speed_m_s: float = 2.5
    pursuer_speed_m_s: float = 5.0
    planner: str = "ac2f"
    parameters: dict[str, object] = field(default_factory=dict)
    sensing: Sensing = Sensing()
    time_limit_s: float = 60.0
    wind: tuple[float, float] = (0.0, 0.0)
    target_noise_m: float = 0.0
    supervised_by: Mission | None = None
    """The mission whose supervisor has the last word on every setpoint; its vehicles are these, in order."""


def disc(north: float, east: float, radius: float) -> list[float]:
    return [north, east, radius, 0.0, 0.0, -math.inf, math.inf]


def box_discs(box: Box, radius_m: float = 0.3) -> list[list[float]]:
    """Rows of small discs along the walls of `box`."""
    heading = math.radians(box.heading_deg)
    half_long, half_wide = box.length_m / 2 - radius_m, box.width_m / 2 - radius_m
    corners = [(half_long, half_wide), (half_long, -half_wide), (-half_long, -half_wide), (-half_long, half_wide)]
    discs = []
    for (a0, a1), (b0, b1) in zip(corners, corners[1:] + corners[:1], strict=True):
        count = max(2, math.ceil(math.dist((a0, a1), (b0, b1)) / radius_m))
        for k in range(count):
            along, across = a0 + (b0 - a0) * k / count, a1 + (b1 - a1) * k / count
            north = box.north_m + along * math.cos(heading) - across * math.sin(heading)
            east = box.east_m + along * math.sin(heading) + across * math.cos(heading)
            discs.append(disc(north, east, radius_m))
    return discs


def world_of(mission: Mission) -> Array:
    discs = [disc(c.north_m, c.east_m, c.radius_m) for c in mission.obstacles.cylinders]
    for box in mission.obstacles.boxes:
        discs.extend(box_discs(box))
    return np.array(discs, dtype=np.float64).reshape(-1, 7)


def demo(seed: int = 0, *, supervised: bool = False, **changes: object) -> Scenario:
    """The demo mission, its starts shaken by `seed` (0: as written)."""
    mission = load_mission(DEMO)
    random = np.random.default_rng(seed)
    places = []
    for vehicle in mission.vehicles:
        shake = random.uniform(-1.0, 1.0, 2) if seed else np.zeros(2)
        sideways = random.uniform(-10.0, 10.0) if seed and vehicle.role == "evader" else 0.0
        yaw = math.radians(vehicle.start.heading_deg)
        places.append((vehicle.start.north_m + shake[0], vehicle.start.east_m + shake[1] + sideways, yaw))
    scenario = Scenario(
        world_of(mission), places[:2], places[2], mission.boundary.as_boundary(), CaptureRule(**mission.capture.model_dump())
    )
    scenario.parameters = {"evader_speed_assumed_m_s": mission.evader_speed_assumed_m_s}
    scenario.supervised_by = mission if supervised else None
    for name, value in changes.items():
        setattr(scenario, name, value)
    return scenario


def random_field(seed: int, obstacles: int = 20) -> Scenario:
    """75 m x 50 m with random discs, two pursuers, a boundary line: the source's dense scenario in kind."""
    random = np.random.default_rng(1000 + seed)
    starts = [(2.0, 18.0), (2.0, 32.0), (70.0, float(random.uniform(10.0, 40.0)))]
    discs: list[list[float]] = []
    while len(discs) < obstacles:
        north, east, radius = random.uniform(8.0, 64.0), random.uniform(2.0, 48.0), random.uniform(0.4, 1.5)
        apart = all(math.dist((north, east), (d[0], d[1])) > radius + d[2] + 2.5 for d in discs)
        if apart and all(math.dist((north, east), start) > radius + 3.0 for start in starts):
            discs.append(disc(north, east, radius))
    places = []
    for (north, east), yaw in zip(starts, (0.0, 0.0, math.pi), strict=True):
        shake = random.uniform(-1.0, 1.0, 2)
        places.append((north + shake[0], east + shake[1], wrap_pi(yaw + random.uniform(-math.pi / 4, math.pi / 4))))
    boundary = Boundary(np.array([[0.0, 0.0], [0.0, 50.0]]), False)
    rule = CaptureRule(radius_m=3.0, hold_radius_m=2.2, hold_tolerance_m=1.0, angular_gap_min_deg=90.0, dwell_s=1.0)
    parameters: dict[str, object] = {"evader_speed_assumed_m_s": 2.5}
    return Scenario(np.array(discs), places[:2], places[2], boundary, rule, parameters=parameters)


class Pilot:
    """From the decision of one vehicle to the setpoint that it flies: through the supervisor where there is one."""

    def __init__(self, mission: Mission | None, index: int, limits: Limits) -> None:
        self._limits = limits
        self._previous: Setpoint | None = None
        self._supervisor: Supervisor | None = None
        if mission is not None:
            self._name = mission.vehicles[index].name
            self._supervisor = make_supervisor(mission, load_profile(PROFILE), self._name)

    def setpoint(self, decision: Decision, seen: Observation, acting: Counter[str]) -> Setpoint:
        setpoint = Setpoint(decision.velocity_ned_m_s, decision.yaw_rad)
        if self._supervisor is None:
            return setpoint
        supervised = self._supervisor.check(
            setpoint,
            SafetyContext(
                t_s=seen.t_s,
                dt_s=seen.dt_s,
                name=self._name,
                own=seen.own,
                own_age_s=0.0,
                team=seen.team,
                target=seen.target,
                obstacles=seen.obstacles,
                obstacles_age_s=seen.t_s - seen.obstacles.t_s,
                previous=self._previous,
                limits=self._limits,
            ),
        )
        acting.update(name for name, _ in supervised.acting)
        self._previous = supervised.setpoint
        return supervised.setpoint


def fly(scenario: Scenario, seed: int = 0, *, keep: bool = False) -> Flight:
    """Fly `scenario` to capture, crossing or time limit."""
    random = np.random.default_rng(seed)
    parameters = {"capture": scenario.rule.model_dump(), **scenario.parameters}
    count = len(scenario.pursuers)
    speeds = [scenario.pursuer_speed_m_s] * count + [scenario.evader_speed_m_s]
    starts = zip([*scenario.pursuers, scenario.evader], speeds, strict=True)
    bodies = [_body(scenario, index, start, limits(speed), seed) for index, (start, speed) in enumerate(starts)]
    planners: list[Planner] = [
        make_planner(scenario.planner, limits=limits(scenario.pursuer_speed_m_s), parameters=parameters, seed=seed)
        for _ in range(count)
    ]
    planners.append(
        make_evader(
            scenario.evader_name,
            limits=limits(scenario.evader_speed_m_s),
            parameters=scenario.evader_parameters,
            seed=seed,
        )
    )
    eyes = [Eye(scenario.sensing, scenario.world, random) for _ in range(count)]
    eyes.append(Eye(Sensing(), scenario.world, random))
    etas: list[float | None] = [None] * count
    modes = ["hold"] * count
    flight = Flight(guards=[Counter() for _ in bodies], modes=[set() for _ in bodies])
    pilots = [Pilot(scenario.supervised_by, index, body.limits) for index, body in enumerate(bodies)]
    heard: deque[list[VehicleState]] = deque(maxlen=1 + round(TEAM_DELAY_S / DT_S))
    dwell = Dwell(scenario.rule.dwell_s)
    sides = segments(scenario.boundary)
    wind = np.array(scenario.wind)
    for tick in range(round(scenario.time_limit_s / DT_S)):
        t_s = tick * DT_S
        states = [body.state(t_s) for body in bodies]
        heard.append(states)
        track = _track(states[-1], t_s, scenario.target_noise_m, random)
        observations = []
        for index, body in enumerate(bodies):
            team = tuple(
                _member(f"p{other + 1}", heard[0][other], t_s, modes[other], etas[other])
                for other in range(count)
                if other != index
            )
            others = [other for other in bodies if other is not body]
            discs = eyes[index].look(t_s, body, others)
            target = track if index < count else None
            observations.append(Observation(t_s, DT_S, states[index], team, target, discs, scenario.boundary))
        decisions = [planner.step(observation) for planner, observation in zip(planners, observations, strict=True)]
        for index, decision in enumerate(decisions):
            flight.modes[index].add(decision.mode)
        for index in range(count):
            eta = decisions[index].diagnostics["eta_s"]
            etas[index] = eta if isinstance(eta, float) else None
            modes[index] = decisions[index].mode
        if keep:
            flight.log.append((t_s, [body.position.copy() for body in bodies], decisions))
            flight.observations.append(observations)
        before = bodies[-1].position.copy()
        for index, (body, decision) in enumerate(zip(bodies, decisions, strict=True)):
            setpoint = pilots[index].setpoint(decision, observations[index], flight.guards[index])
            body.move(setpoint.velocity_ned_m_s, setpoint.yaw_rad, wind)
        _judge(flight, scenario, bodies)
        evader = (float(bodies[-1].position[0]), float(bodies[-1].position[1]))
        if crosses((float(before[0]), float(before[1])), evader, sides):
            flight.crossed_s = t_s
            return flight
        pursuers = [(float(body.position[0]), float(body.position[1])) for body in bodies[:-1]]
        if dwell.update(t_s, encircled(evader, pursuers, scenario.rule)):
            flight.captured_s = t_s
            return flight
    return flight


def _body(scenario: Scenario, index: int, start: tuple[float, float, float], limits: Limits, seed: int) -> Body:
    if scenario.supervised_by is None:
        return Body(np.array(start[:2]), np.zeros(2), start[2], limits)
    return Drone(start, limits, scenario.supervised_by, 10 * seed + index)


def _member(name: str, state: VehicleState, t_s: float, mode: str, eta_s: float | None) -> TeamMember:
    """A teammate as the application hands it on: its last state, moved to the present with its velocity."""
    age_s = t_s - state.t_s
    moved = VehicleState(t_s, state.position_ned_m + age_s * state.velocity_ned_m_s, state.velocity_ned_m_s, state.yaw_rad)
    return TeamMember(name, moved, mode, eta_s, age_s)


def _track(state: VehicleState, t_s: float, noise_m: float, random: np.random.Generator) -> TargetTrack:
    noise = np.array((*random.normal(0.0, noise_m, 2), 0.0)) if noise_m > 0.0 else np.zeros(3)
    return TargetTrack(t_s, state.position_ned_m + noise, state.velocity_ned_m_s, np.eye(6) * 0.01, 0.0)


def _judge(flight: Flight, scenario: Scenario, bodies: list[Body]) -> None:
    body_radius = bodies[0].limits.body_radius_m
    for index, body in enumerate(bodies[:-1]):
        if len(scenario.world):
            flight.clearance_m = min(flight.clearance_m, clearance_m(body.position, scenario.world, body_radius))
        evader = float(np.hypot(*(body.position - bodies[-1].position)))
        flight.evader_distance_m = min(flight.evader_distance_m, evader)
        for other in bodies[index + 1 : -1]:
            flight.separation_m = min(flight.separation_m, float(np.hypot(*(body.position - other.position))))
