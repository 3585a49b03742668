"""Field of view, range, occlusion, latency and noise of the compiled sensing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.types import Array
from flightapp.sim.batch.families.layout import Start, disc
from flightapp.sim.batch.noise import normal
from tests.sim.batch.stubs import command, scenario, set_moving, world

FAR_AWAY = Start(90.0, 90.0, 0.0)


def seen_by_rays(discs: Array, yaw: float, half_view: float, range_m: float, rays: int = 20_000) -> dict[int, float]:
    """Angle (rad) under which each disc is seen first from the origin: the plain reference, ray by ray."""
    angles = yaw + np.linspace(-half_view, half_view, rays)
    best, who = np.full(rays, np.inf), np.full(rays, -1)
    for k, (n, e, radius) in enumerate(discs[:, :3]):
        along = n * np.cos(angles) + e * np.sin(angles)
        aside2 = n * n + e * e - along**2
        entry = along - np.sqrt(np.maximum(radius**2 - aside2, 0.0))
        hit = (aside2 <= radius**2) & (along > 0.0) & (entry < best) & (math.hypot(n, e) - radius < range_m)
        best[hit], who[hit] = entry[hit], k
    return {k: float((who == k).sum()) * 2.0 * half_view / rays for k in range(len(discs)) if (who == k).any()}


@pytest.mark.parametrize("seed", range(12))
def test_what_is_seen_is_what_rays_meet(seed: int) -> None:
    random = np.random.default_rng(seed)
    rows: list[list[float]] = []
    while len(rows) < 25:
        n, e, radius = random.uniform(-12.0, 12.0), random.uniform(-12.0, 12.0), random.uniform(0.2, 1.5)
        if math.hypot(n, e) > radius + 0.3 and all(math.dist((n, e), r[:2]) > radius + r[2] + 0.05 for r in rows):
            rows.append(disc(n, e, radius))
    yaw, view_deg = float(random.uniform(-3.0, 3.0)), float(random.choice([87.0, 120.0, 360.0]))
    sees = scenario(pursuers__count=1, sensing__range_m=9.0, sensing__field_of_view_deg=view_deg, sensing__occlusion=True)
    seen = world(sees, [Start(0.0, 0.0, yaw)], FAR_AWAY, rows).obstacles(0)[0]
    reference = seen_by_rays(np.array(rows), yaw, math.radians(view_deg) / 2.0, 9.0)
    found = {next(k for k, row in enumerate(rows) if row[:3] == list(r[:3])) for r in seen.discs}
    for k in range(len(rows)):
        # a sliver beside the nearer disc may be judged either way: which of two is nearer is told by their nearest points
        assert k in found or reference.get(k, 0.0) < 0.02
        assert k not in found or k in reference
    if view_deg < 360.0:
        half = math.radians(view_deg) / 2.0
        np.testing.assert_allclose(np.cos(seen.unseen), np.cos([[yaw + half, yaw - half]]))
    else:
        assert len(seen.unseen) == 0


@pytest.mark.parametrize(("range_m", "count"), [(5.0, 1), (4.85, 0)])
def test_latency_shows_the_past(range_m: float, count: int) -> None:
    """0.06 s ago the disc was 4.98 m away, now it is 4.75 m."""
    late = scenario(pursuers__count=1, sensing__latency_s=0.06, sensing__range_m=range_m)
    flown = world(late, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [disc(8.0, 0.0, 0.5, 0.0, 1.0)])
    set_moving(flown, 0, 4.0, 0.0)
    for tick in range(7):
        flown.advance(tick, [command(4.0, 0.0), command(0.0, 0.0, 0.0)])
    seen = flown.obstacles(7)[0]
    assert seen.t_s == pytest.approx(0.64)
    assert len(seen.discs) == count
    for row in seen.discs:
        np.testing.assert_allclose(row[:5], [8.0, 0.64, 0.5, 0.0, 1.0], atol=1e-9)


def test_noise_is_as_told_and_the_same_for_every_planner() -> None:
    noisy = scenario(pursuers__count=1, sensing__position_noise_m=0.1, sensing__range_m=100.0)
    discs = [disc(float(n), 5.0, 0.3) for n in range(-20, 20)]
    first, second = (world(noisy, [Start(0.0, 0.0, 0.0)], FAR_AWAY, discs).obstacles(0)[0].discs for _ in range(2))
    assert (first == second).all()
    errors = (first[:, :2] - np.array(discs)[:, :2]).ravel()
    assert 0.07 < errors.std() < 0.13
    draws = np.array([normal(7, tick, 0, k) for tick in range(100) for k in range(20)])
    assert abs(draws.mean()) < 0.08
    assert 0.94 < draws.std() < 1.06
    assert len(np.unique(draws)) == len(draws)


def test_vehicles_are_seen_only_where_told() -> None:
    team = [Start(0.0, 0.0, 0.0), Start(3.0, 0.0, 0.0)]
    assert len(world(scenario(), team, Start(4.0, 1.0, 0.0), []).obstacles(0)[0].discs) == 0
    seen = world(scenario(sensing__sees_vehicles=True), team, Start(4.0, 1.0, 0.0), []).obstacles(0)[0].discs
    np.testing.assert_allclose(seen[:, :3], [[3.0, 0.0, 0.25], [4.0, 1.0, 0.25]])
