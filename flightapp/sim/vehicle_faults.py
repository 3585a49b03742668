"""What the verbs of a fault script do to the GPS receiver, the motors and the battery. Each says when it is felt."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from flightapp.sim.autopilot_estimator import Estimator, GpsFault
from flightapp.sim.fault_script import ActiveFault
from flightapp.sim.multirotor import Motors, Multirotor

_FLYING_A, _IDLING_A, _RESTING_A = 16.0, 3.0, 0.4
_MAH_PER_AS = 1.0 / 3.6


@dataclass(slots=True)
class Battery:
    """Charge as it is and as it is measured; fractions of full."""

    true_remaining: float = 1.0
    remaining: float = 1.0
    consumed_mah: float = 0.0
    current_a: float = _RESTING_A
    _history: deque[tuple[float, float]] = field(default_factory=deque)

    def voltage_v(self, cells: int) -> float:
        return cells * (3.5 + 0.7 * self.remaining) - 0.01 * self.current_a

    def drain(self, dt_s: float, capacity_mah: float, *, armed: bool, landed: bool) -> None:
        self.current_a = (_IDLING_A if landed else _FLYING_A) if armed else _RESTING_A
        used_mah = self.current_a * dt_s * _MAH_PER_AS
        self.consumed_mah += used_mah
        self.true_remaining = max(self.true_remaining - used_mah / capacity_mah, 0.0)

    def measure(self, t_s: float, fault: ActiveFault | None) -> None:
        """The charge that the autopilot sees."""
        if fault is None:
            self.remaining = self.true_remaining
            self._history.clear()
            return
        if fault.verb == "off":
            self.remaining = 0.0
        elif fault.verb == "wrong":
            self.remaining = fault.get("remaining")
        elif fault.verb == "garbage":
            self.remaining = fault.random.random()
        elif fault.verb == "delayed":
            self._history.append((t_s, self.true_remaining))
            while len(self._history) > 1 and self._history[1][0] <= t_s - fault.get("delay_s"):
                self._history.popleft()
            self.remaining = self._history[0][1]
        elif fault.verb != "stuck":
            self.remaining = self.true_remaining
        if abs(self.remaining - self.true_remaining) > 1e-6:
            fault.felt("wrong charge")


def apply_to_gps(fault: ActiveFault | None, estimator: Estimator, vehicle: Multirotor) -> None:
    """Make the receiver as good or bad as the fault says."""
    if fault is None:
        if estimator.gps != GpsFault():
            estimator.gps = GpsFault()
        return
    gps = GpsFault()
    if fault.verb in ("off", "intermittent"):
        gps.fix = not fault.bites()
        if not gps.fix:
            fault.felt("no fix")
    elif fault.verb == "stuck":
        gps.stuck = True
    elif fault.verb == "garbage":
        gps.deviation_m = fault.get("deviation_m")
    elif fault.verb == "wrong":
        gps.offset_m = (fault.get("offset_m"), 0.0, 0.0)
    elif fault.verb == "slow":
        gps.divider = fault.get("factor")
    else:
        gps.delay_s = fault.get("delay_s")
    estimator.gps = gps
    true, seen = vehicle.position_ned_m, estimator.gps_position_ned_m
    if fault.felt_count == 0 and gps.fix and math.hypot(seen[0] - true[0], seen[1] - true[1]) > 0.1:
        fault.felt("the receiver reports a wrong position")


def apply_to_motors(fault: ActiveFault | None, vehicle: Multirotor, armed: bool) -> None:
    """Make the motors as good or bad as the fault says; felt in the air only."""
    motors = Motors(running=armed)
    vehicle.motors = motors
    if fault is None or not fault.bites():
        return
    felt = armed and not vehicle.on_ground
    if fault.verb in ("off", "intermittent"):
        motors.thrust_available = 0.0
    elif fault.verb == "slow":
        motors.thrust_available = fault.get("fraction")
        felt = felt and vehicle.thrust_short
    elif fault.verb == "stuck":
        motors.held = True
    elif fault.verb == "garbage":
        uniform = fault.random.uniform
        motors.thrust_available = uniform(0.3, 1.0)
        motors.bias_ned_m_s2 = (uniform(-3.0, 3.0), uniform(-3.0, 3.0), uniform(-3.0, 3.0))
    elif fault.verb == "wrong":
        motors.bias_ned_m_s2 = (fault.get("acceleration_m_s2"), 0.0, 0.0)
    else:
        motors.lag_s = fault.get("delay_s")
    if felt:
        fault.felt("thrust")
