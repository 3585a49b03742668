"""Names of PX4's flight modes: `vehicle_status.nav_state` (msg/VehicleStatus.msg, 1.13 to 1.16)."""

from __future__ import annotations

OFFBOARD = 14

_NAMES = {
    0: "manual",
    1: "altitude",
    2: "position",
    3: "mission",
    4: "hold",
    5: "return to launch",
    6: "slow position",
    10: "acro",
    12: "descend",
    13: "termination",
    OFFBOARD: "offboard",
    15: "stabilized",
    17: "take-off",
    18: "land",
    19: "follow target",
    20: "precision landing",
    21: "orbit",
    22: "VTOL take-off",
}


def mode_name(nav_state: int) -> str:
    """In the words of a pilot; the number where PX4 has a newer mode."""
    return _NAMES.get(nav_state, f"mode {nav_state}")
