"""Signed distance from a point to bodies, and the way out; kernels, exact for every shape.

Inside a body it is the depth below the nearest face, and the gradient leads out through that face; where two are equally near,
the choice is fixed. Sources: section 2.2 and 2.8 of the specifications of RRT*-APF and of the adaptive potential field.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.clearance import NO_OBSTACLE_M
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import (
    BODIES,
    BOTTOM,
    BOX,
    COS,
    CYLINDER,
    EAST,
    GAP,
    INDICES,
    KIND,
    LENGTH,
    NORTH,
    NUMBER,
    SIN,
    SPHERE,
    TOP,
    V_DOWN,
    V_EAST,
    V_NORTH,
    WHOLE,
    WIDTH,
)

NO_LENGTH = 1e-12
SCANNED = 16
"""Directions that are tried before the best is refined; a quarter of a turn."""
HALVINGS = 34
"""Refine the direction to 1e-11 rad."""
Gap = tuple[float, float, float, float]


@compiled(NUMBER(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def _support_slope(x: float, y: float, radius: float, dual: float, angle: float) -> float:
    """Derivative by `angle` of x cos + y sin - radius ||(cos, sin)||_dual."""
    c, s = math.cos(angle), math.sin(angle)
    norm: float = c**dual + s**dual
    slope: float = y * c - x * s - radius * norm ** (1.0 / dual - 1.0) * (s ** (dual - 1.0) * c - c ** (dual - 1.0) * s)
    return slope


@compiled(NUMBER(NUMBER, NUMBER, NUMBER, NUMBER))
def superellipse_direction(x: float, y: float, radius: float, exponent: float) -> float:
    """Angle of the outward normal that decides the distance of (x, y) >= 0 to |x/r|^(2/e) + |y/r|^(2/e) = 1.

    The signed distance to a convex figure is the largest of u.p - h(u) over unit vectors u, h its support function: here
    r times the dual norm of u. So no direction gives too great a distance.
    """
    dual = 2.0 / (2.0 - exponent)
    best, best_angle = -math.inf, 0.0
    for k in range(SCANNED + 1):
        angle = 0.5 * math.pi * k / SCANNED
        c, s = abs(math.cos(angle)), abs(math.sin(angle))
        value = x * c + y * s - radius * (c**dual + s**dual) ** (1.0 / dual)
        if value > best:
            best, best_angle = value, angle
    low = max(0.0, best_angle - 0.5 * math.pi / SCANNED)
    high = min(0.5 * math.pi, best_angle + 0.5 * math.pi / SCANNED)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _support_slope(x, y, radius, dual, middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled(GAP(BODIES, WHOLE, NUMBER, NUMBER, NUMBER))
def body_gap(bodies: Array, i: int, north: float, east: float, down: float) -> Gap:
    """Signed distance of a point to body `i` where its row says that it is, and the gradient (north, east, down)."""
    x, y = north - bodies[i, NORTH], east - bodies[i, EAST]
    length = bodies[i, LENGTH]
    kind = bodies[i, KIND]
    if kind == SPHERE:
        z = down - 0.5 * (bodies[i, TOP] + bodies[i, BOTTOM])
        distance = math.sqrt(x * x + y * y + z * z)
        if distance < NO_LENGTH:
            return -length, 1.0, 0.0, 0.0
        return distance - length, x / distance, y / distance, z / distance
    if kind != CYLINDER:
        cos, sin = bodies[i, COS], bodies[i, SIN]
        along, across = cos * x + sin * y, cos * y - sin * x
        ahead, right = abs(along), abs(across)
        if kind == BOX:
            ahead -= length
            right -= bodies[i, WIDTH]
            if ahead > 0.0 and right > 0.0:
                planar = math.sqrt(ahead * ahead + right * right)
                u, w = ahead / planar, right / planar
            elif ahead >= right:
                planar, u, w = ahead, 1.0, 0.0
            else:
                planar, u, w = right, 0.0, 1.0
        else:
            exponent = bodies[i, WIDTH]
            angle = superellipse_direction(ahead, right, length, exponent)
            u, w = math.cos(angle), math.sin(angle)
            dual = 2.0 / (2.0 - exponent)
            planar = ahead * u + right * w - length * (u**dual + w**dual) ** (1.0 / dual)
        u = math.copysign(u, along)
        w = math.copysign(w, across)
        un, ue = cos * u - sin * w, sin * u + cos * w
    else:
        distance = math.sqrt(x * x + y * y)
        planar = distance - length
        if distance < NO_LENGTH:
            un, ue = 1.0, 0.0
        else:
            un, ue = x / distance, y / distance
    above, below = bodies[i, TOP] - down, down - bodies[i, BOTTOM]
    ud = -1.0 if above >= below else 1.0
    vertical = max(above, below)
    if planar > 0.0 and vertical > 0.0:
        distance = math.sqrt(planar * planar + vertical * vertical)
        flat = planar / distance
        return distance, un * flat, ue * flat, ud * vertical / distance
    if planar >= vertical:
        return planar, un, ue, 0.0
    return vertical, 0.0, 0.0, ud


@compiled(GAP(BODIES, NUMBER, NUMBER, NUMBER, NUMBER))
def signed_distance_and_gradient(bodies: Array, north: float, east: float, down: float, t_s: float) -> Gap:
    """Of the nearest body at time `t_s`, the first of several; NO_OBSTACLE_M and no direction without bodies."""
    nearest = (NO_OBSTACLE_M, 0.0, 0.0, 0.0)
    for i in range(bodies.shape[0]):
        moved_n, moved_e, moved_d = bodies[i, V_NORTH] * t_s, bodies[i, V_EAST] * t_s, bodies[i, V_DOWN] * t_s
        gap = body_gap(bodies, i, north - moved_n, east - moved_e, down - moved_d)
        if gap[0] < nearest[0]:
            nearest = gap
    return nearest


@compiled(NUMBER(BODIES, NUMBER, NUMBER, NUMBER, NUMBER))
def signed_distance(bodies: Array, north: float, east: float, down: float, t_s: float) -> float:
    """Of the nearest body at time `t_s`; NO_OBSTACLE_M without bodies."""
    return signed_distance_and_gradient(bodies, north, east, down, t_s)[0]


@compiled("void(f8[:,::1],f8,f8,f8,f8,f8[:,::1])")
def all_gaps(bodies: Array, north: float, east: float, down: float, t_s: float, gaps: Array) -> None:
    """gaps (n, 4): signed distance and gradient of every body at time `t_s`."""
    for i in range(bodies.shape[0]):
        moved_n, moved_e, moved_d = bodies[i, V_NORTH] * t_s, bodies[i, V_EAST] * t_s, bodies[i, V_DOWN] * t_s
        gap = body_gap(bodies, i, north - moved_n, east - moved_e, down - moved_d)
        gaps[i, 0], gaps[i, 1], gaps[i, 2], gaps[i, 3] = gap


@compiled(WHOLE(BODIES, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, INDICES, BODIES))
def nearest_bodies(
    bodies: Array, north: float, east: float, down: float, t_s: float, within_m: float, which: NDArray[np.int64], gaps: Array
) -> int:
    """The nearest bodies at `t_s`, nearest first: their rows in which (k,), signed distance and gradient in gaps (k, 4).

    Returns how many of the k places are filled; only bodies nearer than `within_m` count. Equally near ones stand in the
    order of their rows.
    """
    count = 0
    for i in range(bodies.shape[0]):
        moved_n, moved_e, moved_d = bodies[i, V_NORTH] * t_s, bodies[i, V_EAST] * t_s, bodies[i, V_DOWN] * t_s
        gap = body_gap(bodies, i, north - moved_n, east - moved_e, down - moved_d)
        if gap[0] >= within_m or (count == len(which) and (count == 0 or gap[0] >= gaps[count - 1, 0])):
            continue
        place = min(count, len(which) - 1)
        while place > 0 and gaps[place - 1, 0] > gap[0]:
            which[place] = which[place - 1]
            for column in range(4):
                gaps[place, column] = gaps[place - 1, column]
            place -= 1
        which[place] = i
        gaps[place, 0], gaps[place, 1], gaps[place, 2], gaps[place, 3] = gap
        count = min(count + 1, len(which))
    return count
