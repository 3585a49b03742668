"""What an ideal extraction would hand to tracking: round objects, seen with noise from a pose that is known with errors."""

from __future__ import annotations

import math

import numpy as np

from perception.extraction.bearing_bins import TANGENT_STEP, TANGENTS
from perception.geometry import CameraMounting, camera_pose
from perception.sighting import Sighting, View
from perception.types import VehiclePose

HALF_PICTURE_RAD = math.radians(42.0)
RANGE_M = 9.0
NO_DISCS = np.zeros((0, 3))


class Lookout:
    """A camera that sees round objects (n, 3) north, east, radius.

    noise: of the depth along the line of sight, in m at 1 m, grows with distance squared. yaw_error_rad: of the vehicle's own
    estimate, in which sightings are expressed. background_m: distance of returns from behind everything, 0 for none.
    """

    def __init__(self, noise: float = 0.0, background_m: float = 0.0, seed: int = 0) -> None:
        self.noise = noise
        self.background_m = background_m
        self.random = np.random.default_rng(seed)

    def look(
        self, objects: np.ndarray, north: float = 0.0, east: float = 0.0, yaw: float = 0.0, yaw_error_rad: float = 0.0
    ) -> Sighting:
        near = objects[np.hypot(objects[:, 0] - north, objects[:, 1] - east) < 1.5 * RANGE_M]
        objects = near.reshape(-1, 3)
        forward_m = _cast(objects, north, east, yaw)
        nearest_m = forward_m.min(axis=0, initial=np.inf)
        owner = np.where(np.isfinite(nearest_m), forward_m.argmin(axis=0), -1) if len(objects) else np.full(len(TANGENTS), -1)
        in_picture = np.abs(np.arctan(TANGENTS)) < HALF_PICTURE_RAD
        believed = yaw + yaw_error_rad
        found, sigma, whole = [], [], []
        for number in np.unique(owner[in_picture & (owner >= 0)]):
            bins = np.flatnonzero((owner == number) & in_picture)
            first, last = (math.atan(TANGENTS[k] + s * TANGENT_STEP / 2) for k, s in ((bins[0], -1), (bins[-1], 1)))
            half, middle = (last - first) / 2, (first + last) / 2
            gap = math.hypot(objects[number, 0] - north, objects[number, 1] - east)
            is_whole = len(bins) == np.count_nonzero(np.isfinite(forward_m[number]))
            surface = float((nearest_m[bins] * np.hypot(1.0, TANGENTS[bins])).min())
            silhouette = objects[number, 2] if is_whole else surface * math.sin(half) / (1 - math.sin(half))
            deviation = self.noise * gap**2
            distance = surface + silhouette + deviation * self.random.standard_normal()
            bearing = believed + middle + 0.2 * TANGENT_STEP * self.random.standard_normal()
            radius = max(silhouette + 0.3 * deviation * self.random.standard_normal(), 0.05)
            found.append((north + distance * math.cos(bearing), east + distance * math.sin(bearing), radius))
            sigma.append(max(deviation, 0.01))
            whole.append(is_whole)
        mounted = VehiclePose((north, east, -5.0), (0.0, 0.0, 0.0), 0.0, 0.0, believed)
        seen = np.abs((np.arange(360) + 0.5) * math.pi / 360 - math.pi / 2) < HALF_PICTURE_RAD
        followed_m = np.where(np.isfinite(nearest_m), nearest_m, self.background_m)
        view = View(camera_pose(mounted, CameraMounting()), seen, nearest_m, np.where(in_picture, followed_m, 0.0), 0.3, RANGE_M)
        return Sighting(
            np.array(found).reshape(-1, 3), np.array(sigma), np.full(len(found), 1.0), np.array(whole, np.bool_), view
        )


def _cast(objects: np.ndarray, north: float, east: float, yaw: float) -> np.ndarray:
    """(n, bins) forward distance at which the ray of each bearing bin meets each object, inf if it does not within range."""
    angle = np.arctan(TANGENTS)
    to_north, to_east, radius = objects[:, :1] - north, objects[:, 1:2] - east, objects[:, 2:3]
    ahead, aside = to_north * math.cos(yaw) + to_east * math.sin(yaw), to_east * math.cos(yaw) - to_north * math.sin(yaw)
    along, across = ahead * np.cos(angle) + aside * np.sin(angle), aside * np.cos(angle) - ahead * np.sin(angle)
    forward_m = (along - np.sqrt(np.maximum(radius**2 - across**2, 0.0))) * np.cos(angle)
    return np.where((np.abs(across) < radius) & (along > radius) & (ahead < RANGE_M), forward_m, np.inf)
