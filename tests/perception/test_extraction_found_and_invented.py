"""Thin things and what the picture cuts off are found, speckle and flying pixels are not, at any height and attitude."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from perception.extraction.extractor import Extractor
from perception.geometry import camera_pose
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.sighting import Sighting
from perception.synthetic.depth_renderer import DepthRenderer
from perception.synthetic.flaws import Flaws
from perception.synthetic.scene import Scene
from perception.types import DepthFrame, VehiclePose
from tests.perception.scenes import D435, MOUNTING, MakeStage, outside_m, pose

NOBODY = np.zeros((0, 3))
NOTHING_BUT_GROUND = Scene()


def frames(scene: Scene, at: VehiclePose, number: int, flaws: Flaws | None = None) -> list[DepthFrame]:
    renderer = DepthRenderer(scene, D435, flaws=flaws or Flaws())
    return [DepthFrame(k / 30, k, renderer.render(camera_pose(at, MOUNTING), k), 0.001, D435) for k in range(number)]


def pipeline(ground_down_m: float = 0.0, **changes: object) -> PerceptionPipeline:
    return PerceptionPipeline(PerceptionParameters(memory_s=0.0, **changes), MOUNTING, ground_down_m=ground_down_m)


def sighting(frame: DepthFrame, at: VehiclePose) -> Sighting:
    found = Extractor(PerceptionParameters(), MOUNTING, 0.3, 10.0, 0.0).extract(frame, at, NOBODY).sighting
    assert found is not None
    return found


def share_found(scene: Scene, distance_m: float) -> float:
    """Of 20 noisy frames, in how many a disc stands within 0.5 m of what is straight ahead there."""
    process = pipeline()
    discs = [process.process(frame, pose()).discs for frame in frames(scene, pose(), 20)]
    return float(np.mean([np.any(np.hypot(one[:, 0] - distance_m, one[:, 1]) < 0.5) for one in discs]))


class TestThinThings:
    def test_an_upright_pole_of_3_cm_at_5_m(self) -> None:
        assert share_found(Scene(cylinders=np.array([[5.1, 0.0, 0.015, 9.0]])), 5.1) >= 0.95

    def test_a_level_branch_of_4_cm_at_4_m(self) -> None:
        branch = Scene(capsules=np.array([[4.1, -0.5, -5.1, 4.1, 0.5, -5.1, 0.02]]))
        assert share_found(branch, 4.1) >= 0.95

    def test_both_ends_of_the_branch_are_covered(self) -> None:
        ends = np.array([[4.1, -0.45], [4.1, 0.45]])
        process, branch = pipeline(), Scene(capsules=np.array([[4.1, -0.5, -5.1, 4.1, 0.5, -5.1, 0.02]]))
        gaps = [outside_m(ends, process.process(frame, pose()).discs).max() for frame in frames(branch, pose(), 10)]
        assert np.mean(np.array(gaps) < 0.15) >= 0.8


class TestWhatIsNotThere:
    @pytest.mark.parametrize("pitch_deg", [-20.0, 0.0])
    def test_clumped_speckle_is_no_obstacle(self, pitch_deg: float) -> None:
        at, process = pose(pitch_deg=pitch_deg), pipeline()
        for frame in frames(NOTHING_BUT_GROUND, at, 60, Flaws(speckles=40)):
            assert len(process.process(frame, at).discs) == 0

    def test_a_larger_clump_than_speckle_is_an_obstacle(self) -> None:
        (frame,) = frames(NOTHING_BUT_GROUND, pose(), 1)
        frame.depth[200:240, 400:440] = 4000
        assert len(pipeline().process(frame, pose()).discs) == 1

    @pytest.mark.parametrize("spread_m", [0.05, 1.0])
    @pytest.mark.parametrize("flying", [0.3, 0.5])
    def test_pixels_that_fly_between_a_pole_and_the_wall_behind_it_are_no_obstacle(
        self, scene: MakeStage, flying: float, spread_m: float
    ) -> None:
        world = scene(cylinders=[(3.0, 0.0, 0.15, 9.0)], boxes=[(8.0, 0.0, 0.5, 14.0, 9.0, 0.0)])
        random, process = np.random.default_rng(2), pipeline()
        for _ in range(20):
            frame = world.shoot(pose())
            near = (frame.depth > 2500) & (frame.depth < 3300)
            beside = (np.roll(near, 1, 1) | np.roll(near, -1, 1)) & ~near
            flies = beside & (random.random(near.shape) < flying)
            frame.depth[flies] = np.clip(random.normal(4400, 1000 * spread_m, np.count_nonzero(flies)), 3300, 7200)
            discs = process.process(frame, pose()).discs
            front_m = discs[:, 0] - discs[:, 2]
            assert np.any(front_m < 3.2)
            assert not np.any((front_m > 3.4) & (front_m < 6.5))

    @pytest.mark.parametrize("error_m", [-0.5, 0.5])
    @pytest.mark.parametrize("height_m", [1.0, 1.3, 5.0])
    @pytest.mark.parametrize("pitch_deg", [-20.0, 0.0])
    def test_ground_half_a_metre_off_is_still_ground(self, error_m: float, height_m: float, pitch_deg: float) -> None:
        at, process = pose(height=height_m, pitch_deg=pitch_deg), pipeline(ground_down_m=error_m)
        for frame in frames(NOTHING_BUT_GROUND, at, 3):
            assert len(process.process(frame, at).discs) == 0

    @pytest.mark.parametrize("height_m", [1.5, 3.0, 10.0, 20.0])
    @pytest.mark.parametrize("roll_deg", [0.0, 30.0])
    @pytest.mark.parametrize("pitch_deg", [-30.0, 0.0, 30.0])
    def test_at_any_height_and_attitude_a_tree_is_found_and_the_ground_is_not(
        self, height_m: float, roll_deg: float, pitch_deg: float
    ) -> None:
        at = pose(height=height_m, roll_deg=roll_deg, pitch_deg=pitch_deg)
        (bare,) = frames(NOTHING_BUT_GROUND, at, 1)
        (wooded,) = frames(Scene(cylinders=np.array([[3.5, 0.0, 0.25, 30.0]])), at, 1)
        assert len(pipeline().process(bare, at).discs) == 0
        discs = pipeline().process(wooded, at).discs
        assert len(discs) == 1
        assert discs[0, :2] == pytest.approx([3.5, 0.0], abs=0.25)


class TestTheHeightBand:
    """A beam across the way, 1.6 m above the vehicle, at 5 m."""

    BEAM = Scene(capsules=np.array([[5.0, -3.0, -6.6, 5.0, 3.0, -6.6, 0.1]]))

    @pytest.mark.parametrize(("climb_m_s", "is_in_the_way"), [(0.0, False), (-1.0, False), (1.0, True), (2.0, True)])
    def test_what_is_above_it_appears_when_climbing_towards_it(self, climb_m_s: float, is_in_the_way: bool) -> None:
        at = replace(pose(), velocity_ned_m_s=(0.0, 0.0, -climb_m_s))
        (frame,) = frames(self.BEAM, at, 1)
        assert bool(len(pipeline().process(frame, at).discs)) is is_in_the_way

    @pytest.mark.parametrize(("error_deg", "is_in_the_way"), [(0.0, False), (2.0, False), (8.0, True)])
    def test_it_widens_by_what_the_attitude_may_be_wrong(self, error_deg: float, is_in_the_way: bool) -> None:
        (frame,) = frames(self.BEAM, pose(), 1)
        assert bool(len(pipeline(attitude_error_deg=error_deg).process(frame, pose()).discs)) is is_in_the_way


def test_what_the_pictures_upper_edge_cuts_off_is_not_too_low_to_count() -> None:
    (frame,) = frames(NOTHING_BUT_GROUND, pose(), 1)
    cut_off, hanging_free = frame.depth.copy(), frame.depth.copy()
    cut_off[0:40, 400:440], hanging_free[60:100, 400:440] = 1000, 1000
    assert len(pipeline().process(replace(frame, depth=cut_off), pose()).discs) == 1
    assert len(pipeline().process(replace(frame, depth=hanging_free), pose()).discs) == 0


def test_decimation_takes_measured_pixels_and_averages_none() -> None:
    """Columns in turn at 3 m and 6 m: nothing was measured at 4.5 m."""
    depth = np.zeros((480, 848), np.uint16)
    for column in range(0, 848, 16):
        depth[:, column : column + 8], depth[:, column + 8 : column + 16] = 3000, 6000
    for stride_px in (1, 2, 4):
        found = Extractor(PerceptionParameters(stride_px=stride_px), MOUNTING, 0.3, 10.0, None)
        seen = found.extract(DepthFrame(0.0, 1, depth, 0.001, D435), pose(), NOBODY).sighting
        assert seen is not None
        forward_m = seen.view.nearest_m[np.isfinite(seen.view.nearest_m)]
        assert len(forward_m) > 50
        assert np.all((np.abs(forward_m - 3.0) < 0.002) | (np.abs(forward_m - 6.0) < 0.002))


class TestIsWhole:
    def tree(self, north_m: float, east_m: float, *more: tuple[float, float, float, float]) -> tuple[bool, float]:
        """is_whole and confidence of the disc nearest to a tree of 0.25 m there."""
        world = Scene(cylinders=np.array([[north_m, east_m, 0.25, 12.0], *more]))
        seen = sighting(frames(world, pose(), 1)[0], pose())
        nearest = int(np.hypot(seen.discs[:, 0] - north_m, seen.discs[:, 1] - east_m).argmin())
        assert math.hypot(*(seen.discs[nearest, :2] - (north_m, east_m))) < 1.0
        return bool(seen.is_whole[nearest]), float(seen.confidence[nearest])

    def test_in_full_view(self) -> None:
        assert self.tree(5.0, 0.5)[0]

    def test_not_cut_by_the_pictures_edge(self) -> None:
        is_whole, confidence = self.tree(4.0, 3.93)
        assert not is_whole
        assert confidence < self.tree(4.0, 0.5)[1]

    def test_not_cut_by_the_range(self) -> None:
        is_whole, confidence = self.tree(9.0, 0.5)
        assert not is_whole
        assert confidence < self.tree(5.0, 0.5)[1]

    def test_not_cut_by_something_nearer(self) -> None:
        assert not self.tree(6.0, 0.0, (3.0, 0.16, 0.1, 12.0))[0]


@pytest.mark.parametrize("distance", [0.5, 0.7, 1.0, 1.5])
@pytest.mark.parametrize("slant_deg", [0.0, 30.0, 60.0, -45.0])
def test_the_discs_of_a_near_slanting_surface_do_not_reach_the_vehicle(
    scene: MakeStage, distance: float, slant_deg: float
) -> None:
    world = scene(boxes=[(distance + 0.1, 0.0, 0.04, 3.0, 9.0, slant_deg)])
    at = pose()
    found = pipeline().process(world.shoot(at), at)
    camera_north = MOUNTING.forward_m
    front = np.hypot(found.discs[:, 0] - camera_north, found.discs[:, 1]) - found.discs[:, 2]
    assert len(found.discs)
    assert front.min() > world.world.signed_distance_m(camera_north, 0.0, -5.0) - 0.2
