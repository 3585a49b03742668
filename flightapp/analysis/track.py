"""Where one vehicle was: samples in the mission frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.recording.phases import Window
from flightapp.recording.reader import Series


@dataclass(frozen=True, slots=True)
class Track:
    """Motion of one vehicle; times strictly increase. `source` is truth, own or estimate."""

    source: str
    t_s: Array  # (n,) fleet time
    position_ned_m: Array  # (n, 3)
    velocity_ned_m_s: Array  # (n, 3)

    def __len__(self) -> int:
        return len(self.t_s)

    def within(self, window: Window) -> Track:
        """The samples inside `window`, and the interpolated state at each of its ends that the track spans."""
        if len(self) == 0:
            return self
        ends = [end for end in window if self.t_s[0] <= end <= self.t_s[-1]]
        inside = self.t_s[(self.t_s >= window.start_s) & (self.t_s <= window.end_s)]
        return self.at(np.union1d(inside, ends))

    def at(self, t_s: Array) -> Track:
        """The track at other times (m,), by linear interpolation."""
        position = np.column_stack([np.interp(t_s, self.t_s, self.position_ned_m[:, axis]) for axis in range(3)])
        velocity = np.column_stack([np.interp(t_s, self.t_s, self.velocity_ned_m_s[:, axis]) for axis in range(3)])
        return Track(self.source, np.asarray(t_s, dtype=np.float64), position, velocity)


def track_of(series: Series, source: str) -> Track | None:
    """The track in the messages of one topic (OwnState, Target or TruthRecord); None with fewer than two samples.

    A message repeated with the same `t_s` is one sample; samples with a null are left out.
    """
    t_s = series.column("t_s")
    position = series.vectors("position_ned_m")
    velocity = series.vectors("velocity_ned_m_s")
    good = np.isfinite(t_s) & np.isfinite(position).all(axis=1) & np.isfinite(velocity).all(axis=1)
    times, first = np.unique(t_s[good], return_index=True)
    if len(times) < 2:
        return None
    return Track(source, times, position[good][first], velocity[good][first])
