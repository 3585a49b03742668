"""Which files of a run go into the bundle, and as what."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

TEXT_SIZE_MAX = 64_000_000
_TEXT = frozenset({".toml", ".json", ".jsonl", ".log", ".txt", ".csv", ".params", ".kml", ".yaml", ".yml", ".md"})
_SECRET = frozenset({".pem", ".key", ".crt", ".cer", ".csr", ".p12", ".pfx", ".der", ".srl", ".kdbx", ".env"})
_AGAIN = frozenset({".html", ".png", ".parquet", ".zip"})


class Kind(Enum):
    """How a file is copied."""

    TEXT = "text"
    RECORDING = "recording"
    FLIGHT_LOG = "flight log"


@dataclass(frozen=True, slots=True)
class Entry:
    """One file of the run: to be copied as `kind`, or left out for a reason."""

    path: Path
    kind: Kind | None
    reason: str = ""


def entries_of(run: Path) -> Iterator[Entry]:
    """Every file below the run's folder, in order of names. Only kinds that can be checked for secrets are taken."""
    for path in sorted(run.rglob("*")):
        if path.is_symlink():
            yield Entry(path, None, "a link to elsewhere")
        elif path.is_file():
            yield _entry(path)


def _entry(path: Path) -> Entry:
    suffix = path.suffix.lower()
    if suffix in _SECRET or path.name.startswith((".env", "id_rsa", "id_ed25519")):
        return Entry(path, None, "a key or certificate")
    if suffix == ".mcap":
        return Entry(path, Kind.RECORDING)
    if suffix == ".ulg":
        return Entry(path, Kind.FLIGHT_LOG)
    if suffix in _AGAIN:
        return Entry(path, None, "made anew by flightapp report" if suffix != ".zip" else "an archive")
    if suffix not in _TEXT:
        return Entry(path, None, "a kind of file that cannot be checked for secrets")
    if path.stat().st_size > TEXT_SIZE_MAX:
        return Entry(path, None, f"larger than {TEXT_SIZE_MAX // 1_000_000} MB")
    return Entry(path, Kind.TEXT)
