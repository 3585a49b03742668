"""A mock autopilot that speaks MAVLink to MAVSDK as PX4 does: `python -m flightapp.sim.mock_autopilot --help`.

It sends to the address where MAVSDK listens (udpin://127.0.0.1:14540) and flies a multirotor model in real time.
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import socket
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NoReturn, TextIO

from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import VehicleLimits, load_profile
from flightapp.core.errors import InputError
from flightapp.core.geodesy import GeodeticPoint
from flightapp.core.parent_death import signal_on_parent_death
from flightapp.sim.autopilot_core import AutopilotCore, EventSink
from flightapp.sim.autopilot_estimator import Estimator, Noise
from flightapp.sim.autopilot_frames import Frames, displaced_origin
from flightapp.sim.autopilot_parameters import DEFAULTS, Parameters, Value, parse_override
from flightapp.sim.fault_script import ActiveFault, FaultEngine, FaultScript, load_fault_script
from flightapp.sim.mavlink_io import RealTime, Station
from flightapp.sim.mission_wind import wind_of
from flightapp.sim.multirotor import Multirotor, MultirotorLimits, Vector, Wind
from flightapp.vehicle.velocity_gains import PLANAR, VERTICAL

_DATUM = GeodeticPoint(47.3977, 8.5456, 488.0)
PLANAR_INTEGRAL, VERTICAL_INTEGRAL = "MPC_XY_VEL_I_ACC", "MPC_Z_VEL_I_ACC"
VELOCITY_LOOP = {
    PLANAR: "velocity_gain_1_s",
    VERTICAL: "vertical_gain_1_s",
    PLANAR_INTEGRAL: "integral_1_s2",
    VERTICAL_INTEGRAL: "vertical_integral_1_s2",
}
"""PX4's parameters of the velocity loop, and where the multirotor has them."""
_RESERVE = 1.3
"""How far the frame's abilities lie above the limits in the profile."""
_EXAMPLE = """examples:
  python -m flightapp.sim.mock_autopilot
      one vehicle, system id 1, to MAVSDK at udpin://127.0.0.1:14540
  python -m flightapp.sim.mock_autopilot --mission missions/demo_two_pursuers.toml --vehicle p2 --send-to 127.0.0.1:14541
  python -m flightapp.sim.mock_autopilot --scenario gps_loss.toml --param COM_OBL_RC_ACT=4 --log mock.jsonl
"""


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything a mock needs to know of its vehicle."""

    system_id: int
    frames: Frames
    position_ned_m: Vector
    heading_rad: float
    limits: MultirotorLimits
    wind: Wind
    script: FaultScript
    parameters: dict[str, Value]
    noise: Noise | None
    seed: int
    heartbeat_on_change: bool = True


class EventLog:
    """Events as JSON lines."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def __call__(self, event: dict[str, object]) -> None:
        self._file.write(json.dumps(event) + "\n")
        self._file.flush()


def make_station(setup: Setup, event: EventSink) -> tuple[Station, FaultEngine]:
    """The vehicle, its commander and its link."""
    core: AutopilotCore | None = None

    def report(kind: str, active: ActiveFault, detail: str) -> None:
        entry: dict[str, object] = {
            "t_s": round(core.t_s, 3) if core is not None else 0.0,
            "event": f"fault_{kind}",
            "index": active.index,
            "fault": active.name,
        }
        if detail:
            entry["detail"] = detail
        event(entry)
        if core is not None:
            core.status(4, f"Fault {kind}: {active.name}")

    limits = _with_gains(setup.limits, setup.parameters)
    parameters = Parameters({**_gains_of(limits), **setup.parameters, "MAV_SYS_ID": setup.system_id})
    faults = FaultEngine(setup.script, seed=setup.seed, report=report)
    vehicle = Multirotor(limits, position_ned_m=setup.position_ned_m, yaw_rad=setup.heading_rad, wind=setup.wind, seed=setup.seed)
    estimator = Estimator(setup.noise, no_aid_s=float(parameters["EKF2_NOAID_TOUT"]) * 1e-6, seed=setup.seed)
    core = AutopilotCore(
        vehicle=vehicle, estimator=estimator, frames=setup.frames, parameters=parameters, faults=faults, event=event
    )
    core.heartbeat_on_change = setup.heartbeat_on_change
    return Station(core, faults, setup.system_id), faults


