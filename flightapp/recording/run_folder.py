"""Where one run's recordings go."""

from __future__ import annotations

from pathlib import Path

from flightapp.core.clock import utc_stamp
from flightapp.core.errors import InputError


def create_run_folder(root: Path, mission_name: str) -> Path:
    """Create `root`/<UTC time>-<mission>, with a number behind it where that exists already."""
    stem = f"{utc_stamp()}-{mission_name}"
    number = 1
    while True:
        folder = root / (stem if number == 1 else f"{stem}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            number += 1
        except OSError as error:
            raise InputError(f"{folder}: the run folder cannot be created: {error.strerror}; check recording.folder") from None
        else:
            return folder


def given_run_folder(folder: Path, *, shared: bool = False) -> Path:
    """The folder that a person named, created if need be; InputError if it cannot be used.

    shared: other vehicles of this machine may record into it too; otherwise it must be empty.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise InputError(f"--run {folder}: not a folder that can be used: {error.strerror}; name a new folder") from None
    if occupied and not shared:
        raise InputError(f"--run {folder}: is not empty; name a new folder")
    return folder
