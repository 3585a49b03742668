"""A scenario file: who flies, what is sensed and heard, and from which family of layouts each seed is drawn."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, Field, field_validator, model_validator

from flightapp.config.loading import Strict, read_toml, validate
from flightapp.config.parameter_files import beside
from flightapp.config.wind import HarmonicWind
from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.capture import CaptureRule
from flightapp.planning.registry import planner_names
from flightapp.sim.batch.depth_camera import DepthCamera
from flightapp.sim.batch.families.dense import DenseLayout
from flightapp.sim.batch.families.layout import FamilyLayout
from flightapp.sim.batch.families.scatter import ScatterLayout
from flightapp.sim.batch.families.suburban import SuburbanLayout
from flightapp.sim.batch.families.terminal import TerminalLayout
from flightapp.sim.batch.families.u_trap import UTrapLayout
from flightapp.sim.batch.volume.table import Volume
from perception.parameters import PerceptionParameters

OF_DEPTH = ("camera", "perception")
OF_IDEAL = ("range_m", "field_of_view_deg", "occlusion", "position_noise_m", "radius_noise_m", "sees_vehicles")


class Vehicle(Strict):
    """What a vehicle can do. The fields from `delay_s` on are of the multirotor only."""

    model: Literal["unicycle", "multirotor", "single-integrator"] = "unicycle"
    """`unicycle`: flies one exact arc a control period; `multirotor`: velocity loop with lag, jerk limit, delay and wind;
    `single-integrator`: flies what is commanded at once."""
    speed_max_m_s: float = Field(gt=0)
    acceleration_max_m_s2: float = Field(default=6.0, gt=0)
    jerk_max_m_s3: float = Field(default=60.0, gt=0)
    yaw_rate_max_rad_s: float = Field(default=3.0, gt=0)
    yaw_acceleration_max_rad_s2: float = Field(default=12.0, gt=0)
    climb_rate_max_m_s: float = Field(default=2.0, gt=0)
    """Of flights in space, as the next."""
    sink_rate_max_m_s: float = Field(default=2.0, gt=0)
    body_radius_m: float = Field(default=0.25, gt=0)
    safety_margin_m: float = Field(default=0.25, ge=0)
    delay_s: float = Field(default=0.0, ge=0, le=0.5)
    """From a decision to the command in the velocity loop; rounded to sub-steps."""
    response_s: float = Field(default=0.1, gt=0)
    """Time constant from commanded to flown acceleration."""
    velocity_gain_1_s: float = Field(default=2.2, gt=0)
    """Acceleration per velocity error."""
    drag_1_s: float = Field(default=0.25, ge=0)
    """Deceleration per air speed."""
    disturbance_estimate_s: float = Field(default=0.8, gt=0)
    """Time constant with which the velocity loop takes out a disturbance."""
    frame_reserve: float = Field(default=1.3, ge=1)
    """The frame reaches this multiple of the acceleration and jerk that the planner may count on."""

    def limits(self) -> Limits:
        """As a planner gets them."""
        return Limits(
            self.speed_max_m_s,
            self.acceleration_max_m_s2,
            self.jerk_max_m_s3,
            self.yaw_rate_max_rad_s,
            self.yaw_acceleration_max_rad_s2,
            self.climb_rate_max_m_s,
            self.body_radius_m,
            self.safety_margin_m,
            self.sink_rate_max_m_s,
        )


class Pursuers(Vehicle):
    """The team, all alike."""

    count: int = Field(default=2, ge=1, le=100)


class Evader(Vehicle):
    """The evader and its policy."""

    policy: str
    """Name of an evader policy."""
    parameters: dict[str, Any] = Field(default_factory=dict)
    """Of the policy."""
    solid: bool = False
    """Whether obstacles stop it: it slides along them. The source's evader passes through."""