def setup_from(arguments: argparse.Namespace) -> Setup:
    """The setup that the command line asks for; InputError where it contradicts itself or a file is wrong."""
    if (arguments.mission is None) != (arguments.vehicle is None):
        raise InputError("--mission and --vehicle belong together: the mission says where the vehicle of that name stands")
    limits = MultirotorLimits() if arguments.profile is None else frame_limits(load_profile(arguments.profile).limits)
    overrides = dict(parse_override(text) for text in arguments.param)
    script = FaultScript()
    if arguments.mission is None:
        system_id, datum, origin, start, wind = 1, _DATUM, displaced_origin(_DATUM, 0.0, 0), (0.0, 0.0, 0.0, 0.0), Wind()
    else:
        mission = load_mission(arguments.mission)
        system_id, datum, origin, start, wind = _from_mission(mission, arguments.vehicle, arguments.mission, arguments.seed)
        limits = with_velocity_loop(limits, mission.simulation.velocity_loop)
        faults = mission.simulation.faults.get(arguments.vehicle)
        if faults is not None and arguments.scenario is None:
            script = load_fault_script(arguments.mission.parent / faults)
    if arguments.scenario is not None:
        script = load_fault_script(arguments.scenario)
    if arguments.origin is not None:
        origin = GeodeticPoint(*arguments.origin)
        datum = origin if arguments.mission is None else datum
    if arguments.start is not None:
        start = (arguments.start[0], arguments.start[1], start[2], math.radians(arguments.start[2]))
    if arguments.system_id is not None:
        system_id = arguments.system_id
    return Setup(
        system_id=system_id,
        frames=Frames(datum, origin),
        position_ned_m=(start[0], start[1], start[2]),
        heading_rad=start[3],
        limits=limits,
        wind=wind,
        script=script,
        parameters=overrides,
        noise=None if arguments.no_noise else Noise(),
        seed=arguments.seed * 1000 + system_id,
        heartbeat_on_change=not arguments.slow_heartbeat,
    )


def _from_mission(
    mission: Mission, name: str, path: Path, seed: int
) -> tuple[int, GeodeticPoint, GeodeticPoint, tuple[float, float, float, float], Wind]:
    """System id, datum, origin, start (north, east, down, heading) and wind of one vehicle of the mission."""
    names = [vehicle.name for vehicle in mission.vehicles]
    if name not in names:
        raise InputError(f"--vehicle {name}: {path} has no vehicle of this name; it has {', '.join(names)}")
    index = names.index(name)
    vehicle, simulation, datum = mission.vehicles[index], mission.simulation, mission.datum.as_point()
    start = vehicle.start
    return (
        vehicle.system_id,
        datum,
        displaced_origin(datum, simulation.origin_offset_m, index),
        (start.north_m, start.east_m, -start.ground_height_m, math.radians(start.heading_deg)),
        wind_of(simulation, seed),
    )


def with_velocity_loop(limits: MultirotorLimits, loop: Literal["reference", "px4"]) -> MultirotorLimits:
    """`limits` with the velocity loop that the mission asks for."""
    return limits if loop == "reference" else _with_gains(limits, {name: DEFAULTS[name] for name in VELOCITY_LOOP})


def _with_gains(limits: MultirotorLimits, parameters: Mapping[str, Value]) -> MultirotorLimits:
    """`limits` with those gains of the velocity loop that `parameters` name."""
    return replace(limits, **{VELOCITY_LOOP[name]: float(value) for name, value in parameters.items() if name in VELOCITY_LOOP})


def _gains_of(limits: MultirotorLimits) -> dict[str, Value]:
    """What the velocity loop flies with, for whoever asks; the reference loop has no integral."""
    vertical = limits.velocity_gain_1_s if limits.vertical_gain_1_s is None else limits.vertical_gain_1_s
    gains: dict[str, Value] = {PLANAR: limits.velocity_gain_1_s, VERTICAL: vertical}
    if limits.integral_1_s2 is None:
        return {**gains, PLANAR_INTEGRAL: 0.0, VERTICAL_INTEGRAL: 0.0}
    return gains


def frame_limits(own: VehicleLimits) -> MultirotorLimits:
    """What the airframe can do: a little more than a profile's limits."""
    return MultirotorLimits(
        speed_max_m_s=_RESERVE * own.speed_max_m_s,
        climb_rate_max_m_s=_RESERVE * own.climb_rate_max_m_s,
        descent_rate_max_m_s=_RESERVE * own.sink_rate_max_m_s,
        acceleration_max_m_s2=_RESERVE * own.acceleration_max_m_s2,
        jerk_max_m_s3=_RESERVE * own.jerk_max_m_s3,
        yaw_rate_max_rad_s=_RESERVE * own.yaw_rate_max_rad_s,
        yaw_acceleration_max_rad_s2=_RESERVE * own.yaw_acceleration_max_rad_s2,
    )


