"""What the compiled simulation reads or writes by name: NumPy records in arrays, one row a vehicle, the evader last."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.planning.capture import CaptureRule
from flightapp.sim.batch.families.layout import Layout, Start
from flightapp.sim.batch.scenario import Scenario, Vehicle

Records = NDArray[np.void]

MODELS = ("unicycle", "multirotor", "single-integrator")
UNICYCLE, MULTIROTOR, SINGLE_INTEGRATOR = 0, 1, 2
FLYING, CAPTURED, COLLIDED, ESCAPED = 0, 1, 2, 3
OUTCOMES = ("timed_out", "captured", "collided", "escaped")
NOTHING, OBSTACLE, TEAMMATE = 0, 1, 2
COLLIDED_WITH = ("", "obstacle", "teammate")

VEHICLE = np.dtype(
    [
        ("n", "f8"),  # m
        ("e", "f8"),
        ("vn", "f8"),  # m/s
        ("ve", "f8"),
        ("yaw", "f8"),  # rad; of the unicycle: the course
        ("speed", "f8"),  # of the unicycle, m/s
        ("yaw_rate", "f8"),
        ("an", "f8"),  # acceleration by thrust, m/s2
        ("ae", "f8"),
        ("taken_out_n", "f8"),  # what the velocity loop believes of the disturbance, m/s2
        ("taken_out_e", "f8"),
        ("gust_n", "f8"),  # m/s
        ("gust_e", "f8"),
        ("before_n", "f8"),  # at the start of the sub-step
        ("before_e", "f8"),
        ("path_m", "f8"),
        ("turning", "f8"),  # sum of the changes of heading without their sign, rad
        ("course", "f8"),  # of the last control period in which it moved, rad; NaN: none yet
        ("gone", "i8"),  # 1: failed, out of the world
        ("last_vn", "f8"),  # velocity and mean acceleration of the last control period
        ("last_ve", "f8"),
        ("last_an", "f8"),
        ("last_ae", "f8"),
        ("jerk_sum", "f8"),  # of its magnitude, m/s3
        ("periods", "i8"),
    ],
    align=True,
)
FRAME = np.dtype(
    [
        ("model", "i8"),
        ("speed_max", "f8"),
        ("acceleration_max", "f8"),  # of the unicycle; the multirotor's frame has its own
        ("yaw_rate_max", "f8"),
        ("yaw_acceleration_max", "f8"),
        ("body_radius", "f8"),
        ("delay_steps", "i8"),
        ("response_s", "f8"),
        ("gain_1_s", "f8"),
        ("drag_1_s", "f8"),
        ("estimate_s", "f8"),
        ("frame_acceleration", "f8"),
        ("frame_jerk", "f8"),
    ],
    align=True,
)
SENSOR = np.dtype(
    [
        ("range", "f8"),
        ("half_view", "f8"),  # rad; pi: all around
        ("occlusion", "i8"),
        ("latency_steps", "i8"),
        ("position_noise", "f8"),
        ("radius_noise", "f8"),
        ("sees_vehicles", "i8"),
        ("sees_walls", "i8"),  # as the discs along them, the last of the discs
        ("gone", "i8"),
    ],
    align=True,
)
WORLD = np.dtype(
    [
        ("tick", "i8"),
        ("sub_step_s", "f8"),
        ("sub_steps", "i8"),
        ("moving", "i8"),  # so many of the discs, the first ones, move
        ("first", "i8"),  # 1: capture by the first pursuer; 0: by encirclement
        ("formation", "i8"),  # 1: encirclement means a regular polygon
        ("hold_radius", "f8"),
        ("hold_tolerance", "f8"),
        ("gap_tolerance", "f8"),  # rad
        ("radius", "f8"),
        ("zone", "f8"),
        ("gap_min", "f8"),  # deg
        ("dwell_s", "f8"),
        ("since_s", "f8"),  # NaN: not encircled
        ("solid", "i8"),
        ("wind_n", "f8"),
        ("wind_e", "f8"),
        ("gust", "f8"),
        ("gust_correlation_s", "f8"),
        ("wind_key", "u8"),
        ("sensing_key", "u8"),
        ("end_s", "f8"),
        ("collided_with", "i8"),
        ("clearance", "f8"),
        ("separation", "f8"),
        ("encircled", "i8"),  # whether the pursuers surround the evader now
        ("encircled_first_s", "f8"),  # NaN: never yet
        ("encircled_s", "f8"),  # for how long in all
        ("walls", "i8"),  # so many of the sensed discs, the last ones, stand for walls
        ("target_range", "f8"),
        ("target_latency_steps", "i8"),
        ("target_needs_sight", "i8"),
        ("target_seen", "i8"),
    ],
    align=True,
)


TYPES: Any = numba.types


def _passed(dtype: np.dtype[np.void]) -> Any:
    return TYPES.Array(numba.from_dtype(dtype), 1, "C")


VEHICLE_TYPE = _passed(VEHICLE)
FRAME_TYPE = _passed(FRAME)
SENSOR_TYPE = _passed(SENSOR)
WORLD_TYPE = _passed(WORLD)
PAIR_TYPE = TYPES.UniTuple(numba.float64, 2)

EVADER_RANGE_M = 15.0


def vehicle_records(layout: Layout) -> Records:
    """All vehicles, standing at their starts."""
    starts: tuple[Start, ...] = (*layout.pursuers, layout.evader)
    vehicles = np.zeros(len(starts), VEHICLE)
    for vehicle, start in zip(vehicles, starts, strict=True):
        vehicle["n"], vehicle["e"], vehicle["yaw"] = start.north_m, start.east_m, start.heading_rad
    vehicles["course"] = math.nan
    return vehicles


def frame_records(scenario: Scenario) -> Records:
    """What each vehicle can do."""
    kinds: list[Vehicle] = [scenario.pursuers] * scenario.pursuers.count + [scenario.evader]
    frames = np.zeros(len(kinds), FRAME)
    for frame, kind in zip(frames, kinds, strict=True):
        frame["model"] = MODELS.index(kind.model)
        frame["speed_max"], frame["acceleration_max"] = kind.speed_max_m_s, kind.acceleration_max_m_s2
        frame["yaw_rate_max"], frame["yaw_acceleration_max"] = kind.yaw_rate_max_rad_s, kind.yaw_acceleration_max_rad_s2
        frame["body_radius"] = kind.body_radius_m
        frame["delay_steps"] = round(kind.delay_s / scenario.sub_step_s)
        frame["response_s"], frame["drag_1_s"] = kind.response_s, kind.drag_1_s
        frame["estimate_s"] = kind.disturbance_estimate_s
        acceleration, jerk = kind.acceleration_max_m_s2 * kind.frame_reserve, kind.jerk_max_m_s3 * kind.frame_reserve
        frame["frame_acceleration"], frame["frame_jerk"] = acceleration, jerk
        frame["gain_1_s"] = min(kind.velocity_gain_1_s, 0.25 / kind.response_s, 0.9 * jerk / acceleration)
    return frames


def sensor_records(scenario: Scenario, sees_walls: bool) -> Records:
    """How each vehicle sees discs; the evader all around it. sees_walls: pursuers see the discs along walls, too."""
    sensing = scenario.sensing
    sensors = np.zeros(scenario.pursuers.count + 1, SENSOR)
    sensors["range"], sensors["half_view"] = sensing.range_m, math.radians(sensing.field_of_view_deg) / 2.0
    if sensing.kind == "depth":
        sensors["range"], sensors["half_view"] = sensing.camera.range_max_m, sensing.camera.field_of_view_rad / 2.0
    sensors["occlusion"], sensors["sees_vehicles"] = sensing.occlusion, sensing.sees_vehicles
    sensors["sees_walls"] = sees_walls
    sensors["latency_steps"] = round(sensing.latency_s / scenario.sub_step_s)
    sensors["position_noise"], sensors["radius_noise"] = sensing.position_noise_m, sensing.radius_noise_m
    evader = sensors[-1:]
    evader[:] = np.zeros(1, SENSOR)
    evader["range"], evader["half_view"] = EVADER_RANGE_M, math.pi
    return sensors


def world_record(scenario: Scenario, layout: Layout, wind_key: int, sensing_key: int) -> Records:
    """The rest, as one record (1,)."""
    world = np.zeros(1, WORLD)
    rule: CaptureRule = scenario.capture
    wind, target = scenario.wind, scenario.target
    values: dict[str, float] = {
        "sub_step_s": scenario.sub_step_s,
        "sub_steps": scenario.sub_steps,
        "moving": int((layout.discs[:, 3:5] != 0.0).any(axis=1).sum()),
        "first": rule.mode == "first",
        "formation": rule.mode == "formation",
        "hold_radius": rule.hold_radius_m,
        "hold_tolerance": rule.hold_tolerance_m,
        "gap_tolerance": math.radians(rule.gap_tolerance_deg),
        "radius": rule.radius_m,
        "zone": rule.zone_m,
        "gap_min": rule.angular_gap_min_deg,
        "dwell_s": rule.dwell_s,
        "since_s": math.nan,
        "solid": scenario.evader.solid,
        "wind_n": wind.north_m_s,
        "wind_e": wind.east_m_s,
        "gust": wind.gust_m_s,
        "gust_correlation_s": wind.gust_correlation_s,
        "wind_key": wind_key,
        "sensing_key": sensing_key,
        "clearance": math.inf,
        "separation": math.inf,
        "encircled_first_s": math.nan,
        "target_range": target.range_m,
        "target_latency_steps": round(target.latency_s / scenario.sub_step_s),
        "target_needs_sight": target.needs_sight,
        "target_seen": 1,
    }
    for name, value in values.items():
        world[name] = value
    return world
