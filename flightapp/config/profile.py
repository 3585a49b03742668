"""The profile: what one vehicle's hardware can do, how it is wired, and how much room it must keep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator, model_validator

from flightapp.config.loading import Strict, load
from flightapp.config.tracking import Controller, Tracking
from flightapp.core.types import Limits
from flightapp.safety.parameters import SafetyParameters
from perception.parameters import PerceptionParameters


class VehicleLimits(Strict):
    """Vehicle limits as flown by the autopilot; the planner and the supervisor stay inside them."""

    speed_max_m_s: float = Field(gt=0, le=30)
    acceleration_max_m_s2: float = Field(gt=0, le=30)
    jerk_max_m_s3: float = Field(gt=0, le=500)
    yaw_rate_max_rad_s: float = Field(gt=0, le=10)
    yaw_acceleration_max_rad_s2: float = Field(gt=0, le=100)
    climb_rate_max_m_s: float = Field(gt=0, le=10)
    body_radius_m: float = Field(gt=0, le=3)
    safety_margin_m: float = Field(ge=0, le=10)
    sink_rate_max_m_s: float = Field(gt=0, le=10)
    """As the climb rate where it is not given."""

    @model_validator(mode="before")
    @classmethod
    def _sinks_as_it_climbs(cls, given: object) -> object:
        if isinstance(given, Mapping) and "climb_rate_max_m_s" in given:
            return {"sink_rate_max_m_s": given["climb_rate_max_m_s"], **given}
        return given

    def as_limits(self) -> Limits:
        return Limits(**self.model_dump())


class Autopilot(Strict):
    """Link to the autopilot."""

    connection_url: str
    """MAVSDK URL: udpin://0.0.0.0:14540, serial:///dev/ttyACM0:921600, tcpout://192.168.0.3:5760."""
    connect_timeout_s: float = Field(default=20.0, gt=0, le=300)
    telemetry_rate_hz: float = Field(default=50.0, ge=10, le=200)
    pilot_transmitter: bool = True
    """Whether a pilot with a transmitter stands by; only a simulation should do without."""

    @field_validator("connection_url")
    @classmethod
    def _url_names_a_scheme_and_host(cls, url: str) -> str:
        scheme, separator, rest = url.partition("://")
        if not separator or scheme not in ("udpin", "udpout", "tcpin", "tcpout", "serial"):
            raise ValueError("use udpin://HOST:PORT, udpout://HOST:PORT, tcpout://HOST:PORT or serial:///dev/TTY:BAUD")
        if scheme != "serial" and not _is_host_and_port(rest):
            raise ValueError("name the host and a port from 1 to 65535, for example udpin://0.0.0.0:14540")
        if scheme == "serial" and not (rest.startswith("/") and rest.rpartition(":")[2].isdigit()):
            raise ValueError("name the device and its rate, for example serial:///dev/ttyUSB0:921600")
        return url


class Control(Strict):
    """The control loop. It runs when a depth frame has been processed, and at `rate_min_hz` when none comes."""

    rate_min_hz: float = Field(default=25.0, ge=20, le=50)
    deadman_timeout_s: float = Field(default=0.35, ge=0.1, le=0.45)
    """Silence of the control loop after which the deadman kills the vehicle process."""
    altitude_gain_1_s: float = Field(default=1.0, gt=0, le=5)
    """Climb rate per metre of altitude error: PX4's velocity mode does not hold altitude by itself."""
    acceleration_feed_forward: bool = False
    """Whether the planner's acceleration, where it gives one, is sent beside the velocity."""
    controller: Controller = "autopilot"
    """Who makes a pursuer follow the decided velocity: the autopilot's own loop alone, or `aadrc-smc` over it. A mission may say
    otherwise."""
    tracking: Tracking = Tracking()


def _is_host_and_port(address: str) -> bool:
    host, _, port = address.rpartition(":")
    return bool(host) and port.isdigit() and 0 < int(port) < 65536


SECURE_PROTOCOLS = ("quic", "tls")


def check_endpoint(endpoint: str) -> None:
    """ValueError unless `endpoint` reads PROTOCOL/HOST:PORT."""
    protocol, _, address = endpoint.partition("/")
    if protocol not in ("udp", "tcp", "tls", "quic") or not _is_host_and_port(address):
        raise ValueError(f"'{endpoint}' is not an endpoint; write udp/HOST:PORT, or quic/HOST:PORT in a fleet with certificates")


def check_endpoints_are_secure(endpoints: Iterable[str], certificates: Path | None) -> None:
    """ValueError where an endpoint cannot show certificates that there are, or needs some that there are not."""
    for endpoint in endpoints:
        protocol, _, address = endpoint.partition("/")
        if certificates is not None and protocol not in SECURE_PROTOCOLS:
            raise ValueError(f"'{endpoint}' cannot carry certificates; write quic/{address}")
        if certificates is None and protocol in SECURE_PROTOCOLS:
            raise ValueError(f"'{endpoint}' needs certificates; make them with 'flightapp keys' and name their folder")


