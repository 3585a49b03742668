"""PX4's parameters that the mock knows, with PX4's defaults. Integers travel bytewise in MAVLink's float field."""

from __future__ import annotations

import difflib
import math
import struct
from collections.abc import Iterator

from flightapp.core.errors import InputError

Value = int | float

DEFAULTS: dict[str, Value] = {
    "BAT1_N_CELLS": 4,
    "BAT1_CAPACITY": 5000.0,
    "BAT_LOW_THR": 0.15,
    "BAT_CRIT_THR": 0.07,
    "BAT_EMERGEN_THR": 0.05,
    "COM_ARM_WO_GPS": 1,
    "COM_DISARM_LAND": 2.0,
    "COM_DISARM_PRFLT": 10.0,
    "COM_DL_LOSS_T": 10,
    "COM_FLTMODE1": -1,
    "COM_LOW_BAT_ACT": 0,
    "COM_OBL_RC_ACT": 0,
    "COM_OF_LOSS_T": 1.0,
    "COM_POS_FS_EPH": 5.0,
    "COM_RC_IN_MODE": 3,
    "COM_RC_LOSS_T": 0.5,
    "COM_RC_OVERRIDE": 1,
    "COM_RCL_EXCEPT": 0,
    "COM_TAKEOFF_ACT": 0,
    "EKF2_NOAID_TOUT": 5000000,
    "GF_ACTION": 2,
    "GF_MAX_HOR_DIST": 0.0,
    "GF_MAX_VER_DIST": 0.0,
    "GF_PREDICT": 0,
    "GF_SOURCE": 0,
    "LNDMC_TRIG_TIME": 1.0,
    "MAV_COMP_ID": 1,
    "MAV_PROTO_VER": 0,
    "MAV_SYS_ID": 1,
    "MAV_TYPE": 2,
    "MIS_TAKEOFF_ALT": 2.5,
    "MPC_ACC_DOWN_MAX": 3.0,
    "MPC_ACC_HOR": 3.0,
    "MPC_ACC_HOR_MAX": 5.0,
    "MPC_ACC_UP_MAX": 4.0,
    "MPC_JERK_AUTO": 4.0,
    "MPC_JERK_MAX": 8.0,
    "MPC_LAND_ALT1": 10.0,
    "MPC_LAND_ALT2": 5.0,
    "MPC_LAND_SPEED": 0.7,
    "MPC_TILTMAX_AIR": 45.0,
    "MPC_TKO_SPEED": 1.5,
    "MPC_XY_CRUISE": 5.0,
    "MPC_XY_P": 0.95,
    "MPC_XY_VEL_I_ACC": 0.4,
    "MPC_XY_VEL_MAX": 12.0,
    "MPC_XY_VEL_P_ACC": 1.8,
    "MPC_YAWRAUTO_MAX": 45.0,
    "MPC_Z_P": 1.0,
    "MPC_Z_V_AUTO_DN": 1.5,
    "MPC_Z_V_AUTO_UP": 3.0,
    "MPC_Z_VEL_I_ACC": 2.0,
    "MPC_Z_VEL_MAX_DN": 1.5,
    "MPC_Z_VEL_MAX_UP": 3.0,
    "MPC_Z_VEL_P_ACC": 4.0,
    "NAV_ACC_RAD": 10.0,
    "NAV_DLL_ACT": 0,
    "NAV_RCL_ACT": 2,
    "RTL_CONE_ANG": 45,
    "RTL_DESCEND_ALT": 30.0,
    "RTL_LAND_DELAY": 0.0,
    "RTL_MIN_DIST": 10.0,
    "RTL_RETURN_ALT": 60.0,
    "RTL_TYPE": 0,
    "SDLOG_MODE": 0,
    "SYS_AUTOSTART": 10040,
    "SYS_FAILURE_EN": 0,
    "SYS_HAS_GPS": 1,
}

MAV_PARAM_TYPE_INT32 = 6
MAV_PARAM_TYPE_REAL32 = 9


class Parameters:
    """The parameter table of one vehicle. A parameter keeps its type for life."""

    def __init__(self, overrides: dict[str, Value] | None = None) -> None:
        self._values: dict[str, Value] = dict(DEFAULTS)
        for name, value in (overrides or {}).items():
            self[name] = value

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __getitem__(self, name: str) -> Value:
        return self._values[name]

    def __setitem__(self, name: str, value: Value) -> None:
        self._values[name] = int(value) if isinstance(self._values[name], int) else _as_float32(value)

    def __len__(self) -> int:
        return len(self._values)

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def index(self, name: str) -> int:
        return list(self._values).index(name)

    def name_at(self, index: int) -> str | None:
        names = list(self._values)
        return names[index] if 0 <= index < len(names) else None

    def wire_type(self, name: str) -> int:
        return MAV_PARAM_TYPE_INT32 if isinstance(self._values[name], int) else MAV_PARAM_TYPE_REAL32

    def wire_value(self, name: str) -> float:
        """The value as MAVLink's float field carries it."""
        value = self._values[name]
        return float(struct.unpack("<f", struct.pack("<i", value))[0]) if isinstance(value, int) else value

    def set_from_wire(self, name: str, wire_value: float, wire_type: int) -> bool:
        """False where the type does not match or a real value is no number; the value stays then."""
        if wire_type != self.wire_type(name):
            return False
        if wire_type == MAV_PARAM_TYPE_INT32:
            (value,) = struct.unpack("<i", struct.pack("<f", wire_value))
            self._values[name] = value
            return True
        if not math.isfinite(wire_value):
            return False
        self._values[name] = wire_value
        return True


def parse_override(text: str) -> tuple[str, Value]:
    """(name, value) of a command-line `NAME=VALUE`; InputError where the name is unknown or the value is not of its type."""
    name, separator, raw = text.partition("=")
    if not separator:
        raise InputError(f"--param {text}: write NAME=VALUE, for example COM_OBL_RC_ACT=4")
    if name not in DEFAULTS:
        near = difflib.get_close_matches(name, DEFAULTS, n=1)
        right = f"did you mean {near[0]}?" if near else "the known ones stand in flightapp/sim/autopilot_parameters.py"
        raise InputError(f"--param {name}: the mock has no such parameter; {right}")
    kind = int if isinstance(DEFAULTS[name], int) else float
    try:
        value = kind(raw)
    except ValueError:
        raise InputError(f"--param {text}: {name} is {'an integer' if kind is int else 'a number'}, '{raw}' is not") from None
    if not math.isfinite(value):
        raise InputError(f"--param {text}: {name} must be finite")
    return name, value


def _as_float32(value: Value) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])
