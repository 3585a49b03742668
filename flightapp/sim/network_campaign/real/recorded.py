"""What the recordings of a real flight say about its network: how old states were, who heard whom, and who led."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.recording.reader import Recording, read_recording
from flightapp.sim.virtual.figures import PURSUIT


@dataclass(frozen=True, slots=True)
class Network:
    """ages_s: of every teammate's newest state, each time that a vehicle wrote them down in its pursuit."""

    ages_s: tuple[float, ...]
    deaf: tuple[str, ...]
    """A sentence for each vehicle that never heard one of the others."""
    leaders: dict[int, frozenset[str]]
    """By term, whoever led it in anybody's eyes."""

    @property
    def violations(self) -> Iterator[str]:
        yield from (f"deaf: {sentence}" for sentence in self.deaf)
        for term, names in sorted(self.leaders.items()):
            if len(names) > 1:
                yield f"two leaders: {' and '.join(sorted(names))} both led in term {term}"


def read_network(run: Path, vehicles: Sequence[str]) -> Network:
    """From the recordings of all `vehicles` in the folder `run`."""
    ages_s: list[float] = []
    deaf: list[str] = []
    leaders: defaultdict[int, set[str]] = defaultdict(set)
    for name in vehicles:
        recording = read_recording(run / f"{name}.mcap")
        ages_s += [one["age_s"] for message in _in_pursuit(recording) for one in message["members"] if one["phase"] != "done"]
        heard = {one["name"] for message in recording.topic("/team").messages for one in message["members"]}
        deaf += [f"{name} never heard {other}" for other in vehicles if other != name and other not in heard]
        for event in recording.topic("/event").messages:
            if event["name"] == "leader" and event["data"].get("leader"):
                leaders[event["data"]["term"]].add(event["data"]["leader"])
    return Network(tuple(ages_s), tuple(deaf), {term: frozenset(names) for term, names in leaders.items()})


def _in_pursuit(recording: Recording) -> Iterator[dict[str, Any]]:
    """The vehicle's messages about its teammates."""
    phases = [(message["t_s"], message["phase"]) for message in recording.topic("/phase").messages]
    began_s = next((t_s for t_s, phase in phases if phase == PURSUIT), math.inf)
    ended_s = next((t_s for t_s, phase in phases if phase != PURSUIT and t_s > began_s), math.inf)
    yield from (message for message in recording.topic("/team").messages if began_s <= message["t_s"] <= ended_s)
