"""What is taken for a sighting of the evader, and what is not, without a fleet around it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from flightapp.config.mission import TargetKnowledge
from flightapp.core.types import ObstacleSet
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.messages.sighting import Sighting
from flightapp.runtime.perception_thread import Perceived, PerceptionHealth
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.target_fusion import TargetFusion
from flightapp.runtime.teamwork import Teamwork
from perception.sources.api import SourceHealth

SPEED_M_S = 2.0
SILENT_FROM_S = 2.0
NOBODY = np.zeros((0, 3))


class _Post:
    """Keeps what is sent; nobody answers."""

    def __init__(self) -> None:
        self.sent: list[Sighting] = []

    def outlet(self, _kind: object) -> Any:
        return SimpleNamespace(put=lambda message, _now_s: self.sent.append(message))

    def inlet(self, _kind: object, depth: int) -> Any:
        return SimpleNamespace(take=lambda _now_s: [])


class _Chase:
    """A pursuer at the origin; the evader flies east, 8 m north of it, and falls silent at SILENT_FROM_S."""

    def __init__(self, knowledge: TargetKnowledge | None = None) -> None:
        self.post, self.used, self.frame = _Post(), 0, 0
        self.state: Any = None
        rooms = SimpleNamespace(
            mission=SimpleNamespace(target=knowledge or TargetKnowledge()),
            vehicle=SimpleNamespace(role="pursuer", name="p1"),
            team=SimpleNamespace(post=self.post),
            limits=SimpleNamespace(body_radius_m=0.3),
            profile=SimpleNamespace(safety=SimpleNamespace(team_state_age_max_s=0.5)),
            target_filter=TargetFilter(),
            journal=SimpleNamespace(target=lambda *_: None, sighting=self._note),
        )
        teamwork = SimpleNamespace(evader_state=lambda: self.state, cut_outs=lambda _now_s: NOBODY)
        self.fusion = TargetFusion(cast(Rooms, rooms), cast(Teamwork, teamwork))
        for step in range(round(SILENT_FROM_S * 20) + 1):
            t_s = step / 20
            self.state = SimpleNamespace(
                sequence=step,
                vehicle="e1",
                t_s=t_s,
                position_ned_m=(*place(t_s), -5.0),
                velocity_ned_m_s=(0.0, SPEED_M_S, 0.0),
                airborne=True,
            )
            self.track = self.fusion.update(t_s, "pursue", None)

    def look(self, t_s: float, discs: np.ndarray | None = None, left_out: tuple[float, float] = (math.nan, math.nan)) -> None:
        """One tick with a new frame."""
        self.frame += 1
        rows = np.zeros((0, 7)) if discs is None else discs
        zeros, health = np.zeros(len(rows)), PerceptionHealth(SourceHealth())
        obstacles = ObstacleSet(t_s, rows, np.zeros((0, 2)))
        perceived = Perceived(
            obstacles, zeros, zeros + 1.0, t_s, self.frame, 0.0, 0.0, health, (), np.array([left_out]), (0.0, 0.0)
        )
        self.track = self.fusion.update(t_s, "pursue", perceived)

    def _note(self, _t_s: float, source: str, *rest: Any) -> None:
        self.used += source == "camera" and rest[3].is_used


def place(t_s: float) -> tuple[float, float]:
    return 8.0, SPEED_M_S * (t_s - SILENT_FROM_S)


def disc(at: tuple[float, float], v_east_m_s: float = SPEED_M_S, radius_m: float = 0.3) -> list[float]:
    return [*at, radius_m, 0.0, v_east_m_s, -math.inf, math.inf]


def test_the_surface_in_the_cut_out_keeps_a_silent_evader_in_the_track() -> None:
    chase = _Chase()
    for step in range(1, 61):
        t_s = SILENT_FROM_S + step / 30
        north, east = place(t_s)
        chase.look(t_s, left_out=(north - 0.23, east))
    assert chase.track is not None
    assert chase.track.age_s < 0.1
    assert np.linalg.norm(chase.track.position_ned_m[:2] - place(SILENT_FROM_S + 2.0)) < 0.2
    assert len(chase.post.sent) == chase.used == 20  # Ten a second of thirty frames.


def test_the_cut_out_follows_the_track_while_it_is_sharp_and_ends_when_it_is_not() -> None:
    chase = _Chase()
    fresh = chase.fusion.cut_outs(SILENT_FROM_S + 0.1)
    assert fresh[0, :2] == pytest.approx(place(SILENT_FROM_S + 0.1))
    chase.fusion.update(SILENT_FROM_S + 0.52, "pursue", None)
    assert chase.fusion.cut_outs(SILENT_FROM_S + 0.52)[0, :2] == pytest.approx(place(SILENT_FROM_S + 0.52), abs=0.3)
    chase.fusion.update(SILENT_FROM_S + 2.0, "pursue", None)
    assert np.isnan(chase.fusion.cut_outs(SILENT_FROM_S + 2.0)).all()


def test_one_single_moving_thing_near_enough_is_the_evader_again() -> None:
    chase, t_s = _Chase(), SILENT_FROM_S + 0.8
    chase.look(t_s, np.array([disc(place(t_s))]))
    assert chase.used == 1
    assert chase.track is not None
    assert chase.track.age_s == 0.0


@pytest.mark.parametrize(
    "things",
    [
        [disc(place(SILENT_FROM_S + 0.8), v_east_m_s=0.0)],
        [disc(place(SILENT_FROM_S + 0.8), radius_m=1.5)],
        [disc((8.0, 12.0))],
        [disc((8.0, 1.4)), disc((8.0, 1.8))],
    ],
    ids=["a tree", "a car", "far away", "two of them"],
)
def test_when_in_doubt_there_is_no_sighting(things: list[list[float]]) -> None:
    chase = _Chase()
    chase.look(SILENT_FROM_S + 0.8, np.array(things))
    assert not chase.post.sent
    assert chase.track is not None
    assert chase.track.age_s == pytest.approx(0.8)


def test_a_mission_may_hold_a_silent_evader_for_lost() -> None:
    chase, t_s = _Chase(TargetKnowledge(when_silent="lost")), SILENT_FROM_S + 0.8
    chase.look(t_s, np.array([disc(place(t_s))]), place(t_s))
    assert not chase.post.sent
    assert chase.track is not None
    assert chase.track.age_s == pytest.approx(0.8)
    assert np.isnan(chase.fusion.cut_outs(t_s)).all()


def test_where_telemetry_counts_until_the_pursuit_only_it_starts_no_track_in_it() -> None:
    assert _Chase(TargetKnowledge(telemetry="until-pursuit")).track is None
