"""Files that a strategy's parameters name are meant relative to the file that names them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def beside(parameters: Mapping[str, object], folder: Path) -> dict[str, object]:
    """`parameters` with the relative paths in their fields `file` and `..._file` seen from `folder`."""
    return {
        name: str(folder / value) if names_file(name) and isinstance(value, str) else value for name, value in parameters.items()
    }


def names_file(name: str) -> bool:
    """Whether a parameter of this name is the path of a file."""
    return name == "file" or name.endswith("_file")
