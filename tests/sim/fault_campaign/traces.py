"""Traces in which everything is right, for tests to break one thing in."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.config.mission import load_mission
from flightapp.core.types import Limits
from flightapp.sim.fault_campaign.trace import InjectionReport, RecordingCheck, SentSetpoint, Trace, VehicleTrace

ROOT = Path(__file__).parents[3]
DEMO = ROOT / "missions/demo_two_pursuers.toml"
LIMITS = Limits(
    speed_max_m_s=5.0,
    acceleration_max_m_s2=5.0,
    jerk_max_m_s3=40.0,
    yaw_rate_max_rad_s=3.0,
    yaw_acceleration_max_rad_s2=12.0,
    climb_rate_max_m_s=2.0,
    body_radius_m=0.35,
    safety_margin_m=0.45,
)
PERIOD_S = 0.02
STEPS = 500


def calm_trace(*injections: InjectionReport) -> Trace:
    """Ten seconds of the demo mission in which every vehicle flies 1 m to the north in 5 m height, and stands in the end."""
    mission = load_mission(DEMO)
    vehicles = {}
    for vehicle in mission.vehicles:
        t_s = PERIOD_S * np.arange(STEPS)
        states = np.zeros((STEPS, 7))
        states[:, 0] = t_s
        states[:, 1], states[:, 2], states[:, 3] = vehicle.start.north_m + 0.1 * t_s, vehicle.start.east_m, -5.0
        states[:, 4] = 0.1
        armed, on_ground = np.ones(STEPS, dtype=np.bool_), np.zeros(STEPS, dtype=np.bool_)
        states[-1, 3], armed[-1], on_ground[-1] = 0.0, False, True
        vehicles[vehicle.name] = VehicleTrace(
            vehicle=vehicle,
            limits=LIMITS,
            states=states,
            armed=armed,
            on_ground=on_ground,
            setpoints=[SentSetpoint(float(at_s), (0.1, 0.0, 0.0), 0.0, ()) for at_s in t_s[:-1]],
            transmitted_s=t_s[:-1].tolist(),
            recordings=[RecordingCheck(Path(f"{vehicle.name}.mcap"), 1000, "")],
        )
    return Trace(0, mission, vehicles, injections)


def felt(kind: str, vehicle: str, at_s: float, *, excuses: bool) -> InjectionReport:
    return InjectionReport(kind, vehicle, at_s, at_s, excuses)
