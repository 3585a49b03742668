"""The drawing: a disc where it is, in the colour of its age, with a label that can be read."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.geometry import CameraMounting, camera_pose
from perception.sources.api import SourceHealth
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose
from perception.view.lettering import BLACK, Labels, shortened, text_width_px
from perception.view.palette import EXCLUDED, REMEMBERED, SEEN_NOW, UNSEEN, VELOCITY
from perception.view.picture import draw, with_notice
from perception.view.shot import Shot, Timing
from perception.view.top_view import WIDTH_PX, HeightSlice

LENS = Intrinsics(64, 48, 40.0, 40.0, 32.0, 24.0)
SLICE = HeightSlice(band_m=1.0, ground_down_m=0.0, ground_margin_m=0.3, ground_margin_slope=0.03)
TIMING = Timing(rate_hz=29.97, process_s=0.002, process_p50_s=0.002, process_p99_s=0.004)
LEFT = 640  # of the top view: 64x48 pixels are shown ten times as large
HALF_SEEN = np.array([[math.pi / 4, math.pi], [-math.pi, -math.pi / 4]])


def shot_of(
    *discs: tuple[float, ...],
    age_s: float = 0.0,
    confidence: float = 1.0,
    at: VehiclePose | None = None,
    exclude: list[tuple[float, float, float]] | None = None,
    unseen: np.ndarray = HALF_SEEN,
    depth: np.ndarray | None = None,
    events: tuple[str, ...] = (),
) -> Shot:
    """discs: north_m, east_m, radius_m and, if it moves, the velocity."""
    rows = np.zeros((len(discs), 7))
    for row, disc in zip(rows, discs, strict=True):
        row[: len(disc)] = disc
    vehicle = at or VehiclePose((0.0, 0.0, -2.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    frame = DepthFrame(1.5, 7, np.zeros((48, 64), np.uint16) if depth is None else depth, 0.001, LENS)
    obstacles = PerceivedObstacles(1.5, rows, np.full(len(rows), age_s), np.full(len(rows), confidence), unseen, events)
    excluded = np.array(exclude or np.zeros((0, 3)), float)
    return Shot("seven", frame, vehicle, camera_pose(vehicle, CameraMounting()), excluded, obstacles, SourceHealth(7), TIMING)


def drawn(shot: Shot, view_range_m: float = 10.0) -> np.ndarray:
    return draw(shot, SLICE, range_max_m=10.0, view_range_m=view_range_m)


def centre_of(picture: np.ndarray, colour: tuple[int, int, int], tolerance: int = 3) -> tuple[float, float]:
    """Mean x, y of the pixels of a colour in the top view, above its legend."""
    above_legend = picture[:455, LEFT:].astype(int)
    y, x = np.nonzero((np.abs(above_legend - colour) <= tolerance).all(axis=2))
    assert len(x), f"nothing has the colour {colour}"
    return float(x.mean()), float(y.mean())


PX_PER_M = 0.96 * 458 / 12.2
ORIGIN = (WIDTH_PX / 2, round(0.98 * 458 - 2.2 * PX_PER_M))


def place(ahead_m: float, aside_m: float) -> tuple[float, float]:
    return ORIGIN[0] + aside_m * PX_PER_M, ORIGIN[1] - ahead_m * PX_PER_M


class TestTopView:
    @given(ahead_m=st.floats(1.5, 8), aside_m=st.floats(-6, 6), yaw_rad=st.floats(-math.pi, math.pi))
    @settings(max_examples=20, deadline=None)
    def test_a_disc_stands_where_it_is_seen_from_the_vehicle(self, ahead_m: float, aside_m: float, yaw_rad: float) -> None:
        vehicle = VehiclePose((40.0, -25.0, -2.0), (0.0, 0.0, 0.0), 0.0, 0.0, yaw_rad)
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        disc = (40.0 + ahead_m * cos - aside_m * sin, -25.0 + ahead_m * sin + aside_m * cos, 0.5)
        x, y = centre_of(drawn(shot_of(disc, at=vehicle)), SEEN_NOW)
        assert (x, y) == pytest.approx(place(ahead_m, aside_m), abs=4)

    def test_what_is_remembered_has_another_colour(self) -> None:
        assert centre_of(drawn(shot_of((5.0, 0.0, 0.5), age_s=1.0)), REMEMBERED) == pytest.approx(place(5, 0), abs=3)
        with pytest.raises(AssertionError):
            centre_of(drawn(shot_of((5.0, 0.0, 0.5), age_s=1.0)), SEEN_NOW)

    def test_the_less_sure_the_paler(self) -> None:
        x, y = (round(number) for number in place(5, 0))
        inside = [int(drawn(shot_of((5.0, 0.0, 0.8), confidence=c))[y + 8, LEFT + x - 8].sum()) for c in (0.1, 0.5, 0.9)]
        assert inside == sorted(inside, reverse=True)
        assert inside[0] - inside[2] > 60

    def test_the_arrow_is_as_long_as_a_second_of_travel(self) -> None:
        picture = drawn(shot_of((5.0, 0.0, 0.3, 0.0, 2.0)))[:455, LEFT:].astype(int)
        _, x = np.nonzero((np.abs(picture - VELOCITY) <= 3).all(axis=2))
        assert x.max() == pytest.approx(place(5, 2)[0], abs=3)
        with pytest.raises(AssertionError):
            centre_of(drawn(shot_of((5.0, 0.0, 0.3, 0.0, 0.05))), VELOCITY)

    def test_an_excluded_circle_is_marked(self) -> None:
        assert centre_of(drawn(shot_of(exclude=[(6.0, -2.0, 1.0)])), EXCLUDED) == pytest.approx(place(6, -2), abs=3)

    def test_unseen_is_grey_and_seen_is_white(self) -> None:
        picture = drawn(shot_of())
        for ahead, aside, grey in ((5, 0, False), (5, 4.5, False), (5, 5.5, True), (5, -5.5, True), (-1.5, 0.5, True)):
            x, y = (round(number) for number in place(ahead, aside))
            patch = picture[y - 1 : y + 2, LEFT + x - 1 : LEFT + x + 2]
            assert (patch == UNSEEN).all() == grey, (ahead, aside)
        everything = drawn(shot_of(unseen=np.array([[-math.pi, math.pi]])))
        x, y = (round(number) for number in place(5, 0.5))
        assert tuple(everything[y, LEFT + x]) == UNSEEN

    def test_depth_above_the_ground_shows_as_dots(self) -> None:
        depth = np.zeros((48, 64), np.uint16)
        depth[24, 30:36] = 4000  # straight ahead: what a disc would come from
        depth[45, 30:36] = 4000  # 2.1 m below, on the ground
        bare, dotted = drawn(shot_of()), drawn(shot_of(depth=depth))
        y, x = np.nonzero((bare[:, LEFT:] != dotted[:, LEFT:]).any(axis=2))
        assert len(x)
        assert (x.mean(), y.mean()) == pytest.approx(place(4, 0.1), abs=8)


class TestDepthPanel:
    def test_a_disc_stands_in_the_image_where_it_is_seen(self) -> None:
        """2 m ahead, 0.5 m to the right: 10 pixels of 64 to the right of the middle, ten times as large."""
        picture = drawn(shot_of((2.2, 0.5, 0.2)))[:440, :LEFT].astype(int)
        _, x = np.nonzero((np.abs(picture - SEEN_NOW) <= 3).all(axis=2))
        assert x.mean() == pytest.approx(10 * (32 + 40 * 0.5 / 2.2), abs=12)

    @pytest.mark.parametrize("disc", [(-3.0, 0.0, 0.5), (0.0, 0.0, 0.3), (0.05, 0.0, 3.0), (1e6, 1e6, 0.1)])
    def test_discs_around_and_behind_the_camera_do_no_harm(self, disc: tuple[float, float, float]) -> None:
        assert drawn(shot_of(disc)).shape == (544, 640 + 560, 3)

    @pytest.mark.parametrize(
        ("height", "width"), [(48, 64), (480, 848), (720, 1280), (1080, 1920), (10, 400), (400, 10), (30, 33)]
    )
    def test_any_image_gives_a_picture_that_video_encoders_take(self, height: int, width: int) -> None:
        shot = shot_of((4.0, 0.0, 0.5), depth=np.full((height, width), 3000, np.uint16))
        lens = Intrinsics(width, height, width / 2, width / 2, width / 2, height / 2)
        picture = drawn(replace(shot, frame=replace(shot.frame, intrinsics=lens)))
        assert picture.shape[0] == 544
        assert picture.shape[1] % 16 == 0
        assert picture.shape[1] <= 1280 + WIDTH_PX

    def test_a_frame_of_the_wrong_size_is_still_shown(self) -> None:
        assert drawn(shot_of(depth=np.full((24, 64), 3000, np.uint16), events=("wrong size",))).shape[2] == 3


class TestLines:
    def test_an_event_changes_the_last_line(self) -> None:
        calm, alarmed = drawn(shot_of()), drawn(shot_of(events=("depth image is frozen",)))
        changed = np.flatnonzero((calm != alarmed).any(axis=(1, 2)))
        assert changed.min() > 544 - 24
        assert (with_notice(calm, "depth image is frozen") == alarmed).all()

    @given(text=st.text(max_size=300), width_px=st.integers(20, 400))
    @settings(max_examples=50, deadline=None)
    def test_a_line_is_cut_to_its_width(self, text: str, width_px: int) -> None:
        assert text_width_px(shortened(text, width_px)) <= width_px

    def test_a_short_line_is_left_alone(self) -> None:
        assert shortened("no events", 400) == "no events"


@given(anchors=st.lists(st.tuples(st.integers(0, 299), st.integers(0, 199)), min_size=1, max_size=12))
@settings(max_examples=40, deadline=None)
def test_labels_never_cover_each_other(anchors: list[tuple[int, int]]) -> None:
    """Each on paper of its own colour: what one label covers stays there while the others are put down."""
    picture = np.full((200, 300, 3), 255, np.uint8)
    labels = Labels(picture)
    papers = []
    for number, anchor in enumerate(anchors):
        paper = (0, 100 + number, 200 - number)
        if labels.put("8", anchor, [(dx, dy) for dy in (0, -20, 20, 40) for dx in (0, 30, -30)], BLACK, paper):
            papers.append(((picture == paper).all(axis=2), paper))
    for was, paper in papers:
        still = (picture == paper).all(axis=2)
        # A thin line that ties a later label to its anchor may cross; another label would take most of it.
        assert np.count_nonzero(still) > 0.6 * np.count_nonzero(was)
