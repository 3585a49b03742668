"""A clean offboard flight as PX4 logs it, to inject faults into."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.analysis.ulog.writer import UlogWriter

LENGTH_S, TAKEOFF_S, LANDED_S, OFFBOARD_S, OFFBOARD_END_S = 60.0, 5.0, 54.0, 10.0, 48.0
DELAY_S = 0.3


def velocity(t_s: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """What is asked for: turns that do not repeat, while in offboard."""
    active = (t_s > OFFBOARD_S) & (t_s < OFFBOARD_END_S)
    north = 2.0 * np.sin(0.9 * t_s) + np.sin(0.37 * t_s + 0.004 * t_s**2)
    east = 1.5 * np.cos(0.7 * t_s + 0.01 * t_s**2)
    down = 0.4 * np.sin(0.5 * t_s)
    return np.where(active[:, None], np.column_stack([north, east, down]), 0.0)


def clean_flight() -> UlogWriter:
    log = UlogWriter()
    log.parameters = {
        "BAT_LOW_THR": 0.15,
        "BAT_CRIT_THR": 0.07,
        "COM_LOW_BAT_ACT": 2.0,
        "COM_OF_LOSS_T": 1.0,
        "EKF2_GPS_CTRL": 7.0,
    }
    fast, slow = np.arange(0.0, LENGTH_S, 0.1), np.arange(0.0, LENGTH_S, 0.5)
    flying = (slow >= TAKEOFF_S) & (slow < LANDED_S)
    offboard = (slow >= OFFBOARD_S) & (slow < OFFBOARD_END_S)
    mode = np.where(offboard, 14, np.where(slow < OFFBOARD_S, 17, 18))
    achieved = velocity(fast - DELAY_S)
    log.topic(
        "vehicle_status",
        slow,
        arming_state=np.where((slow >= 2.0) & (slow < 56.0), 2, 1),
        nav_state=mode,
        nav_state_user_intention=mode,
        failsafe=0,
        failure_detector_status=0,
        gcs_connection_lost=0,
    )
    log.topic("vehicle_land_detected", slow, landed=~flying)
    log.topic(
        "vehicle_local_position",
        fast,
        vx=achieved[:, 0],
        vy=achieved[:, 1],
        vz=achieved[:, 2],
        z=np.where((fast >= TAKEOFF_S) & (fast < LANDED_S), -10.0, 0.0),
        eph=0.5,
        xy_valid=1,
        v_xy_valid=1,
        z_valid=1,
        dead_reckoning=0,
        xy_reset_counter=2,
        vxy_reset_counter=1,
        z_reset_counter=1,
        heading_reset_counter=1,
    )
    wanted = velocity(fast)
    log.topic("trajectory_setpoint", fast, velocity__0=wanted[:, 0], velocity__1=wanted[:, 1], velocity__2=wanted[:, 2])
    log.topic("offboard_control_mode", fast[(fast > 8.0) & (fast < OFFBOARD_END_S + 1.0)], velocity=1)
    log.topic(
        "battery_status", fast, voltage_v=15.6 - 0.01 * fast, remaining=0.9 - 0.005 * fast, cell_count=4, warning=0, connected=1
    )
    log.topic("system_power", slow, voltage5v_v=5.1, brick_valid=1, usb_connected=0)
    log.topic(
        "vehicle_gps_position",
        slow,
        fix_type=3,
        satellites_used=18,
        eph=0.8,
        jamming_indicator=5,
        jamming_state=1,
        spoofing_state=1,
        noise_per_ms=90,
    )
    log.topic(
        "estimator_status",
        slow,
        pos_test_ratio=0.1,
        vel_test_ratio=0.1,
        hgt_test_ratio=0.1,
        mag_test_ratio=0.1,
        filter_fault_flags=0,
    )
    log.topic("estimator_status_flags", slow, cs_mag_field_disturbed=0)
    log.topic(
        "failsafe_flags",
        slow,
        offboard_control_signal_lost=slow < 8.0,
        manual_control_signal_lost=0,
        geofence_breached=0,
        battery_unhealthy=0,
        attitude_invalid=0,
        global_position_invalid=0,
    )
    log.topic("telemetry_status", slow, rx_message_lost_rate=0.1)
    log.topic(
        "vehicle_imu_status", slow, accel_vibration_metric=1.5, accel_clipping__0=0, accel_clipping__1=0, accel_clipping__2=0
    )
    log.topic("cpuload", slow, load=0.4)
    log.messages = [(2.0, 6, "[commander] Armed by external command"), (5.0, 6, "[commander] Takeoff detected")]
    return log
