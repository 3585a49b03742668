"""Ray-casting of simple surfaces into a z-depth image, float32 metres, nearest wins. All compiled code of the drawing is here."""

from __future__ import annotations

import math

import numpy as np

from perception.kernel_cache import njit

NEAR_M = 0.02
"""Nothing nearer to the camera's plane is drawn."""
_SCALARS = "f8,f8,f8,f8"


@njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8)", cache=True, nogil=True, error_model="numpy")
def draw_ground(z, rotation, position, fx, fy, cx, cy, ground):  # type: ignore[no-untyped-def]
    """Fill the image with the ground plane; 1e9 where the ray does not meet it."""
    height = ground - position[2]
    for v in range(z.shape[0]):
        row = rotation[2, 1] * (v - cy) / fy + rotation[2, 2]
        step = rotation[2, 0] / fx
        for u in range(z.shape[1]):
            down = row + step * (u - cx)
            z[v, u] = height / down if down > 1e-9 and height > 0 else 1e9


@njit("UniTuple(i8,4)(f8[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",i8,i8,f8)", cache=True, nogil=True)
def _window(corners, rotation, position, fx, fy, cx, cy, width, height, range_max):  # type: ignore[no-untyped-def]
    """Pixels [u0, u1), [v0, v1) that can show a box with `corners` (8, 3), bit k of the index = far end of axis k."""
    x, y, depth = np.empty(8), np.empty(8), np.empty(8)
    nearest = 1e18
    for i in range(8):
        n, e, d = corners[i, 0] - position[0], corners[i, 1] - position[1], corners[i, 2] - position[2]
        x[i] = rotation[0, 0] * n + rotation[1, 0] * e + rotation[2, 0] * d
        y[i] = rotation[0, 1] * n + rotation[1, 1] * e + rotation[2, 1] * d
        depth[i] = rotation[0, 2] * n + rotation[1, 2] * e + rotation[2, 2] * d
        nearest = min(nearest, depth[i])
    u0, u1, v0, v1 = 1e18, -1e18, 1e18, -1e18
    if nearest <= range_max:
        for i in range(8):
            if depth[i] >= NEAR_M:
                u, v = cx + fx * x[i] / depth[i], cy + fy * y[i] / depth[i]
                u0, u1, v0, v1 = min(u0, u), max(u1, u), min(v0, v), max(v1, v)
            for axis in range(3):
                j = i ^ (1 << axis)
                if depth[i] < NEAR_M <= depth[j]:
                    part = (NEAR_M - depth[i]) / (depth[j] - depth[i])
                    u = cx + fx * (x[i] + part * (x[j] - x[i])) / NEAR_M
                    v = cy + fy * (y[i] + part * (y[j] - y[i])) / NEAR_M
                    u0, u1, v0, v1 = min(u0, u), max(u1, u), min(v0, v), max(v1, v)
    if u1 < u0:
        return 0, 0, 0, 0
    left = int(min(max(math.floor(u0), 0.0), float(width)))
    right = int(min(max(math.ceil(u1) + 1.0, 0.0), float(width)))
    upper = int(min(max(math.floor(v0), 0.0), float(height)))
    lower = int(min(max(math.ceil(v1) + 1.0, 0.0), float(height)))
    return left, right, upper, lower


@njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8,f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def draw_cylinders(z, rotation, position, fx, fy, cx, cy, ground, cylinders, range_max):  # type: ignore[no-untyped-def]
    """Vertical cylinders (n, 4) north, east, radius, height standing on the ground: sides and tops."""
    corners = np.empty((8, 3))
    for item in range(cylinders.shape[0]):
        north, east, radius = cylinders[item, 0], cylinders[item, 1], cylinders[item, 2]
        top = ground - cylinders[item, 3]
        for i in range(8):
            corners[i, 0] = north + (radius if i & 1 else -radius)
            corners[i, 1] = east + (radius if i & 2 else -radius)
            corners[i, 2] = ground if i & 4 else top
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e = position[0] - north, position[1] - east
        c = n * n + e * e - radius * radius
        above = top - position[2]
        for v in range(v0, v1):
            y = (v - cy) / fy
            base_n = rotation[0, 1] * y + rotation[0, 2]
            base_e = rotation[1, 1] * y + rotation[1, 2]
            base_d = rotation[2, 1] * y + rotation[2, 2]
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_n = rotation[0, 0] * x + base_n
                ray_e = rotation[1, 0] * x + base_e
                ray_d = rotation[2, 0] * x + base_d
                a = ray_n * ray_n + ray_e * ray_e
                b = n * ray_n + e * ray_e
                inner = b * b - a * c
                if inner > 0.0 and a > 1e-12:
                    s = (-b - math.sqrt(inner)) / a
                    down = position[2] + s * ray_d
                    if s > NEAR_M and top <= down <= ground and s < z[v, u]:
                        z[v, u] = s
                if above > 0.0 and ray_d > 1e-9:
                    s = above / ray_d
                    at_n, at_e = n + s * ray_n, e + s * ray_e
                    if s > NEAR_M and at_n * at_n + at_e * at_e <= radius * radius and s < z[v, u]:
                        z[v, u] = s


@njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8,f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def draw_boxes(z, rotation, position, fx, fy, cx, cy, ground, boxes, range_max):  # type: ignore[no-untyped-def]
    """Boxes (n, 6) north, east, length, width, height, heading_rad standing on the ground."""
    corners = np.empty((8, 3))
    for item in range(boxes.shape[0]):
        north, east = boxes[item, 0], boxes[item, 1]
        half_l, half_w = boxes[item, 2] / 2, boxes[item, 3] / 2
        top = ground - boxes[item, 4]
        cos, sin = math.cos(boxes[item, 5]), math.sin(boxes[item, 5])
        for i in range(8):
            along = half_l if i & 1 else -half_l
            across = half_w if i & 2 else -half_w
            corners[i, 0] = north + along * cos - across * sin
            corners[i, 1] = east + along * sin + across * cos
            corners[i, 2] = ground if i & 4 else top
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e = position[0] - north, position[1] - east
        own_l, own_w = n * cos + e * sin, e * cos - n * sin
        # Rows of the rotation that takes optical axes to the axes of the box.
        to_l = rotation[0] * cos + rotation[1] * sin
        to_w = rotation[1] * cos - rotation[0] * sin
        for v in range(v0, v1):
            y = (v - cy) / fy
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_l = to_l[0] * x + to_l[1] * y + to_l[2]
                ray_w = to_w[0] * x + to_w[1] * y + to_w[2]
                ray_d = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
                ray_l = ray_l if abs(ray_l) > 1e-12 else 1e-12
                ray_w = ray_w if abs(ray_w) > 1e-12 else 1e-12
                ray_d = ray_d if abs(ray_d) > 1e-12 else 1e-12
                per_l, per_w, per_d = 1.0 / ray_l, 1.0 / ray_w, 1.0 / ray_d
                s0, s1 = (-half_l - own_l) * per_l, (half_l - own_l) * per_l
                enter, leave = min(s0, s1), max(s0, s1)
                s0, s1 = (-half_w - own_w) * per_w, (half_w - own_w) * per_w
                enter, leave = max(enter, min(s0, s1)), min(leave, max(s0, s1))
                s0, s1 = (top - position[2]) * per_d, (ground - position[2]) * per_d
                enter, leave = max(enter, min(s0, s1)), min(leave, max(s0, s1))
                if NEAR_M < enter <= leave and enter < z[v, u]:
                    z[v, u] = enter


@njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def draw_spheres(z, rotation, position, fx, fy, cx, cy, spheres, range_max):  # type: ignore[no-untyped-def]
    """Spheres (n, 4) north, east, down, radius."""
    corners = np.empty((8, 3))
    for item in range(spheres.shape[0]):
        radius = spheres[item, 3]
        for i in range(8):
            for axis in range(3):
                corners[i, axis] = spheres[item, axis] + (radius if i >> axis & 1 else -radius)
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e, d = position[0] - spheres[item, 0], position[1] - spheres[item, 1], position[2] - spheres[item, 2]
        c = n * n + e * e + d * d - radius * radius
        for v in range(v0, v1):
            y = (v - cy) / fy
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_n = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2]
                ray_e = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2]
                ray_d = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
                a = ray_n * ray_n + ray_e * ray_e + ray_d * ray_d
                b = n * ray_n + e * ray_e + d * ray_d
                inner = b * b - a * c
                if inner > 0.0:
                    s = (-b - math.sqrt(inner)) / a
                    if s > NEAR_M and s < z[v, u]:
                        z[v, u] = s


@njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def draw_capsules(z, rotation, position, fx, fy, cx, cy, capsules, range_max):  # type: ignore[no-untyped-def]
    """Capsules (n, 7): north, east, down of both ends, radius."""
    corners = np.empty((8, 3))
    axis, start, finish = np.empty(3), np.empty(3), np.empty(3)
    for item in range(capsules.shape[0]):
        radius = capsules[item, 6]
        for k in range(3):
            first, last = capsules[item, k], capsules[item, 3 + k]
            for i in range(8):
                corners[i, k] = max(first, last) + radius if i >> k & 1 else min(first, last) - radius
            axis[k], start[k], finish[k] = last - first, position[k] - first, position[k] - last
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        length2 = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]
        along = axis[0] * start[0] + axis[1] * start[1] + axis[2] * start[2]
        start2 = start[0] * start[0] + start[1] * start[1] + start[2] * start[2]
        finish2 = finish[0] * finish[0] + finish[1] * finish[1] + finish[2] * finish[2]
        c = length2 * (start2 - radius * radius) - along * along
        for v in range(v0, v1):
            y = (v - cy) / fy
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_n = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2]
                ray_e = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2]
                ray_d = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
                ray2 = ray_n * ray_n + ray_e * ray_e + ray_d * ray_d
                ray_along = axis[0] * ray_n + axis[1] * ray_e + axis[2] * ray_d
                ray_start = start[0] * ray_n + start[1] * ray_e + start[2] * ray_d
                a = length2 * ray2 - ray_along * ray_along
                b = length2 * ray_start - along * ray_along
                inner = b * b - a * c
                if inner < 0.0:
                    continue
                # Where the ray enters the endless cylinder, as a part of the axis: beyond its ends a ball takes over.
                s, part = 0.0, -ray_along
                if a > 1e-12:
                    s = (-b - math.sqrt(inner)) / a
                    part = along + s * ray_along
                if not 0.0 < part < length2 or a <= 1e-12:
                    is_first = part <= 0.0
                    b = ray_start if is_first else finish[0] * ray_n + finish[1] * ray_e + finish[2] * ray_d
                    inner = b * b - ray2 * ((start2 if is_first else finish2) - radius * radius)
                    if inner < 0.0:
                        continue
                    s = (-b - math.sqrt(inner)) / ray2
                if s > NEAR_M and s < z[v, u]:
                    z[v, u] = s
