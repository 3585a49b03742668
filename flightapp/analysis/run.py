"""One run: the recordings of a mission with the mission and the profiles that it was flown with."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flightapp.analysis.time_base import Source, shifts_of
from flightapp.analysis.track import Track, track_of
from flightapp.config.loading import Model, validate
from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import InputError
from flightapp.recording.phases import Phases, Window, phases_of
from flightapp.recording.reader import Recording, Series, read_recording
from flightapp.recording.small_log import SUFFIX

TRUTH_STEM = "truth"
MISSION_FILE = "mission.toml"
PROFILE_FILE = "profile.toml"


@dataclass(frozen=True, slots=True)
class VehicleRun:
    """One vehicle's part. `role` is None where no mission tells it; `profile` where none was kept."""

    name: str
    role: str | None
    recording: Recording
    phases: Phases
    profile: Profile | None
    own: Track | None
    truth: Track | None
    flown: Window | None
    """When it was truly off the ground; None where no true states are known."""
    shift_s: float = 0.0
    """What was added to the times of its recording to bring it onto the run's time base."""
    shift_source: Source = "not measured"

    @property
    def track(self) -> Track | None:
        """True states where they are known, else the vehicle's own."""
        return self.truth or self.own


@dataclass(frozen=True, slots=True)
class Run:
    """Everything known of one run. `unreadable`: (file, why) of recordings that could not be read."""

    folder: Path
    prefix: str
    """Put before the names of written files: empty for a whole folder."""
    mission: Mission | None
    vehicles: tuple[VehicleRun, ...]
    recordings: tuple[Recording, ...]
    truth: dict[str, Track]
    unreadable: tuple[tuple[Path, str], ...]

    def with_role(self, role: str) -> tuple[VehicleRun, ...]:
        return tuple(vehicle for vehicle in self.vehicles if vehicle.role == role)

    def output(self, name: str) -> Path:
        """Where the result called `name` belongs."""
        return self.folder / f"{self.prefix}{name}"

    def evader_track(self) -> Track | None:
        """The evader: true, else as it knew itself, else as the pursuer with the longest estimate believed."""
        if self.mission is not None:
            for vehicle in self.mission.vehicles:
                if vehicle.role == "evader" and vehicle.name in self.truth:
                    return self.truth[vehicle.name]
        for evader in self.with_role("evader"):
            if evader.track is not None:
                return evader.track
        estimates = [track_of(vehicle.recording.topic("/target"), "estimate") for vehicle in self.vehicles]
        known = [estimate for estimate in estimates if estimate is not None]
        return max(known, key=len, default=None)


def load_run(paths: Sequence[Path]) -> Run:
    """The run in folders, single `.mcap` files, or both: one folder a vehicle, say, as they come from several computers.

    All recordings are brought onto one time base (see `time_base`). InputError if there is nothing to read.
    """
    if not paths:
        raise InputError("name a run folder or recordings (.mcap)")
    files = [file for path in paths for file in (_files_in(path) if path.is_dir() else [path])]
    recordings: list[Recording] = []
    unreadable: list[tuple[Path, str]] = []
    for file in dict.fromkeys(files):
        try:
            recordings.append(read_recording(file))
        except InputError as error:
            if file in paths:
                raise
            unreadable.append((file, str(error)))
    if not recordings:
        raise InputError(unreadable[0][1])
    used, others = _one_a_vehicle(recordings)
    if paths[0].is_dir():
        return _assemble(paths[0], "", used, (*unreadable, *others))
    return _assemble(paths[0].parent, f"{paths[0].stem}-", used, (*unreadable, *others))


def _files_in(folder: Path) -> list[Path]:
    every = sorted(folder.glob("*.mcap"))
    whole = {file.name for file in every if not file.name.endswith(SUFFIX)}
    files = [file for file in every if not file.name.endswith(SUFFIX) or file.name.replace(SUFFIX, ".mcap") not in whole]
    if not files:
        raise InputError(f"{folder}: no recording (.mcap) in this folder")
    return files


