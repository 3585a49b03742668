"""Nothing stands in a sector that is reported free: behind glare and covers, at the picture's edge, in open country."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from perception.geometry import CameraMounting, camera_pose
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.synthetic.depth_renderer import DepthRenderer
from perception.synthetic.flaws import Cover, Flaws, Glare
from perception.synthetic.scene import Scene
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose
from tests.perception.scenes import D435, MOUNTING, pose

CENTRED = CameraMounting()
"""A camera where the vehicle is: bearings of near things are the same from both."""


def fly(
    scene: Scene,
    at: VehiclePose,
    flaws: Flaws = Flaws(),  # noqa: B008
    frames: int = 1,
    seed: int = 0,
    mounting: CameraMounting = MOUNTING,
) -> list[PerceivedObstacles]:
    renderer = DepthRenderer(scene, D435, seed=seed, flaws=flaws)
    process = PerceptionPipeline(PerceptionParameters(), mounting)
    shots = (DepthFrame(k / 30, k, renderer.render(camera_pose(at, mounting), k), 0.001, D435) for k in range(frames))
    return [process.process(shot, at) for shot in shots]


def seen_deg(found: PerceivedObstacles) -> float:
    return 360.0 - math.degrees(float(np.sum(found.unseen[:, 1] - found.unseen[:, 0])))


def pole(distance: float, bearing_deg: float, width: float) -> Scene:
    bearing = math.radians(bearing_deg)
    return Scene(cylinders=np.array([[distance * math.cos(bearing), distance * math.sin(bearing), width / 2, 9.0]]))


def is_free(found: PerceivedObstacles, north: float, east: float, radius: float) -> bool:
    """Whether something round, but for its outermost tenth, shows neither behind the front of a disc nor unseen."""
    distance, middle = math.hypot(north, east), math.atan2(east, north)
    for offset in np.linspace(-0.9, 0.9, 13) * math.asin(min(radius / distance, 0.99)):
        bearing = middle + offset
        if any(start <= bearing < end for start, end in found.unseen):
            continue
        across = found.discs[:, 1] * math.cos(bearing) - found.discs[:, 0] * math.sin(bearing)
        front = np.hypot(found.discs[:, 0], found.discs[:, 1]) - found.discs[:, 2]
        if not np.any((np.abs(across) <= found.discs[:, 2]) & (front < distance + 0.3)):
            return True
    return False


@pytest.mark.parametrize("distance", [3.0, 5.0, 6.0, 7.0])
@pytest.mark.parametrize("bearing", [0.0, 20.0])
@pytest.mark.parametrize(
    "flaws",
    [
        Flaws(glare=Glare(424.0, 240.0, 200.0)),
        Flaws(glare=Glare(424.0, 240.0, 60.0)),
        Flaws(glare=Glare(424.0, 200.0, 100.0)),
        Flaws(cover=Cover(bottom=0.6)),
        Flaws(cover=Cover(bottom=0.8)),
        Flaws(cover=Cover(left=0.4, right=0.6, bottom=0.85)),
    ],
    ids=["wide glare", "glare", "glare above", "cover from above", "cover down to the ground", "a finger from above"],
)
def test_what_stands_behind_glare_or_a_cover_is_never_in_a_free_sector(flaws: Flaws, bearing: float, distance: float) -> None:
    for width in (0.1, 0.5, 1.0):
        scene = pole(distance, bearing, width)
        for found in fly(scene, pose(), flaws, frames=2):
            assert not is_free(found, *scene.cylinders[0, :3])


def test_glare_over_open_ground_hides_what_it_covers_and_no_more() -> None:
    (found,) = fly(Scene(), pose(), Flaws(glare=Glare(424.0, 240.0, 200.0)))
    assert any(start < -0.3 and end > 0.3 for start, end in found.unseen)
    assert seen_deg(found) > 20
    assert "blind" in found.events[0]


def test_a_camera_that_sees_none_of_the_far_ground_is_blind() -> None:
    (found,) = fly(Scene(), pose(), Flaws(cover=Cover(bottom=0.9)))
    assert seen_deg(found) == 0


@pytest.mark.parametrize(("height", "pitch"), [(3, 5), (3, -10), (5, 0), (5, 5), (8, 5), (12, 0), (12, 5), (15, 0), (15, -10)])
def test_an_open_field_is_free_enough_to_fly(height: float, pitch: float) -> None:
    found = fly(Scene(), pose(height=height, pitch_deg=pitch), frames=3)
    assert min(seen_deg(one) for one in found) > 75


@pytest.mark.parametrize("width", [848, 640, 480, 424])
@pytest.mark.parametrize("height", [1.0, 1.5, 2.0, 3.0, 5.0, 8.0])
def test_an_open_field_is_free_at_every_resolution_of_the_camera(width: int, height: float) -> None:
    scale = width / 848
    lens = Intrinsics(width, round(480 * scale), *(421.6 * scale,) * 2, 424.0 * scale, 240.0 * scale)
    at, process = pose(height=height), PerceptionPipeline(PerceptionParameters(), CENTRED)
    depth = DepthRenderer(Scene(), lens).render(camera_pose(at, CENTRED), 0)
    assert seen_deg(process.process(DepthFrame(0.0, 0, depth, 0.001, lens), at)) > 75


@pytest.mark.parametrize("height", [5.0, 15.0])
def test_speckle_behind_a_covered_lens_opens_no_sector(height: float) -> None:
    for share, depths in ((0.01, (300, 10000)), (0.003, (300, 30000))):
        random = np.random.default_rng(1)
        image = np.zeros((480, 848), np.uint16)
        dots = random.random(image.shape) < share
        image[dots] = random.integers(*depths, int(dots.sum()), dtype=np.uint16)
        found = PerceptionPipeline(PerceptionParameters(), MOUNTING).process(
            DepthFrame(0.0, 0, image, 0.001, D435), pose(height=height)
        )
        assert seen_deg(found) == 0
    (found,) = fly(Scene(), pose(height=height), Flaws(cover=Cover(), speckles=200))
    assert seen_deg(found) == 0


@given(
    distance=st.floats(0.5, 7.5),
    bearing=st.floats(-35, 35),
    width=st.floats(0.1, 1.2),
    pitch=st.floats(-15, 10),
    roll=st.floats(-10, 10),
    height=st.floats(2, 8),
    seed=st.integers(0, 100),
)
@settings(max_examples=40, deadline=None)
def test_something_upright_is_covered_or_unseen(
    distance: float, bearing: float, width: float, pitch: float, roll: float, height: float, seed: int
) -> None:
    scene = pole(distance + width / 2 + 0.1, bearing, width)
    (found,) = fly(scene, pose(height=height, pitch_deg=pitch, roll_deg=roll), seed=seed, mounting=CENTRED)
    assert not is_free(found, *scene.cylinders[0, :3])


@given(
    distance=st.floats(0.5, 7.0),
    bearing=st.floats(-30, 30),
    radius=st.floats(0.1, 0.5),
    drop=st.floats(-0.7, 0.7),
    pitch=st.floats(-20, 10),
)
@settings(max_examples=40, deadline=None)
def test_something_in_the_air_is_covered_or_unseen_wherever_the_picture_cuts_it(
    distance: float, bearing: float, radius: float, drop: float, pitch: float
) -> None:
    # Its middle is in the picture, which reaches 30 degrees up and down.
    assume(abs(math.degrees(math.atan2(drop, distance + radius)) + pitch) < 26)
    turn = math.radians(bearing)
    north, east = (distance + radius) * math.cos(turn), (distance + radius) * math.sin(turn)
    ball = np.array([[north, east, -5.0 + drop, north, east, -4.99 + drop, radius]])
    (found,) = fly(Scene(capsules=ball), pose(pitch_deg=pitch), mounting=CENTRED)
    assert not is_free(found, north, east, radius * 0.7)
