"""The bundle of one run: a zip file that appears under its name only when it is whole."""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import orjson

from flightapp.analysis.run import load_run
from flightapp.analysis.summary import summarise
from flightapp.bundle.contents import Entry, Kind, entries_of
from flightapp.bundle.flight_logs import copy_log
from flightapp.bundle.identity import own_names
from flightapp.bundle.recordings import copy_recording, texts_of
from flightapp.bundle.redaction import Redactor, home_names
from flightapp.bundle.versions import versions
from flightapp.core.clock import utc_stamp
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording

FORMAT_VERSION = 1
MANIFEST = "manifest.json"
_KEPT = (
    "Where it was flown, private network addresses, git commits and checksums are left in. Taken out: keys, certificates, "
    "passwords, tokens, names of users and hosts, home folders, serial numbers, hardware and mail addresses, network names, "
    "public addresses."
)


@dataclass(frozen=True, slots=True)
class Bundle:
    """What was written. `left_out`: (file, why)."""

    path: Path
    files: int
    size_bytes: int
    redacted: dict[str, int]
    left_out: tuple[tuple[str, str], ...]

    def as_json(self) -> dict[str, Any]:
        left_out = [{"file": name, "reason": reason} for name, reason in self.left_out]
        told = {"bundle": str(self.path), "files": self.files, "bytes": self.size_bytes}
        return told | {"redacted": self.redacted, "left_out": left_out}

    def text(self) -> str:
        lines = [f"left out: {name}: {reason}" for name, reason in self.left_out]
        taken = sum(self.redacted.values())
        lines.append(f"redacted: {taken} places. {_KEPT}")
        return "\n".join([*lines, f"bundle:   {self.path} ({self.files} files, {self.size_bytes / 1e6:.1f} MB)"])


@dataclass(slots=True)
class _Archive:
    """The zip file while it is written; `listed` goes into the manifest."""

    file: zipfile.ZipFile
    redactor: Redactor
    listed: list[dict[str, Any]] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)

    def add(self, name: str, content: bytes, **facts: object) -> None:
        self.file.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
        self._list(name, len(content), hashlib.sha256(content).hexdigest(), facts)

    def add_file(self, name: str, path: Path, **facts: object) -> None:
        digest = hashlib.sha256()
        # Recordings are compressed inside already.
        with path.open("rb") as source, self.file.open(zipfile.ZipInfo(name), "w", force_zip64=True) as target:
            while block := source.read(1 << 20):
                digest.update(block)
                target.write(block)
        self._list(name, path.stat().st_size, digest.hexdigest(), facts)

    def _list(self, name: str, size: int, digest: str, facts: dict[str, object]) -> None:
        self.listed.append({"file": name, "bytes": size, "sha256": digest, **facts})


def write_bundle(run: Path, output: Path | None = None, *, full: bool = False, names: Iterable[str] | None = None) -> Bundle:
    """Bundle one run's folder; default output RUN-bundle.zip beside it.

    full: whole recordings with images instead of two messages a second. names: what is secret beside the patterns; default what
    this machine and its user are called. InputError if there is nothing to bundle, or the output exists or cannot be written.
    """
    if not run.is_dir():
        raise InputError(f"{run}: no such run folder")
    target = output or run.resolve().with_name(f"{run.resolve().name}-bundle.zip")
    if target.exists():
        raise InputError(f"{target}: exists already; name a new file with --output")
    entries = [entry for entry in entries_of(run) if entry.path.resolve() != target.resolve()]
    if not any(entry.kind is not None for entry in entries):
        raise InputError(f"{run}: nothing in this folder belongs to a run")
    redactor = Redactor(own_names() if names is None else names)
    redactor = redactor.with_names(_learnt(entries))
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("xb") as stream:
            archive = _write(run, entries, redactor, stream, full=full)
            stream.flush()
            os.fsync(stream.fileno())
        os.link(temporary, target)
    except FileExistsError:
        raise InputError(f"{target}: exists already; name a new file with --output") from None
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror}; name another place with --output") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    return Bundle(target, len(archive.listed) + 1, target.stat().st_size, dict(redactor.counts), tuple(archive.left_out))