class Sensing(Strict):
    """How each pursuer sees obstacles; the default is ideal within its range."""

    kind: Literal["ideal", "depth"] = "ideal"
    """`ideal`: the layout's discs with the flaws below; `depth`: rendered frames of `camera` through the real perception."""
    camera: DepthCamera = DepthCamera()
    """Of kind `depth` only."""
    perception: PerceptionParameters = PerceptionParameters()
    """Of kind `depth` only: as in a profile."""
    latency_s: float = Field(default=0.0, ge=0, le=2)
    """Age of what is seen; rounded to sub-steps."""
    range_m: float = Field(default=15.0, gt=0)
    """To the nearest point of a disc."""
    field_of_view_deg: float = Field(default=360.0, gt=0, le=360)
    occlusion: bool = False
    """Discs hidden behind nearer ones are not seen."""
    position_noise_m: float = Field(default=0.0, ge=0)
    """Standard deviation a axis, anew for each disc and control period."""
    radius_noise_m: float = Field(default=0.0, ge=0)
    sees_vehicles: bool = False
    """Other vehicles appear as discs, too."""

    @model_validator(mode="after")
    def _is_of_one_kind(self) -> Sensing:
        foreign, instead = (
            (OF_DEPTH, "kind = 'ideal' has no camera; set kind = 'depth' or leave this out")
            if self.kind == "ideal"
            else (OF_IDEAL, "kind = 'depth' sees what sensing.camera shows; leave this out")
        )
        for name in foreign:
            value = getattr(self, name)
            if value != Sensing.model_fields[name].default:
                shown = "" if isinstance(value, BaseModel) else f" = {value}"
                raise ValueError(f"{name}{shown}: {instead}")
        return self


class Target(Strict):
    """What the team knows of the evader; the default is the truth at every decision."""

    position_noise_m: float = Field(default=0.0, ge=0)
    velocity_noise_m_s: float = Field(default=0.0, ge=0)
    latency_s: float = Field(default=0.0, ge=0, le=2)
    needs_sight: bool = False
    """Only measured while some pursuer has it in its field of view and range, not behind a disc; shared by the team."""
    range_m: float = Field(default=50.0, gt=0)
    """Range of that sight."""
    filter: bool = False
    """Measurements pass the application's target filter."""


class Partition(Strict):
    """For a while some pursuers hear one another only, and nobody else hears them."""

    vehicles: tuple[str, ...] = Field(min_length=1)
    """p1, p2, ..."""
    from_s: float = Field(ge=0)
    until_s: float = Field(gt=0)

    @model_validator(mode="after")
    def _lasts(self) -> Partition:
        if self.until_s <= self.from_s:
            raise ValueError(f"until_s = {self.until_s}: must be greater than from_s = {self.from_s}")
        return self

    def separates(self, t_s: float, i: int, j: int) -> bool:
        """The pursuers of index i and j at `t_s`."""
        return self.from_s <= t_s < self.until_s and (f"p{i + 1}" in self.vehicles) != (f"p{j + 1}" in self.vehicles)


class Messages(Strict):
    """The link between pursuers."""

    delay_s: float = Field(default=0.0, ge=0, le=5)
    """From a state to its use by a teammate; rounded up to control periods."""
    loss_probability: float = Field(default=0.0, ge=0, lt=1)
    """Of each message on its way to each teammate."""
    assignment: bool = False
    """Whether a leader assigns the sides from which pursuers close in; else each finds its own from where all are."""
    election: bool = False
    """Whether the leader is elected, and another one when it fails; else p1 leads, and after it nobody."""
    partitions: tuple[Partition, ...] = ()
    """All see the evader all the same."""

    def separates(self, t_s: float, i: int, j: int) -> bool:
        """Whether the pursuers of index i and j cannot hear one another at `t_s`."""
        return any(partition.separates(t_s, i, j) for partition in self.partitions)


class Wind(Strict):
    """Mean wind (where it blows to) and its gusts; multirotors only."""

    north_m_s: float = 0.0
    east_m_s: float = 0.0
    gust_m_s: float = Field(default=0.0, ge=0)
    gust_correlation_s: float = Field(default=2.5, gt=0)
    harmonic: HarmonicWind | None = None
    """On top of these: harmonics with a gust step, stronger with height."""

    @property
    def blows(self) -> bool:
        return self.north_m_s != 0.0 or self.east_m_s != 0.0 or self.gust_m_s > 0.0 or self.harmonic is not None


