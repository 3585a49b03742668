"""PX4's flight modes and how they stand in a heartbeat."""

from __future__ import annotations

from enum import Enum


class Mode(Enum):
    """Flight mode; the value is (main mode, sub mode) of PX4's custom mode."""

    MANUAL = (1, 0)
    ALTCTL = (2, 0)
    """The pilot commands climb rate and tilt; no position control."""
    POSCTL = (3, 0)
    """The pilot commands velocities; position is held with the sticks centred."""
    OFFBOARD = (6, 0)
    """Setpoints of a companion computer."""
    TAKEOFF = (4, 2)
    HOLD = (4, 3)
    RTL = (4, 5)
    LAND = (4, 6)

    @property
    def custom_mode(self) -> int:
        main, sub = self.value
        return int(main) << 16 | int(sub) << 24

    @property
    def is_auto(self) -> bool:
        main, _ = self.value
        return int(main) == 4

    @property
    def needs_position(self) -> bool:
        return self not in (Mode.MANUAL, Mode.ALTCTL)


def mode_of(main: int, sub: int) -> Mode | None:
    """The mode with these numbers; the sub mode counts for AUTO modes only. None where PX4 has it and the mock has not."""
    for mode in Mode:
        if mode.value[0] == main and (main != 4 or mode.value[1] == sub):
            return mode
    return None
