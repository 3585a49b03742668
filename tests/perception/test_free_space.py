"""Free space is remembered for a moment over a picture of the sky, and nothing ever stands in it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from perception.extraction.bearing_bins import SECTORS, TANGENT_BINS, bin_of
from perception.free_space import FreeSpaceMemory, is_seen_free
from perception.geometry import CameraMounting, camera_pose
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.sighting import View
from perception.synthetic.depth_renderer import DepthRenderer
from perception.synthetic.flaws import Flaws, Glare
from perception.synthetic.scene import Scene
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose
from tests.perception.scenes import D435, pose

CENTRED = CameraMounting()
MEMORY_S = PerceptionParameters().free_memory_s
TWO_TREES = Scene(cylinders=np.array([[6.0, -3.0, 0.5, 9.0], [6.0, 3.0, 0.5, 9.0]]))
BRAKING_DEG = 27.0
AHEAD = SECTORS // 2
SECTOR_RAD = math.pi / SECTORS


def fly(poses: list[VehiclePose], scene: Scene, nose_up: Scene | None = None, **parameters: float) -> list[PerceivedObstacles]:
    """Frames at 30 Hz of `scene`, and of `nose_up` where the nose is up."""
    process = PerceptionPipeline(PerceptionParameters(**parameters), CENTRED)
    level, up = DepthRenderer(scene, D435), DepthRenderer(nose_up or scene, D435)
    found = []
    for k, at in enumerate(poses):
        image = (up if at.pitch_rad > 0.0 else level).render(camera_pose(at, CENTRED), k)
        found.append(process.process(DepthFrame(k / 30, k, image, 0.001, D435), at))
    return found


def is_seen(found: PerceivedObstacles, bearing_rad: float = 0.0) -> bool:
    return not any(start <= bearing_rad < end for start, end in found.unseen)


def is_before(trees: np.ndarray, at: VehiclePose, bearing: float) -> bool:
    """Whether a tree of the picture with the nose up shows there, or next to it: it would not, were there a pole before it."""
    north, east = (trees[:, :2] - at.position_ned_m[:2]).T
    reach = np.arcsin(trees[:, 2] / np.hypot(north, east)) + 2 * SECTOR_RAD
    return bool(np.any(np.abs(np.arctan2(east, north) - bearing) <= reach))


def stands_free(found: PerceivedObstacles, at: VehiclePose, pole: np.ndarray, trees: np.ndarray) -> bool:
    """Whether something round shows neither behind the front of a disc nor unseen, by more than a sector beside either."""
    north, east = pole[:2] - at.position_ned_m[:2]
    discs = found.discs[:, :3] - np.array([*at.position_ned_m[:2], 0.0])
    centre, bearings = np.hypot(discs[:, 0], discs[:, 1]), np.arctan2(discs[:, 1], discs[:, 0])
    reach = np.arcsin(np.minimum(discs[:, 2] / centre, 1.0)) + SECTOR_RAD
    distance = math.hypot(north, east)
    for offset in np.linspace(-0.9, 0.9, 13) * math.asin(min(pole[2] / distance, 0.99)):
        bearing = math.atan2(east, north) + offset
        if is_before(trees, at, bearing) or not all(is_seen(found, bearing + a) for a in (-SECTOR_RAD, 0.0, SECTOR_RAD)):
            continue
        aside = np.abs((bearings - bearing + math.pi) % (2 * math.pi) - math.pi)
        if not np.any((aside <= reach) & (centre - discs[:, 2] < distance + 0.3)):
            return True
    return False


def test_a_braking_vehicle_knows_for_a_moment_that_there_was_nothing_ahead() -> None:
    moment = round(MEMORY_S * 30)
    poses = [pose()] * 4 + [pose(pitch_deg=BRAKING_DEG)] * (moment + 10)
    seen = [is_seen(one) for one in fly(poses, TWO_TREES)]
    assert all(seen[: 4 + moment - 2])
    assert not any(seen[4 + moment :]), "what is remembered must not renew itself"


def test_without_the_memory_a_braking_vehicle_is_blind_at_once() -> None:
    poses = [pose()] * 4 + [pose(pitch_deg=BRAKING_DEG)] * 2
    assert [is_seen(one) for one in fly(poses, TWO_TREES, free_memory_s=0.0)] == [True] * 4 + [False] * 2


def test_where_it_did_not_look_before_nothing_is_known() -> None:
    turned = math.radians(60)
    poses = [pose()] * 4 + [pose(pitch_deg=BRAKING_DEG, yaw_deg=60.0)]
    trees = np.array([[6.0 * math.cos(turned + a), 6.0 * math.sin(turned + a), 0.5, 9.0] for a in (-0.5, 0.5)])
    found = fly(poses, Scene(cylinders=trees))[-1]
    assert not is_seen(found, turned)


def test_a_glare_over_the_ground_is_not_outweighed() -> None:
    process = PerceptionPipeline(PerceptionParameters(), CENTRED)
    for k, flaws in enumerate((Flaws(), Flaws(glare=Glare(424.0, 240.0, 200.0)))):
        image = DepthRenderer(TWO_TREES, D435, flaws=flaws).render(camera_pose(pose(), CENTRED), k)
        found = process.process(DepthFrame(k / 30, k, image, 0.001, D435), pose())
        assert is_seen(found) == (k == 0)


@given(
    places=st.lists(st.tuples(st.floats(1.5, 8.5), st.floats(-40, 40), st.floats(0.1, 0.6)), min_size=2, max_size=6),
    speed=st.floats(0, 6),
    course_deg=st.floats(-60, 60),
    turn_deg_s=st.floats(-90, 90),
)
@settings(max_examples=15, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate))
def test_nothing_stands_in_remembered_free_space(
    places: list[tuple[float, float, float]], speed: float, course_deg: float, turn_deg_s: float
) -> None:
    """The poles that hide one another are not in the pictures with the nose up at all: two far trees alone are."""
    rows = []
    for distance, bearing_deg, width in places:
        bearing, away = math.radians(bearing_deg), distance + width / 2 + 0.1
        rows.append([away * math.cos(bearing), away * math.sin(bearing), width / 2, 9.0])
    poles, trees = np.array(rows), np.array([[20.0, -6.0, 1.0, 12.0], [20.0, 6.0, 1.0, 12.0]])
    course = math.radians(course_deg)
    poses = []
    for k in range(9):
        way = speed * k / 30
        north, east = way * math.cos(course), way * math.sin(course)
        if np.min(np.hypot(poles[:, 0] - north, poles[:, 1] - east) - poles[:, 2]) < 0.6:
            break
        poses.append(pose(north, east, pitch_deg=BRAKING_DEG if k >= 3 else 0.0, yaw_deg=turn_deg_s * k / 30))
    for at, found in zip(poses, fly(poses, Scene(cylinders=np.vstack((poles, trees))), Scene(cylinders=trees)), strict=True):
        near = np.hypot(poles[:, 0] - at.position_ned_m[0], poles[:, 1] - at.position_ned_m[1]) < 5.5
        assert not any(stands_free(found, at, pole, trees) for pole in poles[near])


def view(nearest_m: float = math.inf, seen: bool = True) -> View:
    camera = camera_pose(pose(), CENTRED)
    return View(
        camera, np.full(SECTORS, seen), np.full(TANGENT_BINS, nearest_m), np.zeros(TANGENT_BINS), 0.3, reliable_range_m=9.0
    )


def free(memory: FreeSpaceMemory, t_s: float, at: VehiclePose) -> bool:
    return bool(memory.free(t_s, camera_pose(at, CENTRED), np.ones(SECTORS, np.bool_))[AHEAD])


@pytest.mark.parametrize(
    ("t_s", "at", "is_known"),
    [
        (0.1, pose(), True),
        (0.39, pose(2.9), True),
        (0.41, pose(), False),
        (0.0, pose(), False),
        (-0.1, pose(), False),
        (0.1, pose(3.2), False),
        (0.1, pose(yaw_deg=30.0), True),
        (0.1, pose(yaw_deg=64.0), False),
        (0.1, pose(-1.0), False),
        (0.1, pose(0.0, 1.0), False),
    ],
    ids=[
        "a moment ago", "on the way", "too long ago", "the same frame", "from the future", "the end is out of range",
        "turned", "turned out of it", "from behind, what is near was behind", "from beside, what is near was outside",
    ],
)  # fmt: skip
def test_what_is_known(t_s: float, at: VehiclePose, is_known: bool) -> None:
    memory = FreeSpaceMemory(0.4)
    memory.add(0.0, view())
    assert free(memory, t_s, at) == is_known
    assert not memory.free(t_s, camera_pose(at, CENTRED), np.zeros(SECTORS, np.bool_)).any()
    memory.clear()
    assert not free(memory, t_s, at)


def test_what_lay_behind_something_or_was_not_seen_is_not_known() -> None:
    for one in (view(nearest_m=4.0), view(seen=False)):
        memory = FreeSpaceMemory(0.4)
        memory.add(0.0, one)
        assert not free(memory, 0.1, pose())


def test_two_views_together_know_what_neither_does() -> None:
    memory, thin = FreeSpaceMemory(0.4), view()
    thin.nearest_m[bin_of(0.0)] = 3.0
    memory.add(0.0, thin)
    assert not free(memory, 0.1, pose())
    memory.add(0.06, view())
    assert free(memory, 0.1, pose())


def test_many_frames_are_no_reason_to_forget_early() -> None:
    memory = FreeSpaceMemory(0.4)
    memory.add(0.0, view())
    for k in range(1, 100):
        memory.add(0.0039 * k, view(seen=False))
    assert free(memory, 0.39, pose())


def test_a_clock_that_was_set_back_does_not_stop_it() -> None:
    memory = FreeSpaceMemory(0.4)
    memory.add(100.0, view())
    memory.add(1.0, view())
    assert free(memory, 1.1, pose())


def test_a_place_is_seen_free_before_the_trees_not_in_or_behind_them_nor_beside_the_picture() -> None:
    [found] = fly([pose()], TWO_TREES)
    assert found.view is not None
    assert is_seen_free(found.view, 5.0, 0.0)
    assert is_seen_free(found.view, 4.0, 2.0)
    assert not is_seen_free(found.view, 6.0, 3.0)
    assert not is_seen_free(found.view, 8.0, 4.0)
    assert not is_seen_free(found.view, 0.0, 5.0)
    assert not is_seen_free(found.view, -5.0, 0.0)
    assert not is_seen_free(found.view, found.view.reliable_range_m + 1.0, 0.0)