class Planner(Strict):
    """What every planner is told about the scenario."""

    parameters: dict[str, Any] = Field(default_factory=dict)
    """Facts of the vehicles and the rules, not choices of one planner."""
    own: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Parameters of single planners by name."""

    @field_validator("own")
    @classmethod
    def _are_known(cls, own: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
        for planner in own:
            if planner not in planner_names():
                raise ValueError(f"'{planner}' is no planner; known: {', '.join(planner_names())}")
        return own


class Failure(Strict):
    """A pursuer that is silent, decides nothing and is gone from the world from a time on."""

    vehicle: str = Field(pattern=r"^(p[1-9]\d{0,2}|random|leader)$")
    """p1, p2, ...; `leader`: who leads then; `random`: one of the others, by the seed."""
    t_s: float = Field(ge=0)


class Campaign(Strict):
    """What a campaign flies where the command line does not say it."""

    planners: tuple[str, ...] = ()
    """The first is the one that the others are compared with."""
    seeds: str = "0-99"

    @field_validator("planners")
    @classmethod
    def _are_known(cls, planners: tuple[str, ...]) -> tuple[str, ...]:
        for number, planner in enumerate(planners):
            if planner not in planner_names():
                raise ValueError(f"'{planner}' is no planner; known: {', '.join(planner_names())}")
            if planner in planners[:number]:
                raise ValueError(f"'{planner}' is named twice; name each planner once")
        return planners


class Scenario(Strict):
    """One family of layouts with everything that flies in it. Each seed is one episode."""

    name: str = Field(min_length=1)
    description: str = ""
    family: str
    control_period_s: float = Field(default=0.1, gt=0, le=1)
    sub_step_s: float = Field(default=0.02, gt=0, le=0.1)
    """Vehicles and events are stepped with this; a whole number of them makes a control period."""
    time_limit_s: float = Field(gt=0, le=3600)
    layout: FamilyLayout
    pursuers: Pursuers
    evader: Evader
    capture: CaptureRule = CaptureRule()
    sensing: Sensing = Sensing()
    target: Target = Target()
    messages: Messages = Messages()
    wind: Wind = Wind()
    volume: Volume | None = None
    """Where it is given, everything flies in space; else in one plane."""
    failures: tuple[Failure, ...] = ()
    planner: Planner = Planner()
    campaign: Campaign = Campaign()

    @property
    def sub_steps(self) -> int:
        """Sub-steps in a control period."""
        return round(self.control_period_s / self.sub_step_s)

    @property
    def inflation_m(self) -> float:
        """What a pursuer's centre keeps from an obstacle's surface."""
        return self.pursuers.body_radius_m + self.pursuers.safety_margin_m

    @model_validator(mode="after")
    def _is_consistent(self) -> Scenario:
        if abs(self.sub_steps * self.sub_step_s - self.control_period_s) > 1e-9:
            raise ValueError(
                f"sub_step_s = {self.sub_step_s}: control_period_s = {self.control_period_s} must be a multiple of it"
            )
        if self.sensing.kind == "depth" and self.sensing.camera.rate_hz * self.sub_step_s > 1.0 + 1e-9:
            rate_hz, fastest_hz = self.sensing.camera.rate_hz, 1.0 / self.sub_step_s
            raise ValueError(f"sensing.camera.rate_hz = {rate_hz}: at most {fastest_hz:g}, one frame each sub_step_s")
        if self.wind.blows and self.pursuers.model != "multirotor":
            model = self.pursuers.model
            raise ValueError(f"wind: pursuers.model = '{model}' does not feel wind; set it to 'multirotor' or leave the wind out")
        self._check_failures()
        self._check_partitions()
        self._check_volume()
        return self

    def _check_volume(self) -> None:
        if self.volume is None:
            return
        planar = {
            f"capture.mode = '{self.capture.mode}'": (self.capture.mode != "first", "'first'"),
            f"sensing.kind = '{self.sensing.kind}'": (self.sensing.kind != "ideal", "'ideal'"),
            "sensing": (self.sensing.position_noise_m + self.sensing.radius_noise_m > 0.0, "without noise"),
            "target": (self.target != Target(), "left out: the evader is known"),
            "evader.solid = true": (self.evader.solid, "false"),
        }
        for said, (is_so, right) in planar.items():
            if is_so:
                raise ValueError(f"volume: {said} is not simulated in space; must be {right}")

    def _check_partitions(self) -> None:
        known = [f"p{index + 1}" for index in range(self.pursuers.count)]
        for partition in self.messages.partitions:
            for name in partition.vehicles:
                if name not in known:
                    raise ValueError(
                        f"messages.partitions.vehicles: '{name}' is none of the pursuers; name {known[0]} to {known[-1]}"
                    )

    def _check_failures(self) -> None:
        for failure in self.failures:
            if failure.vehicle == "leader" and not self.messages.assignment:
                raise ValueError("failures.vehicle = 'leader': nobody leads; set messages.assignment = true or name a vehicle")
            last = self.pursuers.count
            if failure.vehicle[0] == "p" and int(failure.vehicle[1:]) > last:
                raise ValueError(f"failures.vehicle = '{failure.vehicle}': pursuers.count = {last}; name p1 to p{last}")
        if self.failures and self.sensing.kind == "depth":
            raise ValueError("failures: sensing.kind = 'depth' would go on showing those that failed; set it to 'ideal'")


class DenseScenario(Scenario):
    family: Literal["dense"]
    layout: DenseLayout = DenseLayout()


class UTrapScenario(Scenario):
    family: Literal["u-trap"]
    layout: UTrapLayout = UTrapLayout()


class TerminalScenario(Scenario):
    family: Literal["terminal"]
    layout: TerminalLayout = TerminalLayout()


class ScatterScenario(Scenario):
    family: Literal["scatter"]
    layout: ScatterLayout


class SuburbanScenario(Scenario):
    family: Literal["suburban"]
    layout: SuburbanLayout = SuburbanLayout()


WHOLE = ("layout.pursuers", "layout.evader")
"""Tables whose fields exclude one another: a file that extends another gives all of such a table or nothing."""

FAMILIES: Mapping[str, type[Scenario]] = {
    "dense": DenseScenario,
    "u-trap": UTrapScenario,
    "terminal": TerminalScenario,
    "suburban": SuburbanScenario,
    "scatter": ScatterScenario,
}


def load_scenario(path: Path, overrides: Mapping[str, str] | None = None) -> Scenario:
    """The scenario in the TOML file `path`, on top of the file that it extends, with `overrides` ("table.field" -> TOML value).

    A value that is not TOML is taken as text. InputError names the file, the field, the value and what would be right.
    """
    tables = _with_base(path, ())
    tables.setdefault("name", path.stem)
    for field, text in (overrides or {}).items():
        _set(tables, field, _value(text), path)
    family = str(tables.get("family"))
    if family not in FAMILIES:
        raise InputError(f"{path}: family = '{family}': must be one of {', '.join(sorted(FAMILIES))}")
    return validate(FAMILIES[family], tables, path)


def _with_base(path: Path, through: tuple[Path, ...]) -> dict[str, Any]:
    if path.resolve() in through:
        raise InputError(f"{path}: extends: the files extend one another in a circle; one of them must stand alone")
    tables = read_toml(path)
    _set_files_beside(tables, path.parent)
    base = tables.pop("extends", None)
    if base is None:
        return tables
    if not isinstance(base, str):
        raise InputError(f"{path}: extends = {base!r}: must be the name of a scenario file in quotes")
    return _merged(_without_name(_with_base(path.parent / base, (*through, path.resolve()))), tables)


def _set_files_beside(tables: dict[str, Any], folder: Path) -> None:
    """Files that parameters name are relative to the scenario file in `folder`."""
    for who in ("evader", "planner"):
        table = tables.get(who)
        if isinstance(table, dict) and isinstance(table.get("parameters"), dict):
            table["parameters"] = beside(table["parameters"], folder)


def _without_name(tables: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in tables.items() if key not in ("name", "description")}


def _merged(base: dict[str, Any], top: Mapping[str, Any], within: str = "") -> dict[str, Any]:
    """`top` over `base`, table by table; those of WHOLE, and the parameters of another policy, are replaced."""
    merged = dict(base)
    if merged.get("policy") != top.get("policy", merged.get("policy")):
        merged.pop("parameters", None)
    for key, value in top.items():
        before, name = merged.get(key), f"{within}{key}"
        if isinstance(before, dict) and isinstance(value, dict) and name not in WHOLE:
            merged[key] = _merged(before, value, f"{name}.")
        else:
            merged[key] = value
    return merged


def _value(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _set(tables: dict[str, Any], field: str, value: object, path: Path) -> None:
    *way, last = field.split(".")
    table = tables
    for key in way:
        table = table.setdefault(key, {})
        if not isinstance(table, dict):
            raise InputError(
                f"{path}: {field} = {value!r}: '{key}' is a value, not a table; name a field such as sensing.range_m"
            )
    table[last] = value
