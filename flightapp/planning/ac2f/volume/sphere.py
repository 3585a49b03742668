"""Apollonius regions in space: what a pursuer leaves to the evader, and its section at a height.

Points that the evader reaches no later than a pursuer with lambda times its speed are, where both are equally fast in all
directions, a ball. A multirotor climbs and sinks more slowly than it flies, so heights are stretched by s = speed / vertical
rate first: who needs as long for 1 m up as for s m ahead. In stretched heights the region is a ball again, in true ones an
ellipsoid. Climb and sink limits differ, which makes it no ellipsoid either: s is taken from the one that the pursuer needs to get
to the evader's height, the region beyond that height being a little too large or too small. The evader is taken to climb and
sink as the pursuer does, less by lambda.

A region is a row (kind, north, east, stretched down, radius, normal north, east, down): inside of a ball, a half-space whose edge
passes through the centre and whose normal points to the evader, or outside of a ball; kinds as in `apollonius_kernel`.
"""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.apollonius_kernel import DISC, EQUAL_SPEED, HALF_PLANE, OUTSIDE

SPACE_COLUMNS = 8
UPRIGHT = 1e-9
"""A half-space whose normal is nearer to the vertical than this has no edge at a height."""
TOUCH_M2 = 1e-9
"""A ball's section may be empty by this much: the top of a ball is a point."""


@compiled("void(f8,f8,f8,f8,f8,f8,f8,f8,f8[::1])")
def dominance_in_space(
    pursuer_n: float,
    pursuer_e: float,
    pursuer_d: float,
    evader_n: float,
    evader_e: float,
    evader_d: float,
    ratio: float,
    stretch: float,
    region: Array,
) -> None:
    """Fill `region` (8,): what a pursuer with the speed ratio lambda = `ratio` > 0 leaves to the evader.

    At equal heights centre and radius are those of the plane, bit for bit.
    """
    dn = evader_n - pursuer_n
    de = evader_e - pursuer_e
    dz = stretch * (evader_d - pursuer_d)
    evader_z = stretch * evader_d
    length = math.hypot(math.hypot(dn, de), dz)
    for c in range(5, 8):
        region[c] = 0.0
    if length > 0.0:
        region[5] = dn / length
        region[6] = de / length
        region[7] = dz / length
    if abs(ratio - 1.0) < EQUAL_SPEED and length > 0.0:
        region[0] = HALF_PLANE
        region[1] = (pursuer_n + evader_n) / 2
        region[2] = (pursuer_e + evader_e) / 2
        region[3] = evader_z - dz / 2
        region[4] = 0.0
    elif abs(ratio - 1.0) < EQUAL_SPEED:
        region[0] = DISC
        region[1] = evader_n
        region[2] = evader_e
        region[3] = evader_z
        region[4] = 0.0
    else:
        scale = 1.0 / (ratio * ratio - 1.0)
        region[0] = DISC if ratio > 1.0 else OUTSIDE
        region[1] = evader_n + dn * scale
        region[2] = evader_e + de * scale
        region[3] = evader_z + dz * scale
        region[4] = ratio * length * abs(scale)


@compiled("b1(f8[::1],f8,f8[::1])")
def section(region: Array, z: float, planar: Array) -> bool:
    """Fill `planar` (6,), as in `apollonius_kernel`, with the section of `region` at the stretched height; False: it is empty."""
    dz = z - region[3]
    planar[0] = region[0]
    planar[1] = region[1]
    planar[2] = region[2]
    planar[3] = 0.0
    planar[4] = 0.0
    planar[5] = 0.0
    if region[0] == HALF_PLANE:
        flat = math.hypot(region[5], region[6])
        ahead = region[7] * dz
        if flat < UPRIGHT:
            planar[0] = OUTSIDE
            return bool(ahead >= 0.0)
        planar[4] = region[5] / flat
        planar[5] = region[6] / flat
        planar[1] = region[1] - planar[4] * ahead / flat
        planar[2] = region[2] - planar[5] * ahead / flat
        return True
    rest_m2 = region[4] * region[4] - dz * dz
    if rest_m2 > 0.0:
        planar[3] = math.sqrt(rest_m2)
    return bool(region[0] == OUTSIDE or rest_m2 >= -TOUCH_M2)


@compiled("f8(f8[::1],f8,f8,f8)")
def depth_in_space_m(region: Array, n: float, e: float, z: float) -> float:
    """Distance of a place with stretched height inside the edge of `region`; negative outside."""
    dn = n - region[1]
    de = e - region[2]
    dz = z - region[3]
    if region[0] == HALF_PLANE:
        ahead: float = dn * region[5] + de * region[6] + dz * region[7]
        return ahead
    depth: float = region[4] - math.hypot(math.hypot(dn, de), dz)
    return depth if region[0] == DISC else -depth
