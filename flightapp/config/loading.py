"""TOML file -> validated model, or one clear sentence: file, field, value, what would be right."""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from flightapp.core.errors import InputError

Model = TypeVar("Model", bound=BaseModel)

SHOWN_MAX = 80


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
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def validate(model: type[Model], tables: dict[str, Any], path: Path) -> Model:
    """`tables` as `model`; InputError lists every finding, one sentence each.

    Types are taken at their word, as in JSON: '5' is not a number, 1 is not true, 1.5 is not a whole number.
    """
    try:
        return model.model_validate_json(json.dumps(tables, default=str), strict=True)
    except ValidationError as error:
        findings = error.errors()
        sentences = [_sentence(path, model, finding) for finding in findings if not _follows_from_another(finding, findings)]
        raise InputError("\n".join(dict.fromkeys(sentences))) from None


def load(model: type[Model], path: Path) -> Model:
    """Read and validate one file."""
    return validate(model, read_toml(path), path)


def _sentence(path: Path, model: type[BaseModel], finding: Any) -> str:
    kind, place = finding["type"], _untagged(finding["loc"])
    parts = _own_parts(place)
    location = _location(parts)
    shown = _shown(finding["input"])
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        field = str(finding["ctx"]["discriminator"]).strip("'")
        if kind == "union_tag_not_found":
            return f"{path}: {location}.{field}: missing; this field is required"
        return f"{path}: {location}.{field} = {finding['ctx']['tag']!r}: must be one of {finding['ctx']['expected_tags']}"
    if kind == "extra_forbidden":
        known = _known_keys(model, finding["loc"][:-1])
        return f"{path}: {location} = {shown}: unknown field; {known_instead(str(parts[-1]), known)}"
    if kind == "missing":
        return f"{path}: {location}: missing; this field is required"
    if kind == "value_error":
        message = str(finding["ctx"]["error"])
        if _NAMES_A_FIELD.match(message):
            return f"{path}: {f'{location}.' if location else ''}{message}"
    elif parts != place:
        message = "must be a number, true or false, a text, a list of numbers, or a table of numbers and texts"
        return f"{path}: {location}: {message}"
    else:
        message = wanted_instead(finding)
    return f"{path}: {location} = {shown}: {message}" if location else f"{path}: {message}"


_NAMES_A_FIELD = re.compile(r"[a-z_0-9]+(\[\d+\])?(\.[\w-]+(\[\d+\])?)*( =|:) ")

_WORDS = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be a text in quotes",
    "path_type": "must be a path in quotes",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "dict_type": "must be a table",
    "tuple_type": "must be a list",
    "list_type": "must be a list",
    "finite_number": "must be a finite number",
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be at most {le}",
    "literal_error": "must be {expected}",
    "string_pattern_mismatch": "must match the pattern {pattern}",
    "string_too_short": "must not be empty",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
}


def known_instead(name: str, known: Sequence[str]) -> str:
    """What may have been meant by `name`: the nearest of the `known` names, or all of them."""
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(sorted(known))}"


def wanted_instead(finding: Any) -> str:
    """What would be right in place of the value of a validator's `finding`."""
    kind = finding["type"]
    if kind == "value_error":
        return str(finding["ctx"]["error"])
    if kind == "too_short" and finding["ctx"]["min_length"] == 1:
        return "must not be empty"
    if kind in _WORDS:
        return _WORDS[kind].format(**finding.get("ctx", {}))
    message = str(finding["msg"])
    return message[0].lower() + message[1:]


def _follows_from_another(finding: Any, findings: Sequence[Any]) -> bool:
    """A list counts as too short when one of its entries is refused: only the entry is worth a sentence."""
    here = finding["loc"]
    return finding["type"] == "too_short" and any(
        len(other["loc"]) > len(here) and other["loc"][: len(here)] == here for other in findings
    )


def _own_parts(parts: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """The location without what the validator adds for the alternatives of a strategy parameter's type."""
    if "parameters" in parts:
        return parts[: parts.index("parameters") + 2]
    return parts


def _untagged(parts: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """The location without what the validator adds for the shape of a known obstacle."""
    return (*parts[:2], *parts[3:]) if parts[:1] == ("known_obstacles",) else parts


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "{...}"
    text = "true" if value is True else "false" if value is False else repr(value)
    return text if len(text) <= SHOWN_MAX else f"{text[:SHOWN_MAX]}..."


def _location(parts: tuple[int | str, ...]) -> str:
    text = ""
    for part in parts:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else str(part))
    return text


def _known_keys(model: type[BaseModel], parts: tuple[int | str, ...]) -> list[str]:
    """Field names of the (nested) model at `parts`, found by walking annotations; a part that is no field is a shape's tag."""
    current = [model]
    for part in parts:
        if isinstance(part, int):
            continue
        inner = [
            one for outer in current if part in outer.model_fields for one in _models_in(outer.model_fields[part].annotation)
        ]
        current = inner or [one for one in current if _has_tag(one, part)]
    return list(current[0].model_fields) if current else []


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """The model classes inside an annotation such as `tuple[Vehicle, ...]` or `X | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    found = [model for argument in getattr(annotation, "__args__", ()) for model in _models_in(argument)]
    return list(dict.fromkeys(found))


def _has_tag(model: type[BaseModel], tag: str) -> bool:
    """Whether one of the model's fields can only be `tag`."""
    return any(get_args(field.annotation) == (tag,) for field in model.model_fields.values())
