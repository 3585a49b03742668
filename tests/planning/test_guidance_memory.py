"""The short-term memory of discs."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.ac2f.disc_memory import recall_discs, remember_discs
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.recollection import DISCS, blank_recollection
from flightapp.planning.ac2f.records import VIEW, blank_memory, parameter_record
from tests.planning.closed_loop import limits

ALL_ROUND = np.zeros((0, 2))
NOBODY = np.zeros((0, 2))
AHEAD = np.array([[math.radians(43.0), math.radians(-43.0)]])


class Memory:
    """The kernels with what they need between steps."""

    def __init__(self, **changes: object) -> None:
        self.parameters = parameter_record(Ac2fParameters.model_validate(changes), limits())
        self.memory = blank_memory()
        self.recollection = blank_recollection()
        self.view = np.zeros(1, VIEW)

    def see(
        self, t_s: float, discs: Array, own: tuple[float, float] = (0.0, 0.0), unseen: Array = ALL_ROUND, vehicles: Array = NOBODY
    ) -> Array:
        """Known discs (k, 3) after an observation at `t_s` of `discs` (n, >=3)."""
        self.view["t_s"] = t_s
        self.view["own_n"], self.view["own_e"] = own
        full = np.zeros((len(discs), 7))
        full[:, : discs.shape[1]] = discs
        remember_discs(self.parameters, self.memory, self.view, full, t_s, unseen, vehicles, self.recollection)
        return self.known

    @property
    def known(self) -> Array:
        return self.recollection["discs"][0, : self.memory["disc_count"][0], :3].copy()

    def recalled(self, vehicles: Array = NOBODY) -> Array:
        scene = np.zeros((DISCS, 6))
        count = recall_discs(self.parameters, self.memory, self.view, vehicles, self.recollection, scene, 0)
        return scene[:count]


def discs(*rows: tuple[float, ...]) -> Array:
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1 if rows else 3)


@settings(max_examples=60)
@given(
    st.lists(
        st.lists(
            st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(0.1, 2.0), st.floats(-0.5, 0.5)), min_size=0, max_size=120
        ),
        min_size=1,
        max_size=6,
    )
)
def test_never_more_than_its_capacity_and_nothing_but_what_was_seen(
    frames: list[list[tuple[float, float, float, float]]],
) -> None:
    memory = Memory(disc_memory_sight_m=0.0)
    seen: list[tuple[float, float, float]] = []
    for k, frame in enumerate(frames):
        observed = discs(*frame) if frame else np.zeros((0, 4))
        known = memory.see(0.1 * k, observed)
        seen += [row[:3] for row in frame if abs(row[3]) <= 0.3]
        assert len(known) <= min(DISCS, len(seen))
        places = np.array(seen).reshape(-1, 3)
        for north, east, _ in known:
            gap = np.hypot(places[:, 0] - north, places[:, 1] - east)
            assert gap.min() <= 0.35 + 1e-9  # a mean of sightings that are within the gate of one another


@given(st.floats(0.5, 12.0), st.floats(-math.pi, math.pi), st.floats(0.2, 1.5))
def test_a_disc_that_left_the_view_stays_until_it_expires(distance: float, bearing: float, radius: float) -> None:
    memory = Memory(disc_memory_s=4.0)
    place = (distance * math.cos(bearing), distance * math.sin(bearing))
    memory.see(0.0, discs((*place, radius)))
    behind = np.array([[bearing - 1.0, bearing + 1.0]])
    for k in range(1, 41):
        assert len(memory.see(0.1 * k, np.zeros((0, 3)), unseen=behind)) == 1
        assert len(memory.recalled()) == 1
    assert len(memory.see(4.11, np.zeros((0, 3)), unseen=behind)) == 0


def test_what_is_seen_now_is_not_recalled_a_second_time() -> None:
    memory = Memory()
    memory.see(0.0, discs((5.0, 0.0, 0.5)))
    assert len(memory.recalled()) == 0
    memory.see(0.1, np.zeros((0, 3)), unseen=AHEAD + math.pi)
    scene = memory.recalled()
    assert scene[0].tolist() == [5.0, 0.0, 1.3, 0.0, 0.0, 0.0]


def test_noise_averages_and_does_not_multiply() -> None:
    memory = Memory()
    random = np.random.default_rng(0)
    wall = np.array([(6.0, 0.8 * k - 4.0, 0.5) for k in range(11)])
    for k in range(100):
        noisy = wall.copy()
        noisy[:, :2] += random.normal(0.0, 0.05, (len(wall), 2))
        memory.see(0.1 * k, noisy)
    known = memory.known
    assert len(known) == len(wall)
    known = known[np.argsort(known[:, 1])]
    assert np.abs(known - wall).max() < 0.08


def test_a_place_that_is_seen_to_be_empty_is_forgotten() -> None:
    memory = Memory()
    memory.see(0.0, discs((4.0, 0.0, 0.5), (4.0, 3.0, 0.5), (9.0, 0.0, 0.5)))
    for k in range(1, 6):
        memory.see(0.1 * k, discs((2.0, 1.5, 0.3)), unseen=AHEAD)  # hides the second, the third is out of sight
    assert sorted(memory.known.tolist()) == [[2.0, 1.5, 0.3], [4.0, 3.0, 0.5], [9.0, 0.0, 0.5]]


def test_one_missed_sighting_forgets_nothing() -> None:
    memory = Memory()
    wall = discs((4.0, 0.0, 0.5))
    memory.see(0.0, wall)
    for k in range(1, 10):
        memory.see(0.1 * k, wall if k % 2 else np.zeros((0, 3)))
    assert len(memory.known) == 1


def test_vehicles_and_what_moves_are_not_remembered() -> None:
    memory = Memory()
    memory.see(0.0, discs((4.0, 0.0, 0.3, 0.0, 0.0), (6.0, 2.0, 0.5, 0.4, 0.0)), vehicles=np.array([[4.1, 0.1]]))
    assert len(memory.known) == 0
    memory.see(0.1, discs((4.0, 0.0, 0.3)))
    memory.see(0.2, np.zeros((0, 3)), unseen=AHEAD + math.pi)
    assert len(memory.recalled(np.array([[4.1, 0.1]]))) == 0  # a vehicle is there by now


def test_switched_off() -> None:
    memory = Memory(disc_memory_s=0.0)
    assert len(memory.see(0.0, discs((4.0, 0.0, 0.5)))) == 0
