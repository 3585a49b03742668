"""The evader's telemetry ends in the middle of a chase: cameras go on with it, or it is lost, as the mission says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from flightapp.config.profile import Profile
from flightapp.core.types import TargetTrack
from flightapp.recording.reader import read_recording
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
PURSUERS = ("p1", "p2")
SILENT_BELOW_M = 6.0
WATCHED_S = 3.2
IN_SIGHT_S = 1.3
"""Then the pursuers have the evader between them, beside their cameras' view."""


def _mission(folder: Path, *changes: tuple[str, str]) -> Path:
    """The demo with the evader half as far away, and further changes."""
    text = (ROOT / "missions/demo_two_pursuers.toml").read_text()
    for old, new in (("north_m = 55.0", "north_m = 22.0"), *changes):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "mission.toml"
    path.write_text(text)
    return path


def _small_camera(profile: Profile) -> Profile:
    """A quarter of the pixels at half the rate, for the sake of time."""
    camera = profile.camera
    half = {
        name: getattr(camera, name) / 2
        for name in ("focal_length_x_px", "focal_length_y_px", "principal_point_x_px", "principal_point_y_px")
    }
    size = {"width_px": camera.width_px // 2, "height_px": camera.height_px // 2, "rate_hz": camera.rate_hz / 2}
    return profile.model_copy(update={"camera": camera.model_copy(update={**half, **size})})


class _Chase:
    """Cuts the evader off when a pursuer is near, then watches what everybody believes."""

    def __init__(self, silent_below_m: float = SILENT_BELOW_M, watched_s: float = WATCHED_S) -> None:
        self._silent_below_m = silent_below_m
        self._watched_s = watched_s
        self.silent_s: float | None = None
        self.errors: dict[str, list[tuple[float, float, float]]] = {name: [] for name in PURSUERS}
        """(time since the silence, error in the plane, error over its standard deviation)"""

    def watch(self, fleet: VirtualFleet) -> None:
        now_s, evader = fleet.clock.now_s(), fleet.vehicles["e1"]
        away = [np.linalg.norm(fleet.vehicles[name].position_ned_m - evader.position_ned_m) for name in PURSUERS]
        pursues = all(fleet.vehicles[name].loop.phase == "pursue" for name in PURSUERS)
        if self.silent_s is None and pursues and min(away) < self._silent_below_m:
            self.silent_s = now_s
            fleet.network.cut_off.add("e1")
        if self.silent_s is None:
            return
        for name in PURSUERS:
            track = fleet.vehicles[name].loop.target
            if track is not None:
                self.errors[name].append((now_s - self.silent_s, *_error(track, evader.position_ned_m)))
        if now_s - self.silent_s > self._watched_s:
            fleet.stop()


def _error(track: TargetTrack, truth: np.ndarray) -> tuple[float, float]:
    offset = (track.position_ned_m - truth)[:2]
    return float(np.linalg.norm(offset)), float(np.sqrt(offset @ np.linalg.solve(track.covariance[:2, :2], offset)))


def _fly(
    folder: Path, mission: Path, chase: _Chase, rendered: bool, change: Callable[[Profile], Profile] | None = None
) -> VirtualFleet:
    folder.mkdir()
    fleet = fly_virtual(mission, SIM, folder, seed=1, watch=chase.watch, rendered=rendered, change_profile=change)
    assert chase.silent_s is not None
    return fleet


def test_whom_cameras_see_is_followed_after_its_telemetry_ended(tmp_path: Path) -> None:
    chase, run = _Chase(), tmp_path / "run"
    fleet = _fly(run, _mission(tmp_path), chase, rendered=True, change=_small_camera)
    for name in PURSUERS:
        errors = np.array(chase.errors[name])
        assert errors[errors[:, 0] < IN_SIGHT_S, 1].max() < 0.3
        assert (errors[:, 2] < 3.0).mean() > 0.95
        assert fleet.vehicles[name].loop.outcome == "captured"
        recorded = read_recording(run / f"{name}.mcap")
        sightings = recorded.topic("/sighting")
        assert chase.silent_s is not None
        after = sightings.column("measured_t_s") > chase.silent_s + 0.1
        assert not (after & (np.array(sightings.texts("source")) == "telemetry")).any()
        for vehicle in PURSUERS:  # The own camera's and the other's.
            by = (np.array(sightings.texts("vehicle")) == vehicle) & np.array(sightings.values("used"))
            assert (after & by).sum() >= 5
        assert "target_lost" not in " ".join(recorded.topic("/event").texts("text"))


def test_whom_nobody_sees_is_lost_within_the_time_of_the_failsafe(tmp_path: Path) -> None:
    chase, run = _Chase(silent_below_m=18.0, watched_s=2.5), tmp_path / "run"
    _fly(run, _mission(tmp_path), chase, rendered=False)
    for name in PURSUERS:
        events = read_recording(run / f"{name}.mcap").topic("/event")
        lost_s = [t_s for t_s, text in zip(events.column("t_s"), events.texts("text"), strict=True) if "target_lost" in text]
        assert lost_s
        assert chase.silent_s is not None
        assert 1.9 < lost_s[0] - chase.silent_s < 2.3  # News is old after 1 s, the failsafe acts after another.
