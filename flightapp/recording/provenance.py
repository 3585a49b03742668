"""Which software made a recording: versions of what it stands on, and the commit where it runs from a checkout."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import flightapp

PACKAGES = ("mavsdk", "eclipse-zenoh", "foxglove-sdk", "mcap", "numpy", "numba", "opencv-python-headless", "pyrealsense2")
_TIMEOUT_S = 5.0


def versions() -> dict[str, str]:
    """For the metadata `versions`; what is not installed is left out."""
    found = {"flightapp": flightapp.__version__, "python": platform.python_version(), "system": platform.platform()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    commit = git_commit(Path(flightapp.__file__).parent)
    return found if commit is None else {**found, "git_commit": commit}


def git_commit(folder: Path) -> str | None:
    """The commit that is checked out around `folder`, with `+changes` where files differ from it; None outside a checkout."""
    commit = _git(folder, "rev-parse", "HEAD")
    if not commit:
        return None
    changes = _git(folder, "status", "--porcelain", "--untracked-files=no", "--", str(folder))
    return f"{commit}+changes" if changes else commit


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "--no-optional-locks", "-C", str(folder), *arguments],
            capture_output=True,
            text=True,
            timeout=_TIMEOUT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
