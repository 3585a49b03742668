"""Certificates of a simulated fleet: those that somebody made, or some that last as long as the run."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from flightapp.config.mission import Mission
from flightapp.core.clock import SystemClock
from flightapp.fleet.security.access import OPERATOR
from flightapp.fleet.security.credentials import load_credentials
from flightapp.fleet.security.keys import KeyWish, make_keys
from flightapp.sim.fleet_files import HOST

TEMPORARY_DAYS = 1.0


@contextmanager
def fleet_keys(mission: Mission, given: Path | None, *, temporary: bool) -> Iterator[Path | None]:
    """The folder of keys for the run: `given` where it fits the mission (InputError otherwise), else temporary ones, else None.

    Temporary keys lie outside the run folder, which people send to each other, and are gone afterwards.
    """
    names = tuple(vehicle.name for vehicle in mission.vehicles)
    if given is not None:
        for name in (*names, OPERATOR):
            load_credentials(given / name)
        yield given
    elif temporary:
        with temporary_keys(mission, dict.fromkeys(names, (HOST,))) as keys:
            yield keys
    else:
        yield None


@contextmanager
def temporary_keys(mission: Mission, hosts: Mapping[str, tuple[str, ...]]) -> Iterator[Path]:
    """A folder of keys for `mission` that is gone afterwards. hosts: the addresses at which each vehicle listens."""
    names = tuple(vehicle.name for vehicle in mission.vehicles)
    with tempfile.TemporaryDirectory(prefix="flightapp-keys-") as folder:
        keys = Path(folder) / "keys"
        make_keys(KeyWish(keys, mission.fleet, names, hosts, TEMPORARY_DAYS), SystemClock().now_s())
        yield keys
