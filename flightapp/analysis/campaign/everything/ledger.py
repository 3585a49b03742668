"""The ledger of a long campaign: a JSON line an episode, on the disk as soon as it is flown. A cut run goes on where it was."""

from __future__ import annotations

import fcntl
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from flightapp.analysis.campaign.everything.episode_row import Row
from flightapp.core.errors import InputError

NAME = "episodes.jsonl"
Key = tuple[str, str, int]


def key_of(row: Row) -> Key:
    """What a row is about: scenario, planner, seed."""
    return row["scenario"], row["planner"], row["seed"]


def read_rows(path: Path) -> list[Row]:
    """The rows of the ledger at `path`, none where there is none. A last line that was cut is left out; InputError on others."""
    if not path.exists():
        return []
    lines = path.read_bytes().split(b"\n")
    rows = []
    for number, line in enumerate(lines[:-1], 1):
        try:
            row = json.loads(line)
            key_of(row)
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{path}: line {number} is no episode; delete the line, and it is flown again") from None
        rows.append(row)
    return rows


class Ledger:
    """The open ledger of the one process that flies."""

    def __init__(self, path: Path, file: IO[bytes], rows: list[Row]) -> None:
        self._path, self._file = path, file
        self.rows = rows

    def add(self, rows: Iterable[Row]) -> None:
        """Behind the others, on the disk before this returns."""
        new = list(rows)
        self._file.write(b"".join(json.dumps(row, separators=(",", ":"), allow_nan=False).encode() + b"\n" for row in new))
        self._file.flush()
        self.rows += new

    def drop(self, unwanted: Callable[[Row], bool]) -> int:
        """Take out the rows that are `unwanted`: how many."""
        kept = [row for row in self.rows if not unwanted(row)]
        dropped = len(self.rows) - len(kept)
        if dropped:
            self._file.seek(0)
            self._file.truncate()
            self.rows = []
            self.add(kept)
        return dropped


@contextmanager
def opened(folder: Path) -> Iterator[Ledger]:
    """The ledger in `folder`, which is made; InputError while another process flies it."""
    path = folder / NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = path.open("r+b" if path.exists() else "w+b")
    except OSError as error:
        raise InputError(f"--output {folder}: not a folder that can be used: {error.strerror}; name another") from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{path}: another process flies this campaign; look at it with --show") from None
        rows = read_rows(path)
        whole = file.read().rfind(b"\n") + 1
        file.truncate(whole)
        file.seek(whole)
        yield Ledger(path, file, rows)
