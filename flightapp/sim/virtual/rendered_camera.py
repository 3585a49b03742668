"""The depth camera on the virtual clock: real pictures of the mission's world, through the runtime's own perception."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.clock import Clock
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.sim.autopilot_core import AutopilotCore
from flightapp.sim.camera import SimulatedCamera, intrinsics_of
from flightapp.sim.truth import Truth
from flightapp.sim.world import World
from flightapp.vehicle.pose_history import PoseHistory
from perception.pipeline import PerceptionPipeline
from perception.sources import SourceHealth
from perception.synthetic.depth_renderer import DEPTH_UNIT_M
from perception.types import DepthFrame

LATENCY_S = 0.01
"""From the capture until the frame is there."""


class RenderedSource:
    """A depth source whose frames are rendered when `shoot` is called, and arrive a moment later."""

    def __init__(self, mission: Mission, profile: Profile, clock: Clock, seed: int) -> None:
        self._camera = SimulatedCamera(
            World(mission.obstacles), profile.camera, body_radius_m=profile.limits.body_radius_m, seed=seed
        )
        self._intrinsics = intrinsics_of(profile.camera)
        self._clock = clock
        self._underway: DepthFrame | None = None
        self._received = 0

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received)

    @property
    def is_finished(self) -> bool:
        return False

    def shoot(self, own: AutopilotCore, others: Sequence[AutopilotCore]) -> None:
        """Take the picture from where `own` truly is."""
        now_s = self._clock.now_s()
        image = self._camera.shoot(_truth(own, now_s), [_truth(other, now_s) for other in others])
        if image is not None:
            self._underway = DepthFrame(now_s, self._received + 1, image, DEPTH_UNIT_M, self._intrinsics)

    def latest(self) -> DepthFrame | None:
        frame = self._underway
        if frame is None or self._clock.now_s() < frame.t_s + LATENCY_S:
            return None
        self._underway = None
        self._received += 1
        return frame

    def close(self) -> None:
        self._underway = None


def perception_of(
    source: RenderedSource,
    vehicle: Vehicle,
    profile: Profile,
    history: PoseHistory,
    clock: Clock,
    on_result: Callable[[], None],
) -> PerceptionThread:
    """The runtime's perception on `source`; never started as a thread, `step` is called instead."""
    camera = profile.camera
    pipeline = PerceptionPipeline(
        profile.perception,
        camera.mounting,
        range_min_m=camera.range_min_m,
        range_max_m=camera.range_max_m,
        ground_down_m=-vehicle.start.ground_height_m,
    )
    return PerceptionThread(source, pipeline, history, clock, on_result, 1.0 / profile.autopilot.telemetry_rate_hz)


def _truth(core: AutopilotCore, now_s: float) -> Truth:
    vehicle = core.vehicle
    return Truth(
        round(now_s * 1e9),
        vehicle.position_ned_m,
        vehicle.velocity_ned_m_s,
        vehicle.roll_rad,
        vehicle.pitch_rad,
        vehicle.yaw_rad,
        core.armed,
        vehicle.on_ground,
    )
