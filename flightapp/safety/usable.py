"""What stands in a context that no guard could count with, replaced by the careful reading of it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from flightapp.core.types import Array, ObstacleSet, TargetTrack, TeamMember
from flightapp.safety.api import SafetyContext

DISC_NUMBERS = 5
"""Place, radius and velocity; heights may be infinite."""
FAR_M = 1e6
ALL_AROUND = np.array([[-math.pi, math.pi]])


def usable(context: SafetyContext) -> SafetyContext:
    """`context` in which every number that guards compute with is finite and of a size that can be squared; itself if it was.

    - Obstacles or unseen sectors that are not: nothing is known, so no obstacle picture at all.
    - A teammate or an evader that is not: dropped, as if never heard of. Its age becomes infinite where it is not a number.
    - The setpoint sent last that is not: none was sent. A battery that is not a fraction: not known.
    """
    changes: dict[str, object] = {}
    previous, battery = context.previous, context.battery_fraction
    obstacles = context.obstacles
    if not (bool((np.abs(obstacles.discs[:, :DISC_NUMBERS]) < FAR_M).all()) and _are_usable(obstacles.unseen.ravel())):
        changes |= {"obstacles": ObstacleSet(obstacles.t_s, np.zeros((0, 7)), ALL_AROUND), "obstacles_age_s": math.inf}
    team = tuple(_known_age(member) for member in context.team if _is_usable(member))
    if len(team) != len(context.team) or any(one is not other for one, other in zip(team, context.team, strict=True)):
        changes["team"] = team
    if context.target is not None and not _is_usable(context.target):
        changes["target"] = None
    if previous is not None and not (_are_usable(previous.velocity_ned_m_s) and math.isfinite(previous.yaw_rad)):
        changes["previous"] = None
    if battery is not None and not 0.0 <= battery <= 1.0:
        changes["battery_fraction"] = None
    return dataclasses.replace(context, **changes) if changes else context  # type: ignore[arg-type]


def _are_usable(numbers: Array) -> bool:
    """Of a few numbers, (n,): a sum is NaN or infinite when one of them is."""
    return bool(sum(map(abs, numbers.tolist())) < FAR_M)


def _is_usable(known: TeamMember | TargetTrack) -> bool:
    state = known.state if isinstance(known, TeamMember) else known
    return _are_usable(state.position_ned_m) and _are_usable(state.velocity_ned_m_s)


def _known_age(member: TeamMember) -> TeamMember:
    return dataclasses.replace(member, age_s=math.inf) if math.isnan(member.age_s) else member
