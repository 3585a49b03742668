"""What each pursuer sees through a depth camera: rendered frames through the application's own perception."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flightapp.core.types import Array, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.sim.batch.moving_discs import disc_at
from flightapp.sim.batch.period import DOWN_M
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.world import World
from perception.geometry import CameraMounting, camera_pose
from perception.pipeline import PerceptionPipeline
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.synthetic.scene import Scene
from perception.types import DepthFrame, Intrinsics, VehiclePose

CUT_OUT_MARGIN_M = 0.4
"""As the application cuts other vehicles out of what it perceives."""
GRAVITY_M_S2 = 9.81
VEHICLE_NUMBERS = 1 << 32
"""Frame numbers, which pick the noise, of two vehicles are this far apart."""


class DepthSensing:
    """The cameras of all pursuers in one episode."""

    def __init__(self, scenario: Scenario, world: World, key: int) -> None:
        sensing, camera = scenario.sensing, scenario.sensing.camera
        self._scenario, self._world, self._key = scenario, world, key
        self._latency_steps = round(sensing.latency_s / scenario.sub_step_s)
        self._frame_steps = 1.0 / (camera.rate_hz * scenario.sub_step_s)
        self._number = 0
        self._intrinsics = Intrinsics(
            camera.width_px,
            camera.height_px,
            camera.focal_length_px,
            camera.focal_length_px,
            0.5 * camera.width_px,
            0.5 * camera.height_px,
        )
        self._mounting = CameraMounting(forward_m=camera.forward_m, pitch_deg=camera.pitch_deg)
        discs = world.discs
        self._cylinders = np.column_stack((discs[:, :3], np.full(len(discs), camera.obstacle_height_m)))
        scene = Scene(cylinders=self._cylinders)
        self._renderer = DepthRenderer(scene, self._intrinsics, range_min_m=camera.range_min_m)
        self._pipelines = [
            PerceptionPipeline(sensing.perception, self._mounting, range_min_m=camera.range_min_m, range_max_m=camera.range_max_m)
            for _ in range(scenario.pursuers.count)
        ]
        unknown = ObstacleSet(0.0, np.zeros((0, 7)), np.array([[-math.pi, math.pi]]))
        self._seen = [unknown] * scenario.pursuers.count

    def obstacles(self, tick: int, teams: Sequence[Sequence[TeamMember]], target: TargetTrack | None) -> list[ObstacleSet]:
        """What each pursuer perceived up to control period `tick`, of the frames that are through by then.

        teams: what each pursuer knows of its teammates; they and the target are cut out. Before the start everything stands.
        """
        newest = max(0, tick * self._scenario.sub_steps - self._latency_steps)
        while (step := round(self._number * self._frame_steps)) <= newest:
            t_s = step * self._scenario.sub_step_s
            self._move_cylinders(t_s)
            for i, pipeline in enumerate(self._pipelines):
                self._seen[i] = self._perceive(pipeline, i, step, _known_places(teams[i], target, t_s))
            self._number += 1
        return list(self._seen)

    def _perceive(self, pipeline: PerceptionPipeline, i: int, step: int, places: Array) -> ObstacleSet:
        """One frame of pursuer `i`, taken at `step`; places (k, 2) of other vehicles."""
        t_s = step * self._scenario.sub_step_s
        poses = self._world.poses[step % len(self._world.poses)]
        pose = self._pose(i, step)
        others = [
            (n, e, DOWN_M, radius)
            for j, (n, e) in enumerate(poses[:, :2].tolist())
            if j != i and (radius := self._body_radius_m(j)) > 0.0
        ]
        number = self._key % VEHICLE_NUMBERS + self._number + i * VEHICLE_NUMBERS
        image = self._renderer.render(camera_pose(pose, self._mounting), number, np.array(others, np.float64).reshape(-1, 4))
        frame = DepthFrame(t_s, self._number, image, DEPTH_UNIT_M, self._intrinsics)
        cut_out_m = self._scenario.pursuers.body_radius_m + CUT_OUT_MARGIN_M
        seen = pipeline.process(frame, pose, np.column_stack((places, np.full(len(places), cut_out_m))))
        return ObstacleSet(t_s, seen.discs, seen.unseen)

    def _body_radius_m(self, vehicle: int) -> float:
        scenario = self._scenario
        return (scenario.pursuers if vehicle < scenario.pursuers.count else scenario.evader).body_radius_m

    def _pose(self, i: int, step: int) -> VehiclePose:
        """True pose of pursuer `i` at `step`, tilted so that its thrust carries and accelerates it."""
        poses = self._world.poses
        n, e, vn, ve, yaw = poses[step % len(poses), i].tolist()
        roll, pitch = self._tilt(i, step, yaw)
        return VehiclePose((n, e, DOWN_M), (vn, ve, 0.0), roll, pitch, yaw)

    def _tilt(self, i: int, step: int, yaw_rad: float) -> tuple[float, float]:
        """Roll and pitch from the change of velocity: of a multirotor in the last sub-step, of a unicycle, whose velocity jumps,
        in the last control period."""
        scenario, poses = self._scenario, self._world.poses
        vehicle = scenario.pursuers
        back = 1 if vehicle.model == "multirotor" else scenario.sub_steps
        now, before = poses[step % len(poses), i, 2:4], poses[max(0, step - back) % len(poses), i, 2:4]
        thrust = (now - before) / (back * scenario.sub_step_s)
        if vehicle.model == "multirotor":
            thrust = thrust + vehicle.drag_1_s * (now - np.array((scenario.wind.north_m_s, scenario.wind.east_m_s)))
        north, east = thrust.tolist()
        size, most = math.hypot(north, east), GRAVITY_M_S2 * math.tan(math.radians(scenario.sensing.camera.tilt_max_deg))
        scale = most / size if size > most else 1.0
        forward = scale * (north * math.cos(yaw_rad) + east * math.sin(yaw_rad))
        right = scale * (east * math.cos(yaw_rad) - north * math.sin(yaw_rad))
        return math.atan2(right, math.hypot(forward, GRAVITY_M_S2)), -math.atan2(forward, GRAVITY_M_S2)

    def _move_cylinders(self, t_s: float) -> None:
        world = self._world
        for k in range(int(world.record["moving"][0])):
            self._cylinders[k, :2] = disc_at(world.discs, k, world.area, t_s)[:2]


def _known_places(team: Sequence[TeamMember], target: TargetTrack | None, t_s: float) -> Array:
    """(k, 2) north, east at `t_s` of the vehicles that are known of, moved there by their velocities."""
    known: list[VehicleState | TargetTrack] = [member.state for member in team]
    if target is not None:
        known.append(target)
    moved = [state.position_ned_m[:2] + (t_s - state.t_s) * state.velocity_ned_m_s[:2] for state in known]
    return np.array(moved, np.float64).reshape(-1, 2)
