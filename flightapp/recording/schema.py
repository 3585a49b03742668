"""JSON schemas of the recorded channels, derived from the message dataclasses.

Foxglove reads a subset of JSON schema: no references, no unions, no arrays of arrays. References are put in place, an
optional value is declared as the value itself (null stays legal JSON for its readers), and properties that the subset
cannot express are left undeclared: the messages still carry them.
"""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

JsonSchema = dict[str, Any]


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
