"""How the messages of a channel are written: Foxglove's own as Protobuf, ours as JSON with a schema derived from the dataclass.

Foxglove reads a subset of JSON schema: no references, no unions, no arrays of arrays. References are put in place, an
optional value is declared as the value itself (null stays legal JSON for its readers), and properties that the subset
cannot express are left undeclared: the messages still carry them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import foxglove
import orjson
from pydantic import TypeAdapter

JsonSchema = dict[str, Any]
_JSON = orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS


def schema_of(message: type) -> JsonSchema | foxglove.Schema:
    """What the file says about a channel's messages."""
    return message.get_schema() if is_foxglove(message) else json_schema(message)  # type: ignore[attr-defined]


def encoding_of(message: type) -> str:
    """The name of the message encoding in the file."""
    return "protobuf" if is_foxglove(message) else "json"


def encoder_of(message: type) -> Callable[[Any], bytes]:
    """From a message of this type to its bytes."""
    return message.encode if is_foxglove(message) else _json  # type: ignore[attr-defined]


def is_foxglove(message: type) -> bool:
    """Whether it is one of Foxglove's own message types."""
    return hasattr(message, "get_schema")


def _json(message: object) -> bytes:
    return orjson.dumps(message, _plain_value, _JSON)


def _plain_value(value: object) -> object:
    """What the serialiser does not know, as something it does."""
    if isinstance(value, Mapping):
        return dict(value)
    tolist = getattr(value, "tolist", None)
    return tolist() if tolist is not None else repr(value)


def json_schema(message: type) -> JsonSchema:
    """The schema of one message dataclass, titled with its name."""
    full = TypeAdapter(message).json_schema()
    plain = _plain(full, full.get("$defs", {}))
    assert plain is not None, f"{message.__name__} is not an object"
    plain["title"] = message.__name__
    return plain


def _plain(node: JsonSchema, definitions: dict[str, JsonSchema]) -> JsonSchema | None:
    """`node` in the subset, or None where the subset has no word for it."""
    if "$ref" in node:
        return _plain(definitions[node["$ref"].rpartition("/")[2]], definitions)
    if "anyOf" in node:
        choices = [choice for choice in node["anyOf"] if choice.get("type") != "null"]
        return _plain(choices[0], definitions) if len(choices) == 1 else None
    kind = node.get("type")
    if kind == "object":
        properties = {name: _plain(child, definitions) for name, child in node.get("properties", {}).items()}
        return {"type": "object", "properties": {name: child for name, child in properties.items() if child is not None}}
    if kind == "array":
        items = _plain(node["items"], definitions)
        return None if items is None or items["type"] == "array" else {"type": "array", "items": items}
    return {"type": kind} if kind in ("number", "integer", "string", "boolean") else None
