"""TOML file -> validated model, or one clear sentence: file, field, value, what would be right."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from flightapp.core.errors import InputError

Model = TypeVar("Model", bound=BaseModel)


class Strict(BaseModel):
    """Base of every configuration model: unknown keys are refused, values are frozen, infinities and NaN are not numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file; InputError names the file and what is wrong with it."""
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, a TOML file is wanted") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def validate(model: type[Model], tables: dict[str, Any], path: Path) -> Model:
    """`tables` as `model`; InputError lists every finding, one sentence each."""
    try:
        return model.model_validate(tables)
    except ValidationError as error:
        raise InputError("\n".join(_sentence(path, model, finding) for finding in error.errors())) from None


def load(model: type[Model], path: Path) -> Model:
    """Read and validate one file."""
    return validate(model, read_toml(path), path)


def _sentence(path: Path, model: type[BaseModel], finding: Any) -> str:
    location = _location(finding["loc"])
    value = finding["input"]
    shown = repr(value) if isinstance(value, (str, int, float, bool)) or value is None else None
    kind = finding["type"]
    if kind == "extra_forbidden":
        known = _known_keys(model, finding["loc"][:-1])
        near = difflib.get_close_matches(str(finding["loc"][-1]), known, n=1, cutoff=0.5)
        right = f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(sorted(known))}"
        return f"{path}: {location} = {shown or '...'}: unknown field; {right}"
    if kind == "missing":
        return f"{path}: {location}: missing; this field is required"
    message = str(finding["msg"]).removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    if not location:
        return f"{path}: {message}"
    return f"{path}: {location}{f' = {shown}' if shown is not None else ''}: {message}"


def _location(parts: tuple[int | str, ...]) -> str:
    text = ""
    for part in parts:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _known_keys(model: type[BaseModel], parts: tuple[int | str, ...]) -> list[str]:
    """Field names of the (nested) model at `parts`, found by walking annotations."""
    current: Any = model
    for part in parts:
        if isinstance(part, int):
            continue
        field = getattr(current, "model_fields", {}).get(part)
        if field is None:
            return []
        current = _model_in(field.annotation)
    return list(getattr(current, "model_fields", {}))


def _model_in(annotation: Any) -> Any:
    """The first model class inside an annotation such as `tuple[Vehicle, ...]` or `X | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        found = _model_in(argument)
        if found is not None:
            return found
    return None
