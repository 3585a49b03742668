"""Which software made a recording."""

from __future__ import annotations

import subprocess
from pathlib import Path

import flightapp
from flightapp.recording.provenance import git_commit, versions


def git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), "-c", "user.name=n", "-c", "user.email=e@example.org", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_the_commit_and_whether_files_differ_from_it(tmp_path: Path) -> None:
    git(tmp_path, "init", "-q")
    file = tmp_path / "code.py"
    file.write_text("a = 1\n")
    git(tmp_path, "add", "code.py")
    git(tmp_path, "commit", "-q", "-m", "first")
    commit = git(tmp_path, "rev-parse", "HEAD")
    assert git_commit(tmp_path) == commit
    file.write_text("a = 2\n")
    assert git_commit(tmp_path) == f"{commit}+changes"


def test_no_commit_outside_a_checkout(tmp_path: Path) -> None:
    assert git_commit(tmp_path) is None


def test_versions_of_what_it_stands_on() -> None:
    found = versions()
    assert found["flightapp"] == flightapp.__version__
    assert {"python", "system", "mavsdk", "eclipse-zenoh", "foxglove-sdk", "numpy"} <= set(found)