def _one_a_vehicle(recordings: list[Recording]) -> tuple[list[Recording], list[tuple[Path, str]]]:
    """Of several recordings of one vehicle the one with most in it: others are copies, thinned out, or a start given up."""
    best: dict[str, Recording] = {}
    for recording in recordings:
        known = best.get(recording.vehicle)
        if known is None or _size(recording) > _size(known):
            best[recording.vehicle] = recording
    used = [recording for recording in recordings if best[recording.vehicle] is recording]
    others = [
        (recording.path, f"not used: {best[recording.vehicle].path.name} has more of '{recording.vehicle}'")
        for recording in recordings
        if best[recording.vehicle] is not recording
    ]
    return used, others


def _size(recording: Recording) -> int:
    return sum(len(series) for series in recording.series.values())


def _assemble(folder: Path, prefix: str, recordings: list[Recording], unreadable: tuple[tuple[Path, str], ...]) -> Run:
    mission = _mission(folder, recordings)
    shifts = shifts_of([recording for recording in recordings if recording.path.stem != TRUTH_STEM])
    recordings = [
        recording.shifted(shifts[recording.vehicle].shift_s) if recording.path.stem != TRUTH_STEM else recording
        for recording in recordings
    ]
    truth: dict[str, Track] = {}
    flown: dict[str, Window] = {}
    for recording in recordings:
        for name, series in _true_states(recording.topic("/truth")).items():
            track = track_of(series, "truth")
            if track is not None:
                truth[name] = track
                flown[name] = _flown(series)
    roles = {} if mission is None else {vehicle.name: vehicle.role for vehicle in mission.vehicles}
    vehicles = tuple(
        VehicleRun(
            name=recording.vehicle,
            role=roles.get(recording.vehicle) or recording.metadata.get("run", {}).get("role"),
            recording=recording,
            phases=phases_of(recording),
            profile=_profile(folder, recording),
            own=track_of(recording.topic("/own"), "own"),
            truth=truth.get(recording.vehicle),
            flown=flown.get(recording.vehicle),
            shift_s=shifts[recording.vehicle].shift_s,
            shift_source=shifts[recording.vehicle].source,
        )
        for recording in recordings
        if recording.path.stem != TRUTH_STEM
    )
    return Run(folder, prefix, mission, vehicles, tuple(recordings), truth, unreadable)


def _true_states(series: Series) -> dict[str, Series]:
    """The messages of `/truth` by vehicle."""
    names = series.texts("vehicle")
    states: dict[str, Series] = {}
    for name in sorted(set(names)):
        states[name] = series.chosen(np.array([name == other for other in names], dtype=bool))
    return states


def _flown(series: Series) -> Window:
    """From the first to the last true state off the ground; of no length if there was none."""
    times = series.column("t_s")[series.column("on_ground") == 0.0]
    return Window(float(times.min()), float(times.max())) if len(times) else Window(0.0, 0.0)


def _mission(folder: Path, recordings: list[Recording]) -> Mission | None:
    """The mission kept in the folder, else the one inside a recording."""
    path = folder / MISSION_FILE
    if path.is_file():
        return load_mission(path)
    for recording in recordings:
        if MISSION_FILE in recording.attachments:
            return _attached(Mission, recording, MISSION_FILE)
    return None


def _profile(folder: Path, recording: Recording) -> Profile | None:
    """The profile inside the recording, else the one in the folder named for the vehicle, else the folder's only one."""
    if PROFILE_FILE in recording.attachments:
        return _attached(Profile, recording, PROFILE_FILE)
    files = [path for path in sorted(folder.glob("*.toml")) if path.name != MISSION_FILE and "profile" in path.stem]
    own = [path for path in files if recording.vehicle in path.stem.replace("_", "-").split("-")]
    chosen = own[0] if own else files[0] if len(files) == 1 else None
    return None if chosen is None else load_profile(chosen)


def _attached(model: type[Model], recording: Recording, name: str) -> Model:
    where = Path(f"{recording.path}:{name}")
    try:
        tables = tomllib.loads(recording.attachments[name].decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{where}: not valid TOML: {error}") from None
    return validate(model, tables, where)
