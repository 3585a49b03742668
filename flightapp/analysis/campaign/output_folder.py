"""Where a campaign's files go. A folder that a person named is never written over."""

from __future__ import annotations

from pathlib import Path

from flightapp.core.clock import utc_stamp
from flightapp.core.errors import InputError

ROOT = Path("campaigns")


def output_folder(given: Path | None, scenario_name: str, option: str = "--output") -> Path:
    """The folder `given`, which must be empty or new, else `campaigns`/TIME-SCENARIO; InputError, which begins with `option`,
    if it cannot be used.
    """
    folder = given or _free(ROOT / f"{utc_stamp()}-{scenario_name}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise InputError(f"{option} {folder}: not a folder that can be used: {error.strerror}; name a new folder") from None
    if occupied:
        raise InputError(f"{option} {folder}: is not empty; name a new folder")
    return folder


def _free(folder: Path) -> Path:
    """`folder`, with a number behind it where that exists already."""
    number, free = 2, folder
    while free.exists():
        free = folder.with_name(f"{folder.name}-{number}")
        number += 1
    return free
