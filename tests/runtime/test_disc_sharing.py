"""The runtime tells obstacles once a second, by the time of the frame, no vehicle among them; a view refutes what was heard."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from flightapp.config.profile import load_profile
from flightapp.core.types import Limits, ObstacleSet, TargetTrack, VehicleState
from flightapp.fleet.messages.discs import Disc, Discs
from flightapp.runtime.disc_sharing import DiscSharing
from flightapp.runtime.perception_thread import Perceived, PerceptionHealth
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.teamwork import Teamwork
from perception.extraction.bearing_bins import SECTORS, TANGENT_BINS
from perception.geometry import CameraMounting, camera_pose
from perception.sighting import View
from perception.sources.api import SourceHealth
from perception.types import VehiclePose

PROFILE = load_profile(Path(__file__).parents[2] / "profiles/sim.toml")
OWN = VehicleState(0.0, np.array([0.0, 0.0, -5.0]), np.zeros(3), 0.0)
TARGET = TargetTrack(0.0, np.array([20.0, 0.0, -5.0]), np.zeros(3), 0.01 * np.eye(6), 0.0)
TREE, MATE, EVADER = (12.0, 1.0, 0.4), (8.0, 0.0, 0.4), (20.0, 0.1, 0.4)


class _Post:
    """Outlet and inlet at once."""

    def __init__(self) -> None:
        self.waiting: list[tuple[str, Discs]] = []
        self.sent: list[Discs] = []

    def outlet(self, _kind: object) -> _Post:
        return self

    inlet = outlet

    def put(self, message: Discs, _now_s: float) -> None:
        self.sent.append(message)

    def take(self, _now_s: float) -> list[tuple[str, Discs]]:
        taken, self.waiting = self.waiting, []
        return taken


def sharing(post: _Post, *, share: bool = True) -> DiscSharing:
    """Of p1, whose mate p2 flies at MATE towards the target."""
    state = SimpleNamespace(
        t_s=0.0,
        position_ned_m=(*MATE[:2], -5.0),
        velocity_ned_m_s=(0.0, 0.0, 0.0),
        goal_ned_m=None,
        airborne=True,
        phase="pursue",
    )
    vehicles = [SimpleNamespace(name=name, role=role) for name, role in (("p1", "pursuer"), ("p2", "pursuer"), ("e1", "evader"))]
    rooms: Any = SimpleNamespace(
        mission=SimpleNamespace(vehicles=vehicles),
        vehicle=vehicles[0],
        profile=PROFILE.model_copy(update={"network": PROFILE.network.model_copy(update={"share_discs": share})}),
        limits=Limits(**PROFILE.limits.model_dump()),
        team=SimpleNamespace(post=post, peers={"p2": SimpleNamespace(state=state)}),
    )
    teamwork: Any = SimpleNamespace(silent=(), evader_state=lambda: None)
    return DiscSharing(cast(Rooms, rooms), cast(Teamwork, teamwork))


def perceived(number: int, t_s: float, *discs: tuple[float, float, float], view: View | None = None) -> Perceived:
    table = np.zeros((len(discs), 7))
    table[:, :3] = np.array(discs).reshape(-1, 3)
    ones = np.ones(len(discs))
    seen = ObstacleSet(t_s, table, np.zeros((0, 2)))
    return Perceived(seen, 0.0 * ones, ones, t_s, number, 0.0, 0.0, PerceptionHealth(SourceHealth()), view=view)


def free_ahead() -> View:
    camera = camera_pose(VehiclePose((0.0, 0.0, -5.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0), CameraMounting())
    nothing, far = np.full(TANGENT_BINS, math.inf), np.full(TANGENT_BINS, 10.0)
    return View(camera, np.ones(SECTORS, np.bool_), nothing, far, 0.3, 10.0)


def test_what_stands_is_told_once_a_second_by_when_it_was_seen_and_no_vehicle_is() -> None:
    post = _Post()
    one = sharing(post)
    for tick in range(60):
        now_s = tick * 0.05
        one.poll(now_s, OWN, TARGET, perceived(tick, now_s - 0.03, TREE, MATE, EVADER))
    # From 1.2 s on the mate, not heard since 0, may be what stands there: a vehicle is never told.
    assert [message.discs for message in post.sent] == [(Disc(*TREE, 0.0, 0.0),)] * 2
    np.testing.assert_allclose([message.t_s for message in post.sent], (-0.03, 0.97))


def test_what_was_told_goes_to_the_planner_until_the_own_camera_sees_the_place_free() -> None:
    post = _Post()
    one = sharing(post)
    seen = perceived(1, 0.0, TREE)
    post.waiting = [
        ("p2", Discs(0.0, (Disc(7.0, 2.0, 0.5, 0.0, 0.0), Disc(-7.0, 2.0, 0.5, 0.0, 0.0)))),
        ("e1", Discs(0.0, (Disc(5.0, -4.0, 0.5, 0.0, 0.0),))),
    ]
    one.poll(0.0, OWN, TARGET, seen)
    both = one.for_planner(0.0, OWN, TARGET, seen.obstacles)
    assert both.discs[:, :2].tolist() == [[12.0, 1.0], [7.0, 2.0], [-7.0, 2.0]]
    assert both.discs[1, 3:].tolist() == [0.0, 0.0, -math.inf, math.inf]
    one.poll(0.1, OWN, TARGET, perceived(2, 0.1, TREE, view=free_ahead()))
    one.poll(0.2, OWN, TARGET, perceived(3, 0.2, TREE))
    assert one.for_planner(0.2, OWN, TARGET, seen.obstacles).discs[:, :2].tolist() == [[12.0, 1.0], [-7.0, 2.0]]


def test_switched_off_it_tells_nothing_and_hands_on_what_the_camera_sees() -> None:
    post = _Post()
    one = sharing(post, share=False)
    seen = perceived(1, 0.0, TREE)
    post.waiting = [("p2", Discs(0.0, (Disc(7.0, 2.0, 0.5, 0.0, 0.0),)))]
    one.poll(0.0, OWN, TARGET, seen)
    assert one.for_planner(0.0, OWN, TARGET, seen.obstacles) is seen.obstacles
    assert not post.sent