class Network(Strict):
    """Zenoh endpoints, explicit: no multicast."""

    listen_endpoints: tuple[str, ...] = ("udp/0.0.0.0:7447",)
    connect_endpoints: tuple[str, ...] = ()
    certificates: Path | None = None
    """This vehicle's folder from `flightapp keys`: TLS with mutual authentication. Without it anybody on the network may join."""
    access_control: bool = True
    """With certificates: every vehicle writes under its own name only, and only an operator commands."""
    state_rate_hz: float = Field(default=20.0, ge=1, le=50)
    """Of the own state to those for whom it matters."""
    fleet_kbit_s_max: float = Field(default=1000.0, gt=0, le=1_000_000)
    """What the whole fleet may send: in a large one mates far away get a quarter of the states."""
    share_discs: bool = False
    """Pursuers tell each other the obstacles that others will meet, and plan with what they were told; guards never do. Off
    unless wanted: nobody on board can check what a mate tells before the own camera looks there."""

    @field_validator("listen_endpoints", "connect_endpoints")
    @classmethod
    def _endpoints_name_protocol_and_port(cls, endpoints: tuple[str, ...]) -> tuple[str, ...]:
        for endpoint in endpoints:
            check_endpoint(endpoint)
        return endpoints

    @model_validator(mode="after")
    def _links_and_certificates_fit(self) -> Network:
        for name in ("listen_endpoints", "connect_endpoints"):
            try:
                check_endpoints_are_secure(getattr(self, name), self.certificates)
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return self


class Mounting(Strict):
    """Pose of the camera in the body frame (forward, right, down); zero angles look straight ahead."""

    forward_m: float = Field(default=0.1, ge=-3, le=3)
    right_m: float = Field(default=0.0, ge=-3, le=3)
    down_m: float = Field(default=0.0, ge=-3, le=3)
    roll_deg: float = Field(default=0.0, ge=-180, le=180)
    pitch_deg: float = Field(default=0.0, ge=-90, le=90)
    yaw_deg: float = Field(default=0.0, ge=-180, le=180)


REALSENSE_RATES_HZ = (6, 15, 30, 60, 90)
"""Depth rates of the D400 cameras; which of them the camera has at the size asked for is seen when it is opened."""


class Camera(Strict):
    """The depth camera. Without one (`source = "none"`) only the mission's surveyed obstacles are known."""

    source: Literal["none", "realsense-recording", "shared-memory", "realsense"] = "none"
    path: Path | None = None
    """File of the shared-memory source, or the recording (.db3, .bag) that stands for a camera on the bench."""
    serial_number: str | None = None
    """Of the RealSense; without it there must be only one."""
    stall_timeout_s: float = Field(default=1.0, ge=0.2, le=10)
    """Silence after which a RealSense is started again."""
    emitter: bool | None = None
    """Infrared projector of the RealSense on or off; without it, as the camera is set."""
    width_px: int = Field(default=848, ge=64, le=1920)
    height_px: int = Field(default=480, ge=48, le=1080)
    rate_hz: float = Field(default=30.0, gt=0, le=90)
    focal_length_x_px: float = Field(default=421.6, gt=0, le=10000)
    focal_length_y_px: float = Field(default=421.6, gt=0, le=10000)
    principal_point_x_px: float = Field(default=424.0, gt=0, le=4000)
    principal_point_y_px: float = Field(default=240.0, gt=0, le=4000)
    range_min_m: float = Field(default=0.3, gt=0)
    range_max_m: float = Field(default=10.0, gt=0, le=65)
    mounting: Mounting = Mounting()

    @model_validator(mode="after")
    def _is_consistent(self) -> Camera:
        if self.range_max_m <= self.range_min_m:
            raise ValueError(f"range_max_m = {self.range_max_m}: must be greater than range_min_m = {self.range_min_m}")
        if self.source in ("shared-memory", "realsense-recording") and self.path is None:
            raise ValueError(f"path: missing; source = '{self.source}' needs it")
        if self.source == "realsense" and self.rate_hz not in REALSENSE_RATES_HZ:
            offered = ", ".join(str(rate) for rate in REALSENSE_RATES_HZ)
            raise ValueError(f"rate_hz = {self.rate_hz:g}: a RealSense offers {offered}")
        return self


class RecordingOptions(Strict):
    """The flight recorder."""

    folder: Path = Path("runs")
    flush_period_s: float = Field(default=0.2, gt=0, le=0.5)
    chunk_bytes: int = Field(default=131072, ge=4096, le=4194304)
    small_log: bool = True
    """Beside the recording a decimated one, `<vehicle>.small.mcap`: all events, states now and then, quick to send."""
    depth_rate_hz: float = Field(default=0.0, ge=0, le=90)
    """Depth images a second in the recording; 0: none. Those that come while one is compressed are left out and counted."""
    depth_stride: int = Field(default=1, ge=1, le=16)
    """Every how manieth row and column of a depth image is recorded: real pixels, none averaged."""


class Preflight(Strict):
    """What must be there before take-off."""

    position_accuracy_max_m: float = Field(default=3.0, gt=0, le=50)
    """Largest standard deviation of the horizontal position that the receiver may report."""
    battery_start_min_fraction: float = Field(default=0.5, ge=0, le=1)


class Profile(Strict):
    """One vehicle's hardware."""

    name: str = Field(min_length=1)
    limits: VehicleLimits
    autopilot: Autopilot
    preflight: Preflight = Preflight()
    control: Control = Control()
    network: Network = Network()
    camera: Camera = Camera()
    perception: PerceptionParameters = PerceptionParameters()
    safety: SafetyParameters = SafetyParameters()
    recording: RecordingOptions = RecordingOptions()


def load_profile(path: Path) -> Profile:
    """The validated profile in `path`; InputError names file, field, value and what would be right."""
    return load(Profile, path)
