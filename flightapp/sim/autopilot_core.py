"""The commander of the mock autopilot: arming, modes, failsafes, landing; pure, moved by `step`, no clock and no I/O.

It behaves as PX4 1.16 does where a companion computer can see it. `mode` is what is flown; `intended` is what was asked
for: after a failsafe that clears (setpoints come again) PX4 returns to the intended mode by itself.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from flightapp.sim.autopilot_estimator import Estimator
from flightapp.sim.autopilot_frames import Frames
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.autopilot_navigator import Estimate, Navigator, OffboardSetpoint
from flightapp.sim.autopilot_parameters import Parameters
from flightapp.sim.fault_script import ActiveFault, FaultEngine, Situation
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.multirotor import Command, Multirotor
from flightapp.sim.vehicle_faults import Battery, apply_to_gps, apply_to_motors

STEP_S = 0.005
READY_AFTER_S = 0.5
"""Time from power-up until the estimate is good and home is set."""
SETPOINT_FRESH_S = 0.5
"""A running setpoint stream is one whose last setpoint is not older."""
_COMMANDER_STEPS = 4
_NAVIGATOR_STEPS = 2
_IMPACT_M_S = 1.5

ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
TEMPORARILY_REJECTED = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
DENIED = mavlink.MAV_RESULT_DENIED
RESULTS = {
    "TEMPORARILY_REJECTED": TEMPORARILY_REJECTED,
    "DENIED": DENIED,
    "FAILED": mavlink.MAV_RESULT_FAILED,
}
EMERGENCY, CRITICAL, WARNING, INFO = 0, 2, 4, 6

Done = Callable[[int], None]
"""Told the MAV_RESULT of a command once it is known."""
EventSink = Callable[[dict[str, object]], None]


class AutopilotCore:
    """One vehicle: truth, estimate, commander. Give it `step()` every STEP_S."""

    def __init__(
        self,
        *,
        vehicle: Multirotor,
        estimator: Estimator,
        frames: Frames,
        parameters: Parameters,
        faults: FaultEngine,
        event: EventSink,
    ) -> None:
        self.vehicle = vehicle
        self.estimator = estimator
        self.frames = frames
        self.parameters = parameters
        self.faults = faults
        self.navigator = Navigator(parameters, vehicle.ground_down_m)
        self.t_s = 0.0
        self.steps = 0
        self.armed = False
        self.mode = Mode.HOLD
        self.intended = Mode.HOLD
        self.landed = True
        self.piloted = False
        """An RC transmitter is switched on."""
        self.failsafe = False
        self.battery = Battery()
        self.setpoint: OffboardSetpoint | None = None
        self.heartbeat_due = True
        self.heartbeat_on_change = True
        """Send an extra heartbeat at each change of mode or arming; PX4 does, but a lossy link may swallow it."""
        self.status_texts: deque[tuple[int, str]] = deque(maxlen=50)
        self.home_set = False
        self._event = event
        self._command = Command()
        self._armed_at_s = 0.0
        self._has_flown = False
        self._grounded_since_s: float | None = 0.0
        self._landed_since_s = 0.0
        self._later: list[tuple[float, Callable[[], None]]] = []
        self._mode_fault: ActiveFault | None = None
        self._battery_warned = 0
        self._outside_fence = False

    # -- what others see ------------------------------------------------------------------------------------------

    def estimate(self) -> Estimate:
        vehicle, estimator = self.vehicle, self.estimator
        p, v, dp, dv = vehicle.position_ned_m, vehicle.velocity_ned_m_s, estimator.position_error_m, estimator.velocity_error_m_s
        if vehicle.on_ground:
            dv = (0.0, 0.0, 0.0)
        return Estimate((p[0] + dp[0], p[1] + dp[1], p[2] + dp[2]), (v[0] + dv[0], v[1] + dv[1], v[2] + dv[2]), vehicle.yaw_rad)

    @property
    def position_valid(self) -> bool:
        return self.t_s >= READY_AFTER_S and self.estimator.horizontal_valid

    @property
    def setpoint_age_s(self) -> float:
        return math.inf if self.setpoint is None else self.t_s - self.setpoint.t_s

    @property
    def landed_state(self) -> int:
        if self.landed:
            return int(mavlink.MAV_LANDED_STATE_ON_GROUND)
        if self.mode is Mode.TAKEOFF:
            return int(mavlink.MAV_LANDED_STATE_TAKEOFF)
        if self.mode is Mode.LAND:
            return int(mavlink.MAV_LANDED_STATE_LANDING)
        return int(mavlink.MAV_LANDED_STATE_IN_AIR)

    def preflight_fault(self) -> str | None:
        """Why the vehicle may not be armed."""
        if not self.position_valid:
            return "Preflight Fail: no valid position estimate"
        if not self.estimator.gps.fix:
            return "Preflight Fail: GPS fix lost"
        if self.battery.remaining < float(self.parameters["BAT_CRIT_THR"]):
            return "Preflight Fail: Low battery"
        return None

    def status(self, severity: int, text: str) -> None:
        """A status text to the ground, and an event."""
        self.status_texts.append((severity, text[:50]))
        self._event({"t_s": round(self.t_s, 3), "event": "status_text", "severity": severity, "text": text})

    def after(self, delay_s: float, action: Callable[[], None]) -> None:
        self._later.append((self.t_s + delay_s, action))

    # -- commands -------------------------------------------------------------------------------------------------

    def command_arm(self, arm: bool, force: bool, done: Done) -> None:
        """Arm or disarm as COMMAND_LONG 400 asks, through the faults on arming."""
        fault = self.faults.on("arming")
        if fault is None or not fault.bites():
            done(self._arm(force) if arm else self._disarm(force))
            return
        fault.felt("arm" if arm else "disarm")
        if fault.verb == "garbage":
            done(fault.random.choice(tuple(RESULTS.values())))
        elif fault.verb == "wrong":
            done(ACCEPTED)
        elif fault.verb in ("slow", "delayed"):
            if fault.verb == "slow":
                done(ACCEPTED)
            answer: Done = (lambda _: None) if fault.verb == "slow" else done
            self.after(fault.get("delay_s"), lambda: answer(self._arm(force) if arm else self._disarm(force)))
        elif arm or fault.verb == "stuck":
            self.status(CRITICAL, "Preflight Fail: arming fault in the scenario")
            done(RESULTS[fault.get("result")])
        else:
            done(self._disarm(force))

    def command_mode(self, mode: Mode, done: Done, *, takeoff_height_m: float | None = None) -> None:
        """Change the mode as a command asks, through the faults on the mode."""

        def change() -> int:
            return self._change_mode(mode, takeoff_height_m)

        fault = self.faults.on("mode")
        if fault is None or fault.verb in ("wrong", "garbage") or not fault.bites():
            done(change())
            return
        fault.felt(f"command to {mode.name}")
        if fault.verb == "off":
            done(RESULTS[fault.get("result")])
        elif fault.verb == "slow":
            done(ACCEPTED)
            self.after(fault.get("delay_s"), lambda: _ignore(change()))
        elif fault.verb == "delayed":
            self.after(fault.get("delay_s"), lambda: done(change()))
        else:
            self.status(WARNING, f"Pilot keeps {self.mode.name}")
            done(TEMPORARILY_REJECTED)

    def pilot_takes(self, mode: Mode) -> None:
        """An RC pilot moves the mode switch (or the sticks)."""
        self.piloted = True
        self.intended = mode
        self._fly(mode, "pilot took over using sticks")
        self.status(INFO, "Pilot took over using sticks")

    def terminate(self, text: str) -> None:
        """Cut the motors, wherever the vehicle is."""
        self.status(EMERGENCY, text)
        self._set_armed(False)

    def set_home(self) -> None:
        self.navigator.home_ned_m = self.estimate().position_ned_m
        self.home_set = True

    def _arm(self, force: bool) -> int:
        if self.armed:
            return int(ACCEPTED)
        fault = None if force else self.preflight_fault()
        if fault is None and not force and self.intended in (Mode.LAND, Mode.RTL):
            fault = f"Preflight Fail: mode {self.intended.name} prevents arming"
        if fault is None and self.intended is Mode.OFFBOARD and self.setpoint_age_s > SETPOINT_FRESH_S:
            fault = "Preflight Fail: No offboard signal"
        if fault is not None:
            self.status(CRITICAL, fault)
            return int(TEMPORARILY_REJECTED)
        self.set_home()
        self._set_armed(True)
        self.navigator.enter(self.mode, self.estimate())
        self.status(INFO, "Armed by external command")
        return int(ACCEPTED)

    def _disarm(self, force: bool) -> int:
        if self.armed and not self.landed and not force:
            self.status(CRITICAL, "Disarming denied: not landed")
            return int(DENIED)
        if self.armed:
            self.status(INFO, "Disarmed by external command")
            self._set_armed(False)
        return int(ACCEPTED)

    def _set_armed(self, armed: bool) -> None:
        self.armed = armed
        self.vehicle.motors.running = armed
        self.heartbeat_due = True
        self._has_flown = False
        self._armed_at_s = self.t_s
        self.failsafe = False
        self._event({"t_s": round(self.t_s, 3), "event": "armed" if armed else "disarmed"})
        if not armed and self.intended in (Mode.LAND, Mode.RTL, Mode.TAKEOFF):
            self.intended = Mode.HOLD
        if not armed:
            self._fly(self.intended, "disarmed")

    def _change_mode(self, mode: Mode, takeoff_height_m: float | None = None) -> int:
        if mode is Mode.OFFBOARD and self.setpoint_age_s > SETPOINT_FRESH_S:
            self.status(CRITICAL, "Switching to Offboard is currently not available: no setpoints")
            return int(TEMPORARILY_REJECTED)
        if mode.needs_position and mode is not Mode.LAND and not self.position_valid:
            self.status(CRITICAL, f"Switching to {mode.name} is currently not available: no position")
            return int(TEMPORARILY_REJECTED)
        if mode in (Mode.MANUAL, Mode.ALTCTL, Mode.POSCTL) and not self.piloted:
            self.status(CRITICAL, f"Switching to {mode.name} is currently not available: no RC")
            return int(TEMPORARILY_REJECTED)
        self.intended = mode
        self.failsafe = False
        self.navigator.cruise_speed_m_s = None
        self._fly(mode, "command", takeoff_height_m=takeoff_height_m, again=mode in (Mode.TAKEOFF, Mode.HOLD))
        return int(ACCEPTED)

    def _fly(self, mode: Mode, reason: str, *, takeoff_height_m: float | None = None, again: bool = False) -> None:
        if mode is self.mode and not again:
            return
        if mode is not self.mode:
            self.heartbeat_due = True
            self._event({"t_s": round(self.t_s, 3), "event": "mode", "mode": mode.name, "from": self.mode.name, "reason": reason})
        self.mode = mode
        self.navigator.enter(mode, self.estimate(), takeoff_height_m=takeoff_height_m)

    # -- time -----------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Advance everything by STEP_S."""
        self.steps += 1
        self.t_s = self.steps * STEP_S
        vehicle = self.vehicle
        self.estimator.step(self.t_s, STEP_S, vehicle.position_ned_m)
        if self.steps % _COMMANDER_STEPS == 0:
            self._command_50_hz()
        if self.steps % _NAVIGATOR_STEPS == 0:
            self._command = self.navigator.command(
                _NAVIGATOR_STEPS * STEP_S,
                self.mode,
                self.estimate(),
                self.setpoint,
                piloted=self.piloted,
                positioned=self.position_valid,
            )
        vehicle.step(STEP_S, self._command, self.estimator.velocity_error_m_s)

    def _command_50_hz(self) -> None:
        speed = math.hypot(*self.vehicle.velocity_ned_m_s)
        self.faults.update(
            self.t_s, Situation(self.armed, self.mode.name, self.landed, self.vehicle.height_above_ground_m, speed)
        )
        apply_to_gps(self.faults.on("gps"), self.estimator, self.vehicle)
        apply_to_motors(self.faults.on("motors"), self.vehicle, self.armed)
        self._apply_mode_fault()
        if not self.home_set and self.position_valid:
            self.set_home()
        for item in tuple(self._later):
            if item[0] <= self.t_s:
                self._later.remove(item)
                item[1]()
        capacity_mah = float(self.parameters["BAT1_CAPACITY"])
        self.battery.drain(_COMMANDER_STEPS * STEP_S, capacity_mah, armed=self.armed, landed=self.landed)
        self.battery.measure(self.t_s, self.faults.on("battery"))
        jump = self.estimator.take_reset()
        if jump != (0.0, 0.0, 0.0):
            self.navigator.shift(jump)
            self._event({"t_s": round(self.t_s, 3), "event": "position_reset", "north_m": jump[0], "east_m": jump[1]})
        self._detect_landing()
        if self.armed:
            self._check_battery()
            self._check_fence()
            self._check_failsafes()
        if self.armed and self.mode is Mode.TAKEOFF and self.navigator.takeoff_done:
            self.intended = Mode.HOLD
            self._fly(Mode.HOLD, "take-off done")

    def _check_failsafes(self) -> None:
        """Loss of position, loss of setpoints, and the way back."""
        if not self.position_valid and self.mode.needs_position and self.mode is not Mode.LAND:
            self.intended = Mode.ALTCTL
            self.failsafe = True
            self.status(CRITICAL, "Failsafe activated: position estimate lost")
            self._fly(Mode.ALTCTL, "position estimate lost")
            return
        if self.intended is not Mode.OFFBOARD:
            return
        lost = self.setpoint_age_s > float(self.parameters["COM_OF_LOSS_T"])
        if lost and not self.failsafe:
            self.failsafe = True
            self.status(CRITICAL, "Failsafe activated: No offboard signal")
            action = int(self.parameters["COM_OBL_RC_ACT"])
            if action == 6:
                self.terminate("Failsafe: flight terminated")
            elif action == 7:
                self.terminate("Failsafe: disarmed")
            else:
                self._fly(_OFFBOARD_LOSS.get(action, Mode.POSCTL), "offboard setpoints lost")
        elif self.failsafe and not lost:
            self.failsafe = False
            self.status(INFO, "Failsafe cleared: offboard signal regained")
            self._fly(Mode.OFFBOARD, "offboard setpoints resumed")

    def _check_battery(self) -> None:
        remaining, action = self.battery.remaining, int(self.parameters["COM_LOW_BAT_ACT"])
        levels = (
            ("BAT_LOW_THR", WARNING, "Low"),
            ("BAT_CRIT_THR", CRITICAL, "Critical"),
            ("BAT_EMERGEN_THR", EMERGENCY, "Emergency"),
        )
        level = sum(remaining < float(self.parameters[name]) for name, _, _ in levels)
        if level <= self._battery_warned:
            return
        self._battery_warned = level
        _, severity, word = levels[level - 1]
        self.status(severity, f"{word} battery level")
        if level == 1 or action == 0 or self.landed:
            return
        mode = Mode.RTL if action == 1 or (action == 3 and level == 2) else Mode.LAND
        self.intended = mode
        self._fly(mode, f"{word.lower()} battery")

    def _check_fence(self) -> None:
        """The cylinder about home: GF_MAX_HOR_DIST, GF_MAX_VER_DIST, GF_ACTION."""
        far, high = float(self.parameters["GF_MAX_HOR_DIST"]), float(self.parameters["GF_MAX_VER_DIST"])
        if far <= 0.0 and high <= 0.0:
            return
        home, position = self.navigator.home_ned_m, self.estimate().position_ned_m
        outside = 0.0 < far < math.hypot(position[0] - home[0], position[1] - home[1]) or 0.0 < high < home[2] - position[2]
        entered, self._outside_fence = outside and not self._outside_fence, outside
        action = int(self.parameters["GF_ACTION"])
        if not entered or action == 0:
            return
        self.status(CRITICAL, "Geofence exceeded")
        if action == 4:
            self.terminate("Geofence: flight terminated")
        elif action in _FENCE_ACTION:
            self.intended = _FENCE_ACTION[action]
            self._fly(self.intended, "geofence exceeded")

    def _detect_landing(self) -> None:
        vehicle = self.vehicle
        if not vehicle.on_ground:
            self._grounded_since_s = None
            if self.landed:
                self.landed = False
                self.status(INFO, "Takeoff detected")
            self._has_flown = True
            return
        if self._grounded_since_s is None:
            self._grounded_since_s = self.t_s
            if vehicle.impact_speed_m_s > _IMPACT_M_S:
                self._event({"t_s": round(self.t_s, 3), "event": "impact", "speed_m_s": round(vehicle.impact_speed_m_s, 2)})
        if not self.landed and self.t_s - self._grounded_since_s >= float(self.parameters["LNDMC_TRIG_TIME"]):
            self.landed = True
            self._landed_since_s = self.t_s
            self.status(INFO, "Landing detected")
        if not self.armed or not self.landed:
            return
        limit_s, since_s = (
            (float(self.parameters["COM_DISARM_LAND"]), self._landed_since_s)
            if self._has_flown
            else (float(self.parameters["COM_DISARM_PRFLT"]), self._armed_at_s)
        )
        if limit_s > 0.0 and self.t_s - since_s >= limit_s:
            self.status(INFO, "Disarmed by landing" if self._has_flown else "Disarmed by auto preflight disarming")
            self._set_armed(False)

    # -- the pilot of the fault script -----------------------------------------------------------------------------

    def _apply_mode_fault(self) -> None:
        """The RC pilot of the scenario: takes the mode at the beginning, and again in each bad phase."""
        fault = self.faults.on("mode")
        if fault is None or fault.verb not in ("stuck", "wrong", "intermittent"):
            self._mode_fault = None
            return
        if not fault.bites():
            self._mode_fault = None
        elif self._mode_fault is not fault:
            self._mode_fault = fault
            fault.felt(f"pilot takes {fault.get('mode')}")
            self.pilot_takes(Mode[fault.get("mode")])


_OFFBOARD_LOSS = {0: Mode.POSCTL, 1: Mode.ALTCTL, 2: Mode.MANUAL, 3: Mode.RTL, 4: Mode.LAND, 5: Mode.HOLD}
_FENCE_ACTION = {2: Mode.HOLD, 3: Mode.RTL, 5: Mode.LAND}


def _ignore(_: int) -> None:
    """The result of a change that was acknowledged before it was made."""