def _learnt(entries: list[Entry]) -> set[str]:
    """Names of people in the paths that the run's own files mention: on which machine it was flown is not known here."""
    names: set[str] = set()
    for entry in entries:
        if entry.kind is Kind.TEXT:
            names |= home_names(entry.path.read_text(errors="replace"))
        elif entry.kind is Kind.RECORDING:
            with contextlib.suppress(InputError):
                names |= {name for text in texts_of(entry.path) for name in home_names(text)}
    return names


def _write(run: Path, entries: list[Entry], redactor: Redactor, stream: Any, *, full: bool) -> _Archive:
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file, tempfile.TemporaryDirectory() as scratch:
        archive = _Archive(file, redactor)
        for number, entry in enumerate(entries):
            name = redactor.text(entry.path.relative_to(run).as_posix())
            if entry.kind is None:
                archive.left_out.append((name, entry.reason))
                continue
            try:
                _add(archive, entry, name, Path(scratch) / str(number), full=full)
            except InputError as error:
                archive.left_out.append((name, redactor.text(str(error))))
        archive.add("preflight.json", _json(_preflight(entries), redactor))
        if not (run / "summary.json").is_file():
            archive.add("summary.json", _json(_summary(run), redactor))
        archive.add("versions.json", orjson.dumps(versions(), option=orjson.OPT_INDENT_2))
        manifest = {
            "format_version": FORMAT_VERSION,
            "run": redactor.text(run.resolve().name),
            "written_utc": utc_stamp(),
            "recordings": "whole" if full else "two messages a second of each topic, all events, no images",
            "redaction": {"rules": _KEPT, "counts": dict(redactor.counts)},
            "files": archive.listed,
            "left_out": [{"file": name, "reason": reason} for name, reason in archive.left_out],
        }
        file.writestr(zipfile.ZipInfo(MANIFEST), orjson.dumps(manifest, option=orjson.OPT_INDENT_2), zipfile.ZIP_DEFLATED)
    return archive


def _add(archive: _Archive, entry: Entry, name: str, scratch: Path, *, full: bool) -> None:
    if entry.kind is Kind.TEXT:
        text = entry.path.read_bytes().decode(errors="replace")
        redacted = _redacted_text(entry.path, text, archive.redactor)
        archive.add(name, redacted.encode(), source_bytes=entry.path.stat().st_size)
        return
    if entry.kind is Kind.RECORDING:
        copied = copy_recording(entry.path, scratch, archive.redactor, full=full)
        facts: dict[str, object] = {
            "messages": copied.messages,
            "messages_left_out": copied.thinned,
            "messages_withheld": copied.withheld,
            "was_complete": copied.was_complete,
        }
    else:
        facts = {"samples": copy_log(entry.path, scratch, archive.redactor, full=full)}
    archive.add_file(name, scratch, source_bytes=entry.path.stat().st_size, **facts)
    scratch.unlink()


def _preflight(entries: list[Entry]) -> dict[str, list[dict[str, Any]]]:
    """What the checklists said, by vehicle."""
    found: dict[str, list[dict[str, Any]]] = {}
    for entry in entries:
        if entry.kind is Kind.RECORDING:
            with contextlib.suppress(InputError):
                recording = read_recording(entry.path)
                events = [message for message in recording.topic("/event").messages if message.get("name") == "preflight"]
                found.setdefault(recording.vehicle, []).extend(dict(event) for event in events)
    return {vehicle: events for vehicle, events in found.items() if events}


def _summary(run: Path) -> dict[str, Any]:
    """Of a run that was cut off before it had one."""
    try:
        return summarise(load_run([run]))
    except InputError as error:
        return {"error": str(error)}


def _redacted_text(path: Path, text: str, redactor: Redactor) -> str:
    """JSON by its fields, line by line where it comes so; everything else as text."""
    if path.suffix == ".jsonl":
        return "".join(_json_line(line, redactor) for line in text.splitlines(keepends=True))
    if path.suffix == ".json":
        with contextlib.suppress(orjson.JSONDecodeError):
            return _json(orjson.loads(text), redactor).decode()
    return redactor.text(text)


def _json_line(line: str, redactor: Redactor) -> str:
    try:
        return orjson.dumps(redactor.value(orjson.loads(line))).decode() + "\n"
    except orjson.JSONDecodeError:
        return redactor.text(line)


def _json(content: object, redactor: Redactor) -> bytes:
    plain = orjson.loads(orjson.dumps(content, option=orjson.OPT_SERIALIZE_NUMPY))
    return orjson.dumps(redactor.value(plain), option=orjson.OPT_INDENT_2)
