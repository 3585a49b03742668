"""The simulated depth camera of one vehicle, a process of its own:

    python -m flightapp.sim.camera --mission M --profile P --vehicle NAME --truth FILE --output FILE --seed N

Reads the vehicle's true state at the camera's rate, renders what the camera sees from there and publishes it as shared memory.
"""

from __future__ import annotations

import argparse
import math
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flightapp.config.mission import load_mission
from flightapp.config.profile import Camera, load_profile
from flightapp.core.clock import monotonic_ns
from flightapp.core.errors import InputError
from flightapp.core.parent_death import signal_on_parent_death
from flightapp.core.types import Array
from flightapp.sim.truth import Truth, TruthReader
from flightapp.sim.world import World
from perception.geometry import camera_pose
from perception.sources.shared_memory import SharedMemoryWriter
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.types import Intrinsics, VehiclePose

FaultKind = Literal["off", "stuck", "zero"]

_FAULTS: tuple[FaultKind, ...] = ("off", "stuck", "zero")
_TRUTH_TIMEOUT_S = 30.0
_POLL_S = 0.02


@dataclass(frozen=True, slots=True)
class Fault:
    """From `at_s` after the first frame on: off = no more frames, stuck = the same image again and again, zero = no return."""

    kind: FaultKind
    at_s: float


def parse_fault(text: str) -> Fault:
    """KIND@T_S, for example zero@12.5."""
    kind, separator, at = text.partition("@")
    try:
        at_s = float(at)
    except ValueError:
        at_s = math.nan
    for known in _FAULTS:
        if separator and kind == known and math.isfinite(at_s) and at_s >= 0:
            return Fault(known, at_s)
    raise InputError(f"--fault = '{text}': write off@T_S, stuck@T_S or zero@T_S with T_S in seconds, for example zero@12.5")


def intrinsics_of(camera: Camera) -> Intrinsics:
    """The pinhole camera of a profile."""
    return Intrinsics(
        camera.width_px,
        camera.height_px,
        camera.focal_length_x_px,
        camera.focal_length_y_px,
        camera.principal_point_x_px,
        camera.principal_point_y_px,
    )


class SimulatedCamera:
    """Turns true states into depth images."""

    def __init__(self, world: World, camera: Camera, *, body_radius_m: float, seed: int, fault: Fault | None = None) -> None:
        self._renderer = DepthRenderer(world, intrinsics_of(camera), range_min_m=camera.range_min_m, seed=seed)
        self._mounting = camera.mounting
        self._body_radius_m = body_radius_m
        self._fault = fault
        self._first_ns: int | None = None
        self._number = 0
        self._last: NDArray[np.uint16] | None = None

    def shoot(self, own: Truth, others: Sequence[Truth]) -> NDArray[np.uint16] | None:
        """The image at `own`'s time; None when the camera is off."""
        if self._first_ns is None:
            self._first_ns = own.monotonic_ns
        fault = self._fault
        if fault is not None and (own.monotonic_ns - self._first_ns) * 1e-9 >= fault.at_s and self._last is not None:
            if fault.kind == "off":
                return None
            return self._last if fault.kind == "stuck" else np.zeros_like(self._last)
        pose = VehiclePose(own.position_ned_m, own.velocity_ned_m_s, own.roll_rad, own.pitch_rad, own.yaw_rad)
        self._number += 1
        self._last = self._renderer.render(camera_pose(pose, self._mounting), self._number, self._spheres(others))
        return self._last

    def _spheres(self, others: Sequence[Truth]) -> Array:
        return np.array([(*other.position_ned_m, self._body_radius_m) for other in others], np.float64).reshape(-1, 4)


class _Stop:
    """Set by SIGTERM or SIGINT."""

    def __init__(self) -> None:
        self.is_set = False
        signal.signal(signal.SIGTERM, self._set)
        signal.signal(signal.SIGINT, self._set)

    def _set(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.is_set = True


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    options = _parser().parse_args(arguments)
    if options.die_with_parent:
        signal_on_parent_death(signal.SIGKILL)
    stop = _Stop()
    try:
        mission, profile = load_mission(options.mission), load_profile(options.profile)
        try:
            mission.vehicle(options.vehicle)
        except KeyError:
            known = ", ".join(vehicle.name for vehicle in mission.vehicles)
            raise InputError(f"--vehicle = '{options.vehicle}': not in {options.mission}; known: {known}") from None
        fault = None if options.fault is None else parse_fault(options.fault)
        camera = SimulatedCamera(
            World(mission.obstacles),
            profile.camera,
            body_radius_m=profile.limits.body_radius_m,
            seed=options.seed,
            fault=fault,
        )
        own = _open_truth(options.truth, stop)
        others = [_open_truth(path, stop) for path in options.other_truth]
        if stop.is_set:
            return 0
        try:
            writer = SharedMemoryWriter(options.output, intrinsics_of(profile.camera), DEPTH_UNIT_M)
        except OSError as error:
            raise InputError(f"--output = '{options.output}': cannot be written: {error.strerror}") from None
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    _run(camera, own, others, writer, round(1e9 / profile.camera.rate_hz), stop)
    writer.close()
    return 0


def _run(
    camera: SimulatedCamera,
    own: TruthReader,
    others: Sequence[TruthReader],
    writer: SharedMemoryWriter,
    period_ns: int,
    stop: _Stop,
) -> None:
    """Shoot once a period on an absolute schedule; periods that were missed are left out, not made up for."""
    due_ns = monotonic_ns()
    last_ns = -1
    while not stop.is_set:
        truth = own.read()
        if truth is not None and truth.monotonic_ns != last_ns:
            last_ns = truth.monotonic_ns
            image = camera.shoot(truth, [other for other in (reader.read() for reader in others) if other is not None])
            if image is not None:
                writer.write(image, truth.monotonic_ns)
        now_ns = monotonic_ns()
        due_ns += period_ns * max(1, -(-(now_ns - due_ns) // period_ns))
        time.sleep((due_ns - now_ns) * 1e-9)


def _open_truth(path: Path, stop: _Stop) -> TruthReader:
    """The reader of a truth file, which its writer may still have to create."""
    deadline_ns = monotonic_ns() + round(_TRUTH_TIMEOUT_S * 1e9)
    while True:
        try:
            return TruthReader(path)
        except (OSError, ValueError):
            if stop.is_set or monotonic_ns() > deadline_ns:
                raise InputError(
                    f"{path}: no true state came within {_TRUTH_TIMEOUT_S:g} s; is the mock autopilot running?"
                ) from None
            time.sleep(_POLL_S)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m flightapp.sim.camera", description="Simulated depth camera of one vehicle.")
    parser.add_argument("--mission", type=Path, required=True)
    parser.add_argument("--profile", type=Path, required=True)
    parser.add_argument("--vehicle", required=True, help="name of the vehicle in the mission")
    parser.add_argument("--truth", type=Path, required=True, help="file of the vehicle's true state")
    parser.add_argument("--other-truth", type=Path, action="append", default=[], help="file of another vehicle's (repeatable)")
    parser.add_argument("--output", type=Path, required=True, help="shared-memory file to publish depth frames in")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--fault", help="off@T_S, stuck@T_S or zero@T_S, T_S seconds after the first frame")
    parser.add_argument("--die-with-parent", action="store_true", help="be killed when the parent process ends")
    return parser


if __name__ == "__main__":
    sys.exit(main())
