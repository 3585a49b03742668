"""Configuration files that are attached to a recording."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from flightapp.config.loading import Model, validate
from flightapp.core.errors import InputError
from flightapp.recording.reader import Recording


def attached_tables(recording: Recording, name: str) -> dict[str, Any]:
    """The tables of an attached TOML file; InputError where there is none of that name, or it is none."""
    if name not in recording.attachments:
        raise InputError(f"{recording.path}: {name} is not attached to this recording")
    try:
        return tomllib.loads(recording.attachments[name].decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{_where(recording, name)}: not valid TOML: {error}") from None


def attached(model: type[Model], recording: Recording, name: str) -> Model:
    """An attached TOML file as `model`; InputError where it is missing or does not hold."""
    return validate(model, attached_tables(recording, name), _where(recording, name))


def _where(recording: Recording, name: str) -> Path:
    return Path(f"{recording.path}:{name}")
