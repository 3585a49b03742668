"""The version of what a recording holds, kept in its metadata.

The minor number grows where something is added that older programs may pass over; the major one where they would misread it.
Recordings without a version are 1.0.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from flightapp.core.errors import InputError

METADATA = "format"
MAJOR, MINOR = 1, 0
CURRENT = {"version": f"{MAJOR}.{MINOR}"}
"""What a recording of this program says of itself."""

_VERSION = re.compile(r"(\d{1,6})\.(\d{1,6})", re.ASCII)


def check_format(path: Path, told: Mapping[str, str]) -> str:
    """One sentence if the file is of a newer minor version, empty if not; InputError if its major version is another one."""
    version = told.get("version", "")
    numbers = _VERSION.fullmatch(version)
    if numbers is None:
        return f"says no version of its format that this program understands ({version[:20]!r})"
    major, minor = int(numbers[1]), int(numbers[2])
    if major != MAJOR:
        raise InputError(
            f"{path}: a recording of format {version}; this program reads format {MAJOR}.x; "
            f"use the flightapp that recorded it, or {'a newer' if major > MAJOR else 'an older'} one"
        )
    if minor > MINOR:
        return f"is of format {version}, newer than this program's {MAJOR}.{MINOR}: what is new in it is not shown"
    return ""
