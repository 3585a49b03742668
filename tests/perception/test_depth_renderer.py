"""The renderer against an independent slow ray-caster, and its noise against its own description."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.config.mission import Box, Cylinder, Obstacles
from flightapp.sim.world import World
from perception.geometry import CameraMounting, CameraPose, camera_pose
from perception.synthetic.depth_renderer import DepthRenderer
from perception.synthetic.flaws import Cover, Flaws, Sun
from perception.synthetic.scene import Scene
from perception.types import Intrinsics, VehiclePose

SMALL = Intrinsics(40, 24, 20.0, 21.0, 19.3, 12.2)
D435 = Intrinsics(848, 480, 421.6, 421.6, 424.0, 240.0)


def at(north: float, east: float, down: float, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> CameraPose:
    pose = VehiclePose((north, east, down), (0.0, 0.0, 0.0), roll, pitch, yaw)
    return camera_pose(pose, CameraMounting())


def marched(world: World, camera: CameraPose, spheres: list[tuple[float, ...]], u: int, v: int) -> float:
    """z-depth by stepping along the ray until the distance to everything is nil; inf beyond 12 m."""
    k = SMALL
    ray = camera.rotation @ np.array([(u - k.cx_px) / k.fx_px, (v - k.cy_px) / k.fy_px, 1.0])
    length = float(np.linalg.norm(ray))
    z = 0.0
    for _ in range(3000):
        n, e, d = (camera.position_ned_m + z * ray).tolist()
        gap = max(world.ground_down_m - d, 0.0)
        gap = min(gap, max(0.0, world.signed_distance_m(n, e, d)))
        for sphere in spheres:
            gap = min(gap, math.dist((n, e, d), sphere[:3]) - sphere[3])
        if gap < 1e-6:
            return z
        z += max(gap, 1e-6) / length
        if z > 12.0:
            break
    return math.inf


scenes = st.builds(
    Obstacles,
    cylinders=st.lists(
        st.builds(
            Cylinder,
            north_m=st.floats(-6, 6),
            east_m=st.floats(-6, 6),
            radius_m=st.floats(0.1, 1.5),
            height_m=st.floats(0.5, 6),
        ),
        max_size=3,
    ).map(tuple),
    boxes=st.lists(
        st.builds(
            Box,
            north_m=st.floats(-6, 6),
            east_m=st.floats(-6, 6),
            length_m=st.floats(0.2, 4),
            width_m=st.floats(0.2, 4),
            height_m=st.floats(0.5, 6),
            heading_deg=st.floats(-180, 180),
        ),
        max_size=2,
    ).map(tuple),
)
angle = st.floats(-0.5, 0.5)


@given(
    obstacles=scenes,
    spheres=st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-5, -1), st.floats(0.2, 0.5)), max_size=2),
    place=st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-5, -0.5)),
    roll=angle,
    pitch=angle,
    yaw=st.floats(-3.1, 3.1),
    seed=st.integers(0, 1000),
)
@settings(max_examples=60, deadline=None)
def test_every_pixel_agrees_with_a_slow_ray_caster(
    obstacles: Obstacles,
    spheres: list[tuple[float, ...]],
    place: tuple[float, float, float],
    roll: float,
    pitch: float,
    yaw: float,
    seed: int,
) -> None:
    world = World(obstacles)
    inside = world.signed_distance_m(*place) < 0.1 or any(math.dist(place, sphere[:3]) < sphere[3] + 0.1 for sphere in spheres)
    if inside:
        return
    camera = at(*place, roll, pitch, yaw)
    renderer = DepthRenderer(world, SMALL, range_max_m=10.0, noise=False)
    image = renderer.render(camera, 1, np.array(spheres).reshape(-1, 4))
    random = np.random.default_rng(seed)
    wrong = 0
    for _ in range(25):
        u, v = int(random.integers(SMALL.width_px)), int(random.integers(SMALL.height_px))
        z = marched(world, camera, spheres, u, v)
        expected = round(z * 1000) if 0.3 <= z <= 10.0 else 0
        if abs(int(image[v, u]) - expected) > 2 and abs(z - 10.0) > 0.01 and abs(z - 0.3) > 0.01:
            wrong += 1
    assert wrong <= 1, "one ray may graze an edge within the caster's tolerance"


def test_the_ground_below_a_level_camera() -> None:
    image = DepthRenderer(World(Obstacles()), D435, noise=False).render(at(0, 0, -2.0), 1)
    assert image[:241].max() == 0
    assert image[440, 100] == pytest.approx(2000 * 421.6 / 200, abs=1)


def test_the_mounting_moves_and_turns_the_camera() -> None:
    world = World(Obstacles(boxes=(Box(north_m=0, east_m=5.5, length_m=20, width_m=1, height_m=9),)))
    pose = VehiclePose((0.0, 0.0, -3.0), (0.0, 0.0, 0.0), 0.0, 0.0, math.radians(60))
    camera = camera_pose(pose, CameraMounting(forward_m=1.0, yaw_deg=30))
    image = DepthRenderer(world, D435, noise=False).render(camera, 1)
    assert image[240, 424] == pytest.approx(1000 * (5.0 - math.sin(math.radians(60))), abs=1)


def wall(distance: float) -> World:
    return World(Obstacles(boxes=(Box(north_m=distance + 0.5, east_m=0, length_m=1, width_m=60, height_m=20),)))


@pytest.mark.parametrize(("distance", "sigma"), [(1.0, 0.004), (4.0, 0.064), (8.0, 0.256)])
def test_noise_grows_with_distance_squared(distance: float, sigma: float) -> None:
    renderer = DepthRenderer(wall(distance), D435)
    images = [renderer.render(at(0, 0, -5.0), number)[:240] for number in range(6)]
    measured = np.concatenate([image[image > 0] for image in images]) * 0.001
    assert measured.mean() == pytest.approx(distance, abs=0.1 * sigma + 0.001)
    assert measured.std() == pytest.approx(sigma, rel=0.1)
    holes = np.mean([np.mean(image[:, 30:] == 0) for image in images])
    assert 0.003 < holes < 0.03


def test_left_of_a_near_edge_lies_a_shadow() -> None:
    near = Cylinder(north_m=1.5, east_m=0, radius_m=0.2, height_m=20)
    world = World(Obstacles(cylinders=(near,), boxes=(Box(north_m=6.5, east_m=0, length_m=1, width_m=60, height_m=20),)))
    image = DepthRenderer(world, D435).render(at(0, 0, -5.0), 1)
    clean = DepthRenderer(world, D435, noise=False).render(at(0, 0, -5.0), 1)
    edge = int(np.flatnonzero(clean[240] < 3000)[0])
    jump = 421.6 * 0.05 * (1 / 1.5 - 1 / 6.0)
    width = np.count_nonzero(image[100:380, edge - 30 : edge] == 0, axis=1).mean()
    assert width == pytest.approx(jump, abs=2.5)
    right = int(np.flatnonzero(clean[240] < 3000)[-1])
    assert np.mean(image[100:380, right + 2 : right + 30] == 0) < 0.05


def test_the_same_seed_and_number_give_the_same_image() -> None:
    first, second, other = (DepthRenderer(wall(4.0), D435, seed=seed) for seed in (5, 5, 6))
    camera = at(0, 0, -5.0)
    later = first.render(camera, 8)
    assert np.array_equal(first.render(camera, 7), second.render(camera, 7))
    assert not np.array_equal(first.render(camera, 7), other.render(camera, 7))
    assert not np.array_equal(later, first.render(camera, 7))


def test_range_limits() -> None:
    for distance, visible in ((0.25, False), (0.35, True), (9.9, True), (10.1, False)):
        image = DepthRenderer(wall(distance), D435, range_max_m=10.0, noise=False).render(at(0, 0, -5.0), 1)
        assert bool(image[240, 424]) is visible


@pytest.mark.parametrize("height", [3.0, 5.0, 10.0])
def test_an_open_field_returns_a_tail_and_the_sky_nothing(height: float) -> None:
    images = [DepthRenderer(World(Obstacles()), D435).render(at(0, 0, -height), number) for number in range(4)]
    assert all(image[:240].max() == 0 for image in images)
    for image in images:
        assert np.mean(image[440:] > 0) > 0.3
        assert image.max() > 20_000


def test_far_surfaces_return_ever_less() -> None:
    share = []
    for distance in (6.0, 12.0, 20.0, 28.0, 35.0):
        image = DepthRenderer(wall(distance), D435, seed=3).render(at(0, 0, -8.0), 1)
        share.append(float(np.mean(image[200:280, 100:] > 0)))
    assert share[0] > 0.97
    assert share == sorted(share, reverse=True)
    assert share[1] == pytest.approx(0.83, abs=0.05)
    assert share[-1] == 0.0


def test_the_left_border_as_wide_as_the_disparity_is_empty() -> None:
    image = DepthRenderer(wall(1.0), D435).render(at(0, 0, -5.0), 1)[100:380]
    band = round(421.6 * 0.05 / 1.0)
    assert image[:, : band - 1].max() == 0
    assert np.mean(image[:, band + 1 : band + 30] > 0) > 0.95


def test_depth_comes_in_steps_of_a_32nd_of_a_pixel_of_disparity() -> None:
    image = DepthRenderer(wall(8.0), D435).render(at(0, 0, -5.0), 1)[:240]
    steps = 32 * 421.6 * 0.05 / (np.unique(image[image > 0]) * 0.001)
    assert np.abs(steps - np.rint(steps)).max() < 0.01


def poles(*poles: tuple[float, float, float]) -> Scene:
    """Vertical poles: north_m, east_m, diameter_m."""
    return Scene(cylinders=np.array([(north, east, diameter / 2, 20.0) for north, east, diameter in poles]))


@given(
    ends=st.tuples(*[st.floats(-4, 4)] * 6),
    radius=st.floats(0.01, 0.6),
    yaw=st.floats(-3.1, 3.1),
    pitch=angle,
    seed=st.integers(0, 1000),
)
@settings(max_examples=60, deadline=None)
def test_a_capsule_agrees_with_the_distance_to_its_axis(
    ends: tuple[float, ...], radius: float, yaw: float, pitch: float, seed: int
) -> None:
    first, last = np.array(ends[:3]), np.array(ends[3:])
    camera = at(0, 0, 0, 0.2, pitch, yaw)
    axis = last - first

    def gap(point: np.ndarray) -> float:
        part = float(np.clip((point - first) @ axis / max(float(axis @ axis), 1e-12), 0.0, 1.0))
        return float(np.linalg.norm(point - first - part * axis)) - radius

    if gap(camera.position_ned_m) < 0.1:
        return
    scene = Scene(capsules=np.array([[*ends, radius]]), ground_down_m=50.0)
    image = DepthRenderer(scene, SMALL, range_min_m=0.05, range_max_m=15.0, noise=False).render(camera, 1)
    random = np.random.default_rng(seed)
    wrong = 0
    for _ in range(25):
        u, v = int(random.integers(SMALL.width_px)), int(random.integers(SMALL.height_px))
        ray = camera.rotation @ np.array([(u - SMALL.cx_px) / SMALL.fx_px, (v - SMALL.cy_px) / SMALL.fy_px, 1.0])
        z, length = 0.0, float(np.linalg.norm(ray))
        while z < 15.0 and (distance := gap(camera.position_ned_m + z * ray)) > 1e-6:
            z += max(distance, 1e-5) / length
        expected = round(z * 1000) if 0.05 <= z < 15.0 else 0
        wrong += abs(int(image[v, u]) - expected) > 2
    assert wrong <= 1, "one ray may graze an edge within the caster's tolerance"


def test_near_edges_grow_by_a_pixel_and_some_pixels_fly() -> None:
    scene = Scene(
        cylinders=np.array([(2.0, 0.0, 0.2, 20.0)]), boxes=np.array([(6.5, 0.0, 1.0, 60.0, 20.0, 0.0)]), ground_down_m=0.0
    )
    seen = DepthRenderer(scene, D435).render(at(0, 0, -8.0), 1)[60:420] * 0.001
    exact = DepthRenderer(scene, D435, flaws=Flaws(window_px=1)).render(at(0, 0, -8.0), 1)[60:420] * 0.001
    near, near_exact = ((image > 0.0) & (image < 2.5) for image in (seen, exact))
    growth = (np.count_nonzero(near, axis=1) - np.count_nonzero(near_exact, axis=1)).mean()
    assert 1.0 < growth < 3.0
    between = np.count_nonzero((seen > 2.6) & (seen < 4.5), axis=1).mean()
    assert 0.2 < between < 1.0
    assert np.count_nonzero((exact > 2.6) & (exact < 4.5)) == 0


def test_what_is_narrower_than_the_matching_window_is_partly_lost() -> None:
    share = []
    for diameter in (0.01, 0.03, 0.05, 0.2):
        image = DepthRenderer(poles((5.0, 0.3, diameter)), D435, seed=2).render(at(0, 0, -10.0), 1)[40:440]
        share.append(float(np.mean((image[:, 400:500] > 0).any(axis=1))))
    assert share == sorted(share)
    assert share[0] < 0.6
    assert 0.4 < share[1] < 0.9
    assert share[-1] > 0.97


def test_glare_takes_the_picture_around_the_sun() -> None:
    camera = at(0, 0, -8.0, yaw=0.3)
    clean = DepthRenderer(wall(4.0), D435).render(camera, 1)
    dazzled = DepthRenderer(wall(4.0), D435, flaws=Flaws(glare=Sun(bearing_rad=0.5, elevation_rad=0.1))).render(camera, 1)
    u, v = round(424 + 421.6 * math.tan(0.2)), round(240 - 421.6 * math.tan(0.1) / math.cos(0.2))
    rows, columns = np.mgrid[:480, :848]
    distance = np.hypot(rows - v, columns - u)
    assert dazzled[distance < 58].max() == 0
    assert np.array_equal(dazzled[distance > 92], clean[distance > 92])
    behind = DepthRenderer(wall(4.0), D435, flaws=Flaws(glare=Sun(bearing_rad=2.9, elevation_rad=0.1))).render(camera, 1)
    assert np.array_equal(behind, clean)


def test_a_covered_part_returns_nothing_or_something_near() -> None:
    flaws = Flaws(cover=Cover(left=0.5)), Flaws(cover=Cover(top=0.75, depth_m=0.35))
    none, near = (DepthRenderer(wall(4.0), D435, flaws=one).render(at(0, 0, -8.0), 1) for one in flaws)
    assert none[:, 424:].max() == 0
    assert np.mean(none[:, 30:420] > 0) > 0.95
    assert np.all(near[360:] == 350)


def test_speckles_are_many_small_wrong_distances() -> None:
    image = DepthRenderer(poles((50.0, 0.0, 0.1)), D435, flaws=Flaws(speckles=100)).render(at(0, 0, -50.0), 1)
    number, _, stats, _ = cv2.connectedComponentsWithStats((image > 0).astype(np.uint8))
    assert 60 < number - 1 <= 100
    assert stats[1:, cv2.CC_STAT_AREA].max() < 150
    assert len(np.unique(image)) > 60


@pytest.mark.parametrize("fraction", [0.01, 0.1, 0.3])
def test_as_many_holes_as_asked_for(fraction: float) -> None:
    image = DepthRenderer(wall(4.0), D435, flaws=Flaws(hole_fraction=fraction)).render(at(0, 0, -8.0), 1)
    assert np.mean(image[:400, 30:] == 0) == pytest.approx(fraction, rel=0.35)