def _numbers(count: int, shape: str) -> Callable[[str], tuple[float, ...]]:
    def parse(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        try:
            values = tuple(float(part) for part in parts)
        except ValueError:
            values = ()
        if len(values) != count or not all(math.isfinite(value) for value in values):
            raise argparse.ArgumentTypeError(f"'{text}' is not {shape}")
        return values

    return parse


def _address(text: str) -> tuple[str, int]:
    host, separator, port = text.rpartition(":")
    if not separator or not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise argparse.ArgumentTypeError(f"'{text}' is not HOST:PORT, for example 127.0.0.1:14540")
    try:
        return socket.gethostbyname(host), int(port)
    except OSError:
        raise argparse.ArgumentTypeError(f"'{text}': no address is known for the host '{host}'") from None


def _duration_s(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is not a time greater than 0 s")
    return value


def _system_id(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= 250:
        raise argparse.ArgumentTypeError(f"'{text}' is not a system id from 1 to 250")
    return int(text)


class _Parser(argparse.ArgumentParser):
    """Bad arguments end as InputError: one sentence, exit status 2."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="python -m flightapp.sim.mock_autopilot",
        description="A mock autopilot that speaks MAVLink to MAVSDK as PX4 does.",
        epilog=_EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--mission", type=Path, help="mission file: system id, start, datum, wind, fault script")
    parser.add_argument("--vehicle", help="name of the vehicle in the mission")
    parser.add_argument("--profile", type=Path, help="profile: the frame can do a little more than its limits")
    parser.add_argument("--system-id", type=_system_id, help="MAVLink system id (default: the mission's, else 1)")
    parser.add_argument(
        "--send-to",
        type=_address,
        default=("127.0.0.1", 14540),
        metavar="HOST:PORT",
        help="where MAVSDK listens (default %(default)s)",
    )
    parser.add_argument(
        "--origin", type=_numbers(3, "LATITUDE,LONGITUDE,ALTITUDE"), metavar="LAT,LON,ALT", help="origin of the local frame"
    )
    parser.add_argument(
        "--start", type=_numbers(3, "NORTH,EAST,HEADING"), metavar="N,E,HEADING_DEG", help="start in the mission frame, m and deg"
    )
    parser.add_argument("--truth", type=Path, help="file for the true state (shared memory)")
    parser.add_argument("--scenario", type=Path, help="fault script (TOML); wins over the mission's")
    parser.add_argument("--param", action="append", default=[], metavar="NAME=VALUE", help="PX4 parameter; may be repeated")
    parser.add_argument("--seed", type=int, default=0, help="seed of noise, gusts and faults")
    parser.add_argument("--no-noise", action="store_true", help="a perfect position and velocity estimate")
    parser.add_argument("--slow-heartbeat", action="store_true", help="no extra heartbeat when mode or arming change")
    parser.add_argument("--log", type=Path, help="file for the events, JSON lines (default: standard output)")
    parser.add_argument("--duration-s", type=_duration_s, help="end after this time")
    parser.add_argument("--die-with-parent", action="store_true", help="end when the parent process ends (Linux)")
    return parser


def _die_with_parent() -> None:
    """Ask the kernel for SIGKILL when the parent ends."""
    if sys.platform == "linux":
        signal_on_parent_death(signal.SIGKILL)


def _run(arguments: argparse.Namespace) -> None:
    setup = setup_from(arguments)
    try:
        log_file = sys.stdout if arguments.log is None else arguments.log.open("w", encoding="utf-8")
    except OSError as error:
        raise InputError(f"--log {arguments.log}: cannot be written: {error.strerror}") from None
    event = EventLog(log_file)
    station, faults = make_station(setup, event)
    try:
        run = RealTime(station, arguments.send_to, arguments.truth)
    except OSError as error:
        raise InputError(f"--truth {arguments.truth}: cannot be written: {error.strerror}") from None
    stop: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda signum, _: stop.append(signum))
    host, port = arguments.send_to
    event({"t_s": 0.0, "event": "started", "system_id": setup.system_id, "send_to": f"{host}:{port}"})
    try:
        run.run(lambda: bool(stop), arguments.duration_s)
    finally:
        run.close()
        for active in faults.unfelt():
            began = active.began_s is not None
            event(
                {"t_s": station.core.t_s, "event": "fault_not_felt", "index": active.index, "fault": active.name, "began": began}
            )
        event({"t_s": round(station.core.t_s, 3), "event": "stopped"})
        if arguments.log is not None:
            log_file.close()


def main(argv: Sequence[str] | None = None) -> int:
    """Run one mock; 0 after a clean end, 2 on bad input."""
    try:
        arguments = _parser().parse_args(argv)
        if arguments.die_with_parent:
            _die_with_parent()
        _run(arguments)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
