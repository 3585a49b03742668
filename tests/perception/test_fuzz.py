"""Whatever comes in, `process` answers: no exception, and an answer in which every number can be used."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from perception.parameters import PerceptionParameters
from perception.pipeline import NO_EXCLUSION, PerceptionPipeline
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose
from tests.perception.scenes import MOUNTING, pose

WIDTH, HEIGHT = 64, 48
LENS = Intrinsics(WIDTH, HEIGHT, 32.0, 32.0, 32.0, 24.0)
SHARED = PerceptionPipeline(PerceptionParameters(), MOUNTING)
"""Kept over all examples: what one bad frame leaves behind must not hurt the next one either."""

anything = st.floats(allow_nan=True, allow_infinity=True)
lengths = st.one_of(anything, st.integers(-(10**6), 10**6))
dtypes = st.sampled_from([np.uint16, np.uint8, np.int16, np.float32, np.float64, np.int64, np.bool_, np.dtype(">u2")])
poses = st.builds(
    VehiclePose, st.tuples(anything, anything, anything), st.tuples(anything, anything, anything), anything, anything, anything
)
sane_poses = st.builds(
    lambda height, roll, pitch, yaw: pose(height=height, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw),
    *(st.floats(low, high) for low, high in ((-1.0, 50.0), (-180.0, 180.0), (-90.0, 90.0), (-180.0, 180.0))),
)
images = st.one_of(
    dtypes.flatmap(lambda dtype: arrays.arrays(dtype, arrays.array_shapes(min_dims=0, max_dims=3, max_side=70))),
    arrays.arrays(np.uint16, (HEIGHT, WIDTH), elements=st.sampled_from([0, 1, 299, 300, 1000, 5000, 9999, 30000, 65534, 65535])),
    st.builds(lambda image: image[::-1, ::-1], arrays.arrays(np.uint16, (HEIGHT, WIDTH))),
    st.builds(
        lambda seed, share: np.where(np.random.default_rng(seed).random((HEIGHT, WIDTH)) < share, 4000, 0).astype(np.uint16),
        st.integers(0, 1000),
        st.floats(0, 1),
    ),
)
lenses = st.one_of(
    st.just(LENS), st.builds(Intrinsics, st.integers(-5, 100), st.integers(-5, 100), lengths, lengths, lengths, lengths)
)
exclusions = st.one_of(
    st.just(NO_EXCLUSION), arrays.arrays(np.float64, st.tuples(st.integers(0, 4), st.integers(0, 4)), elements=anything)
)


def assert_usable(found: PerceivedObstacles) -> None:
    discs = found.discs
    assert discs.shape[1:] == (7,)
    assert found.age_s.shape == found.confidence.shape == (len(discs),)
    assert np.isfinite(discs[:, :5]).all()
    assert np.all(discs[:, 2] > 0)
    assert np.all(found.age_s >= 0)
    assert np.isfinite(found.age_s).all()
    assert np.all((found.confidence >= 0) & (found.confidence <= 1))
    starts, ends = found.unseen[:, 0], found.unseen[:, 1]
    assert np.all(starts < ends)
    assert np.all(ends[:-1] <= starts[1:])
    assert starts.min() >= -math.pi
    assert ends.max() <= math.pi
    assert all(event and "\n" not in event for event in found.events)


@given(
    images,
    st.one_of(sane_poses, poses),
    lenses,
    st.one_of(st.just(0.001), lengths),
    st.one_of(st.floats(0, 100), anything),
    exclusions,
)
@settings(max_examples=300, deadline=None)
def test_anything_at_all_gets_a_usable_answer(
    image: np.ndarray, at: VehiclePose, lens: Intrinsics, unit: float, t_s: float, exclude: np.ndarray
) -> None:
    assert_usable(SHARED.process(DepthFrame(t_s, 1, image, unit, lens), at, exclude))


@given(
    st.lists(st.tuples(images, sane_poses), min_size=2, max_size=5),
    st.lists(st.floats(0, 10), min_size=5, max_size=5),
)
@settings(max_examples=60, deadline=None)
def test_frames_in_any_order_of_time_get_usable_answers(shots: list[tuple[np.ndarray, VehiclePose]], times: list[float]) -> None:
    pipeline = PerceptionPipeline(PerceptionParameters(), MOUNTING)
    for t_s, (image, at) in zip(times, shots, strict=False):
        assert_usable(pipeline.process(DepthFrame(t_s, 1, image, 0.001, LENS), at))


@given(st.integers(0, 2**32 - 1), st.floats(0, 1), sane_poses)
@settings(max_examples=100, deadline=None)
def test_noise_of_the_right_size_gets_a_usable_answer(seed: int, share: float, at: VehiclePose) -> None:
    random = np.random.default_rng(seed)
    image = random.integers(0, 65536, (HEIGHT, WIDTH), np.uint16)
    image[random.random(image.shape) > share] = 0
    assert_usable(SHARED.process(DepthFrame(seed / 1000, 1, image, 0.001, LENS), at))
