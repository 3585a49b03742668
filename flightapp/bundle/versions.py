"""What ran: versions of everything, and on what kind of machine."""

from __future__ import annotations

import platform
import subprocess
from importlib import metadata
from pathlib import Path

from flightapp.bench.machine import machine

_SOURCE = Path(__file__).resolve().parents[2]
GIT_TIMEOUT_S = 5.0


def versions() -> dict[str, object]:
    """Python, packages, operating system, processor, and the commit of the source tree, null where it is none."""
    packages = {str(one.metadata["Name"]): one.version for one in metadata.distributions() if one.metadata["Name"]}
    return {
        "flightapp": packages.get("flightapp"),
        "git_commit": _git("rev-parse", "HEAD"),
        "git_changed_files": _changed(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "distribution": _distribution(),
        "machine": {key: value for key, value in machine().items() if key in ("cpu", "cores")},
        "packages": dict(sorted(packages.items(), key=lambda one: one[0].lower())),
    }


def _distribution() -> str | None:
    try:
        return platform.freedesktop_os_release().get("PRETTY_NAME")
    except OSError:
        return None


def _changed() -> int | None:
    listed = _git("status", "--porcelain", "--untracked-files=no")
    return None if listed is None else len(listed.splitlines())


def _git(*arguments: str) -> str | None:
    if not (_SOURCE / ".git").exists():
        return None
    try:
        done = subprocess.run(
            ["git", "-C", str(_SOURCE), *arguments], capture_output=True, text=True, timeout=GIT_TIMEOUT_S, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
