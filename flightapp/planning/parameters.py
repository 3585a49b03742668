"""Strict parameter models: an unknown or impossible value is one clear sentence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TypeVar, cast

from pydantic import BaseModel, ConfigDict, ValidationError

from flightapp.config.loading import known_instead, wanted_instead
from flightapp.core.errors import InputError


class StrategyParameters(BaseModel):
    """Base of every strategy's parameters: frozen, no unknown fields, finite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


Model = TypeVar("Model", bound=StrategyParameters)


def parsed(model: type[Model], strategy: str, parameters: Mapping[str, object] | None) -> Model:
    """`parameters` as `model`; InputError names the strategy, the field, the value and what would be right.

    Types are taken at their word, as in every file: '5' is not a number, and true is not 1.
    """
    try:
        return model.model_validate_json(json.dumps(dict(parameters or {}), default=str), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or "parameters"
        if first["type"] == "extra_forbidden":
            known = tuple(_model_at(model, first["loc"][:-1]).model_fields)
            right = known_instead(str(first["loc"][-1]), known)
            raise InputError(f"strategy '{strategy}': {field} is not a parameter; {right}") from None
        value = "" if isinstance(first["input"], dict) else f" = {first['input']!r}"
        raise InputError(f"strategy '{strategy}': {field}{value}: {wanted_instead(first)}") from None


def _model_at(model: type[BaseModel], parts: tuple[int | str, ...]) -> type[BaseModel]:
    """The model of the table at `parts`."""
    for part in parts:
        model = cast(type[BaseModel], model.model_fields[str(part)].annotation)
    return model
