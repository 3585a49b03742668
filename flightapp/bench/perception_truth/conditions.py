"""Under which circumstances perception is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from perception.synthetic.flaws import Cover, Flaws, Glare


@dataclass(frozen=True, slots=True)
class Condition:
    """Attitude and speed of the vehicle, flaws of the camera, error of the pose that perception is told.

    pose_error_deg: standard deviation of a constant error of each angle. pose_delay_s: how old the pose is.
    """

    name: str
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    speed_m_s: float = 0.0
    height_m: float = 5.0
    noise: bool = True
    flaws: Flaws = field(default_factory=Flaws)
    pose_error_deg: float = 0.0
    pose_delay_s: float = 0.0

    @property
    def pose_tolerance_m_per_m(self) -> float:
        """Sideways error of a perceived place at 1 m, as much as three standard deviations of the pose's angles explain."""
        return 3.0 * math.radians(self.pose_error_deg)

    @property
    def pose_tolerance_m(self) -> float:
        """Error of a perceived place that the pose's age explains."""
        return self.speed_m_s * self.pose_delay_s


GOOD = Condition("level, hovering")
CONDITIONS = (
    GOOD,
    *(Condition(f"roll {angle} deg", roll_deg=angle) for angle in (10, 20, 30)),
    *(Condition(f"nose down {angle} deg", pitch_deg=-angle) for angle in (10, 20, 30)),
    *(Condition(f"nose up {angle} deg", pitch_deg=angle) for angle in (10, 20, 30)),
    *(Condition(f"{speed} m/s", speed_m_s=speed) for speed in (2, 4, 8)),
    *(
        Condition(f"{speed} m/s, pose 1 deg and 20 ms off", speed_m_s=speed, pose_error_deg=1.0, pose_delay_s=0.02)
        for speed in (2, 4, 8)
    ),
    Condition("without noise", noise=False),
    Condition("exact edges", flaws=Flaws(window_px=1)),
    Condition("10 % holes", flaws=Flaws(hole_fraction=0.1)),
    Condition("30 % holes", flaws=Flaws(hole_fraction=0.3)),
    Condition("40 speckles a frame", flaws=Flaws(speckles=40)),
    Condition("glare over the middle", flaws=Flaws(glare=Glare(424.0, 240.0, 200.0))),
    Condition("lens covered, middle third", flaws=Flaws(cover=Cover(left=0.33, right=0.67))),
    Condition("lens covered, upper half", flaws=Flaws(cover=Cover(bottom=0.5))),
    Condition("lens covered, whole", flaws=Flaws(cover=Cover())),
)
QUICK_CONDITIONS = ("level, hovering", "roll 20 deg", "4 m/s", "lens covered, whole")
OPEN_FIELDS = (
    *(Condition(f"open field, {height} m high", height_m=height) for height in (3, 5, 10)),
    *(Condition(f"tree line at 12-25 m, {height} m high", height_m=height) for height in (3, 5, 10)),
    *(
        Condition(f"tree line, 40 speckles a frame, {height} m high", height_m=height, flaws=Flaws(speckles=40))
        for height in (3, 10)
    ),
    Condition("tree line, nose up 20 deg", pitch_deg=20.0),
    Condition("tree line, roll 20 deg", roll_deg=20.0),
)
