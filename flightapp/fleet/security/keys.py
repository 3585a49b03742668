"""`flightapp keys`: the authority and one folder of credentials for each vehicle and operator of a field day.

FOLDER/authority    ca.pem, ca.key: stays with whoever makes keys; without ca.key nobody can join who has not joined yet
FOLDER/NAME         ca.pem, certificate.pem, private.key: the whole folder goes to that machine, and only there

Nothing is overwritten: a second run adds who is not there yet, under the same authority.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from flightapp.core.errors import InputError
from flightapp.fleet.security.access import OPERATOR
from flightapp.fleet.security.authority import Issued, issue, new_authority
from flightapp.fleet.security.credentials import (
    AUTHORITY,
    CERTIFICATE,
    KEY,
    load_credentials,
    read_certificate,
    read_key,
)

AUTHORITY_FOLDER = "authority"
AUTHORITY_KEY = "ca.key"
_HOST = re.compile(r"[A-Za-z0-9:._-]{1,253}")


@dataclass(frozen=True, slots=True)
class KeyWish:
    """Who shall have certificates. `hosts`: of each vehicle, the addresses under which others connect to it."""

    folder: Path
    fleet: str
    vehicles: tuple[str, ...]
    hosts: Mapping[str, tuple[str, ...]]
    days: float
    operators: tuple[str, ...] = (OPERATOR,)


@dataclass(frozen=True, slots=True)
class Handed:
    """One folder of credentials after the run; `is_new` False: it was there and is as it was."""

    name: str
    folder: Path
    hosts: tuple[str, ...]
    ends_s: float
    is_new: bool


def parse_hosts(texts: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """NAME=HOST, several for one name add up; InputError for anything else."""
    hosts: dict[str, tuple[str, ...]] = {}
    for text in texts:
        name, separator, host = text.partition("=")
        if not (name and separator and _HOST.fullmatch(host)):
            raise InputError(f"--address {text}: write NAME=HOST, as p1=10.0.0.1")
        hosts[name] = (*hosts.get(name, ()), host)
    return hosts


def make_keys(wish: KeyWish, now_s: float) -> list[Handed]:
    """Make what is missing; InputError, and then nothing is made, where the wish cannot be."""
    _check(wish)
    authority = _authority(wish, now_s)
    return [_hand_out(authority, wish, name, now_s) for name in (*wish.vehicles, *wish.operators)]


def _check(wish: KeyWish) -> None:
    for name in (*wish.vehicles, *wish.operators):
        if not re.fullmatch(r"[a-z0-9][a-z0-9_-]{0,31}", name) or name == AUTHORITY_FOLDER:
            raise InputError(f"'{name}': no name for a certificate; use up to 32 of a-z, 0-9, _, -, and not '{AUTHORITY_FOLDER}'")
    both = set(wish.vehicles) & set(wish.operators)
    if both:
        raise InputError(f"'{min(both)}': is a vehicle and an operator; a vehicle must not have an operator's rights")
    unknown = set(wish.hosts) - set(wish.vehicles)
    if unknown:
        raise InputError(f"--address {min(unknown)}=...: no such vehicle; known: {', '.join(wish.vehicles)}")
    members = [name for name in (*wish.vehicles, *wish.operators) if (wish.folder / name).exists()]
    if members and not (wish.folder / AUTHORITY_FOLDER).exists():
        raise InputError(f"{wish.folder / AUTHORITY_FOLDER}: missing, '{members[0]}' has keys of it; make keys in a new folder")
    for name in wish.vehicles:
        if name not in wish.hosts and not (wish.folder / name).exists():
            raise InputError(f"--address: missing for '{name}'; write --address {name}=HOST as in the others' connect_endpoints")


def _authority(wish: KeyWish, now_s: float) -> Issued:
    """The one that is there, else a new one."""
    folder = wish.folder / AUTHORITY_FOLDER
    if not folder.exists():
        made = new_authority(wish.fleet, now_s, wish.days)
        _write_folder(folder, {AUTHORITY: made.certificate_pem(), AUTHORITY_KEY: made.key_pem()})
        return made
    authority = Issued(read_certificate(folder / AUTHORITY), read_key(folder / AUTHORITY_KEY))
    if authority.certificate.public_key() != authority.key.public_key():
        raise InputError(f"{folder / AUTHORITY_KEY}: is not the key of {AUTHORITY} beside it")
    end_s = authority.certificate.not_valid_after_utc.timestamp()
    if end_s <= now_s:
        raise InputError(f"{folder / AUTHORITY}: has expired; make keys for the new day in a new folder")
    return authority


def _hand_out(authority: Issued, wish: KeyWish, name: str, now_s: float) -> Handed:
    folder = wish.folder / name
    is_new = not folder.exists()
    if is_new:
        issued = issue(authority, name, wish.hosts.get(name, ()), now_s, wish.days)
        _write_folder(
            folder, {AUTHORITY: authority.certificate_pem(), CERTIFICATE: issued.certificate_pem(), KEY: issued.key_pem()}
        )
    found = load_credentials(folder)
    if read_certificate(folder / AUTHORITY) != authority.certificate:
        raise InputError(f"{folder / AUTHORITY}: is another authority's than the one in {wish.folder / AUTHORITY_FOLDER}")
    if found.name != name:
        raise InputError(f"{folder / CERTIFICATE}: is the certificate of '{found.name}', not of '{name}'")
    return Handed(name, folder, found.hosts, found.ends_s, is_new)


def _write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """All of them or none; private keys are readable by their owner alone from the first moment."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        half = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        try:
            for name, content in files.items():
                with os.fdopen(os.open(half / name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _mode(name)), "wb") as file:
                    file.write(content)
            half.rename(folder)
        except BaseException:
            shutil.rmtree(half, ignore_errors=True)
            raise
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from None


def _mode(name: str) -> int:
    return 0o600 if name.endswith(".key") else 0o644
