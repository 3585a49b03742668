"""What holds of tracking whatever comes: any sequence of frames, blind frames, exclusions and jumps of time."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from perception.parameters import PerceptionParameters
from perception.sighting import Sighting
from perception.tracking.tracker import TRACKS_MAX, DiscTracker, TrackedDiscs
from tests.perception.sightings import NO_DISCS, Lookout

SCENE_M = 12.0
SPEED_BOUND_M_S = 60.0
places = st.floats(-SCENE_M, SCENE_M)
discs = st.lists(st.tuples(places, places, st.floats(0.01, 3.0), st.floats(0.0, 1.0), st.booleans()), max_size=12)
circles = st.lists(st.tuples(places, places, st.floats(0.1, 3.0)), max_size=3).map(lambda rows: np.array(rows).reshape(-1, 3))
steps = st.one_of(st.sampled_from([1 / 90, 1 / 30, 0.1]), st.floats(1e-6, 20.0))
jumps_back = st.floats(0.21, 1e6)
angles = st.floats(-math.pi, math.pi)


class Tracking(RuleBasedStateMachine):
    """A camera among objects that the rules add, move and remove; any disc may be anything."""

    @initialize(memory_s=st.sampled_from([0.0, 0.5, 3.0]), growth=st.sampled_from([0.0, 0.05, 2.0]), noise=st.booleans())
    def begin(self, memory_s: float, growth: float, noise: bool) -> None:
        self.memory_s = memory_s
        self.tracker = DiscTracker(PerceptionParameters(memory_s=memory_s, memory_growth_m_s=growth))
        self.camera = Lookout(noise=0.004 if noise else 0.0)
        self.objects = np.zeros((0, 3))
        self.t_s = 0.0
        self.exclude = NO_DISCS
        self.found = TrackedDiscs(np.zeros((0, 5)), np.zeros(0), np.zeros(0))

    def update(self, sighting: Sighting | None) -> None:
        self.found = self.tracker.update(self.t_s, sighting, self.exclude)
        if sighting is None:
            return
        outside = np.isfinite(sighting.discs).all(axis=1)
        for north, east, radius in self.exclude:
            outside &= np.hypot(sighting.discs[:, 0] - north, sighting.discs[:, 1] - east) > radius
        now = self.found.discs
        for disc, sigma_m in zip(sighting.discs[outside], sighting.sigma_m[outside], strict=True):
            gap = np.hypot(now[:, 0] - disc[0], now[:, 1] - disc[1])
            # The filter moves a disc by less than the gate, and one that contains it may stand for it.
            assert (gap - np.maximum(now[:, 2] - disc[2], 0.0)).min(initial=np.inf) <= 1.5 + 4 * sigma_m

    @rule(step_s=steps, rows=discs, yaw=angles)
    def see_anything(self, step_s: float, rows: list[tuple[float, float, float, float, bool]], yaw: float) -> None:
        self.t_s += step_s
        values = np.array(rows, np.float64).reshape(-1, 5)
        view = self.camera.look(NO_DISCS, yaw=yaw).view
        sigma_m = 0.004 * (values[:, 0] ** 2 + values[:, 1] ** 2)
        self.update(Sighting(values[:, :3].copy(), sigma_m, values[:, 3].copy(), values[:, 4] > 0, view))

    @rule(step_s=steps, yaw=angles, north=places, background_m=st.sampled_from([0.0, 8.0]))
    def see_the_scene(self, step_s: float, yaw: float, north: float, background_m: float) -> None:
        self.t_s += step_s
        self.camera.background_m = background_m
        self.update(self.camera.look(self.objects, north=north, yaw=yaw))

    @rule(yaw=angles, velocity=st.tuples(st.floats(-6, 6), st.floats(-6, 6)))
    def see_the_scene_move(self, yaw: float, velocity: tuple[float, float]) -> None:
        for _ in range(12):
            self.t_s += 1 / 30
            self.objects[:, :2] += np.array(velocity) / 30
            self.update(self.camera.look(self.objects, yaw=yaw))

    @rule(step_s=steps)
    def see_nothing(self, step_s: float) -> None:
        self.t_s += step_s
        self.update(None)

    @rule(late_s=st.floats(0.0, 0.19))
    def come_late(self, late_s: float) -> None:
        self.found = self.tracker.update(self.t_s - late_s, self.camera.look(self.objects), self.exclude)

    @rule(back_s=jumps_back, is_blind=st.booleans())
    def set_the_clock_back(self, back_s: float, is_blind: bool) -> None:
        self.t_s -= back_s
        self.update(None if is_blind else self.camera.look(self.objects))

    @rule(t_s=st.sampled_from([math.nan, math.inf, -math.inf]))
    def come_at_no_time(self, t_s: float) -> None:
        self.found = self.tracker.update(t_s, self.camera.look(self.objects), self.exclude)

    @rule(exclude=circles)
    def exclude_some(self, exclude: np.ndarray) -> None:
        self.exclude = exclude
        self.t_s += 1 / 30
        self.update(self.camera.look(self.objects))

    @rule(rows=st.lists(st.tuples(places, places, st.floats(0.05, 1.5)), max_size=8))
    def change_the_scene(self, rows: list[tuple[float, float, float]]) -> None:
        self.objects = np.array(rows, np.float64).reshape(-1, 3)

    @rule()
    def forget(self) -> None:
        self.tracker.clear()
        self.exclude = NO_DISCS
        self.found = TrackedDiscs(np.zeros((0, 5)), np.zeros(0), np.zeros(0))

    @invariant()
    def is_well_formed(self) -> None:
        found = self.found
        assert found.discs.shape == (len(found.age_s), 5)
        assert found.confidence.shape == found.age_s.shape
        assert len(found.discs) <= TRACKS_MAX
        assert np.isfinite(found.discs).all()
        assert (found.discs[:, 2] > 0).all()
        assert (found.age_s >= 0).all()
        assert (found.age_s <= self.memory_s).all()
        assert ((found.confidence >= 0) & (found.confidence <= 1)).all()
        assert (np.hypot(found.discs[:, 3], found.discs[:, 4]) < SPEED_BOUND_M_S).all()
        for north, east, radius in self.exclude:
            assert (np.hypot(found.discs[:, 0] - north, found.discs[:, 1] - east) > radius).all()


# A failing sequence is short enough as it is found: making it shorter takes minutes.
Tracking.TestCase.settings = settings(
    max_examples=60, stateful_step_count=30, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate)
)
TestTracking = Tracking.TestCase
