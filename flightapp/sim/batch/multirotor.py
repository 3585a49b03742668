"""The velocity-controlled multirotor in the plane: the model of flightapp.sim.multirotor, in flight, without its faults."""

from __future__ import annotations

import math

import numba

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.sim.batch.noise import normal
from flightapp.sim.batch.records import FRAME_TYPE, VEHICLE_TYPE, WORLD_TYPE, Records

YAW_GAIN_1_S = 3.0
YAW_BRAKING_SHARE = 0.8


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, numba.int64, numba.int64))
def blow(world: Records, vehicles: Records, i: int, step: int) -> None:
    """The gust at vehicle `i` after sub-step `step`: first-order Gauss-Markov."""
    w = world[0]
    decay = math.exp(-w.sub_step_s / w.gust_correlation_s)
    kick = w.gust * math.sqrt(1.0 - decay * decay)
    vehicles[i].gust_n = decay * vehicles[i].gust_n + kick * normal(w.wind_key, step, i, 0)
    vehicles[i].gust_e = decay * vehicles[i].gust_e + kick * normal(w.wind_key, step, i, 1)


@compiled(numba.void(VEHICLE_TYPE, FRAME_TYPE, numba.int64, *[numba.float64] * 6))
def fly_frame(
    vehicles: Records,
    frames: Records,
    i: int,
    command_n: float,
    command_e: float,
    yaw_rad: float,
    wind_n: float,
    wind_e: float,
    step_s: float,
) -> None:
    """Vehicle `i` for one sub-step under a velocity command (m/s) in the air that moves with the wind (m/s)."""
    v, frame = vehicles[i], frames[i]
    drag_n, drag_e = frame.drag_1_s * (wind_n - v.vn), frame.drag_1_s * (wind_e - v.ve)
    size = math.hypot(command_n, command_e)
    scale = frame.speed_max / size if size > frame.speed_max else 1.0
    wanted_n = frame.gain_1_s * (scale * command_n - v.vn) - v.taken_out_n
    wanted_e = frame.gain_1_s * (scale * command_e - v.ve) - v.taken_out_e
    size = math.hypot(wanted_n, wanted_e)
    scale = frame.frame_acceleration / size if size > frame.frame_acceleration else 1.0
    blend = step_s / (frame.response_s + step_s)
    change_n, change_e = blend * (scale * wanted_n - v.an), blend * (scale * wanted_e - v.ae)
    size, reach = math.hypot(change_n, change_e), frame.frame_jerk * step_s
    scale = reach / size if size > reach else 1.0
    v.an += scale * change_n
    v.ae += scale * change_e
    learn = step_s / frame.estimate_s
    v.taken_out_n += learn * (drag_n - v.taken_out_n)
    v.taken_out_e += learn * (drag_e - v.taken_out_e)
    after_n, after_e = v.vn + (v.an + drag_n) * step_s, v.ve + (v.ae + drag_e) * step_s
    v.n += 0.5 * step_s * (v.vn + after_n)
    v.e += 0.5 * step_s * (v.ve + after_e)
    v.vn, v.ve = after_n, after_e
    error = wrapped_rad(yaw_rad - v.yaw)
    rate = min(YAW_GAIN_1_S * abs(error), YAW_BRAKING_SHARE * math.sqrt(2.0 * frame.yaw_acceleration_max * abs(error)))
    rate = math.copysign(min(rate, frame.yaw_rate_max), error)
    reach = frame.yaw_acceleration_max * step_s
    v.yaw_rate += min(reach, max(-reach, rate - v.yaw_rate))
    v.yaw = wrapped_rad(v.yaw + v.yaw_rate * step_s)
