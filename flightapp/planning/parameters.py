"""Strict parameter models: an unknown or impossible value is one clear sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from flightapp.core.errors import InputError


class StrategyParameters(BaseModel):
    """Base of every strategy's parameters: frozen, no unknown fields, finite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


Model = TypeVar("Model", bound=StrategyParameters)


def parsed(model: type[Model], strategy: str, parameters: Mapping[str, object] | None) -> Model:
    """`parameters` as `model`; InputError names the strategy, the field, the value and what would be right."""
    try:
        return model.model_validate(dict(parameters or {}))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or "parameters"
        if first["type"] == "extra_forbidden":
            known = ", ".join(model.model_fields)
            raise InputError(f"strategy '{strategy}': {field} is not a parameter; known: {known}") from None
        value = "" if isinstance(first["input"], dict) else f" = {first['input']!r}"
        raise InputError(f"strategy '{strategy}': {field}{value}: {first['msg']}") from None
