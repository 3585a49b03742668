"""The [flight_volume] table as text of a mission file, whose comments and order stay as they are."""

from __future__ import annotations

import os
import re
from pathlib import Path

from flightapp.config.mission import FlightVolume, load_mission
from flightapp.core.errors import InputError

_TABLE = re.compile(r"^\[flight_volume\][^\n]*\n(?:(?!\s*\[\[?[A-Za-z_]).*\n?)*", re.MULTILINE)


def flight_volume_toml(volume: FlightVolume) -> str:
    """The [flight_volume] table of a mission file."""
    lines = ["[flight_volume]"]
    for name, value in volume.model_dump(exclude_none=True).items():
        if name.endswith("vertices_m"):
            shown = "[" + ", ".join(f"[{round(north, 3)}, {round(east, 3)}]" for north, east in value) + "]"
        else:
            shown = f'"{value}"' if isinstance(value, str) else str(value)
        lines.append(f"{name} = {shown}")
    return "\n".join(lines) + "\n"


def replace_flight_volume(mission_path: Path, volume: FlightVolume) -> None:
    """Put `volume` into the file, which is replaced only where the whole mission is valid with it; InputError otherwise."""
    text = mission_path.read_text(encoding="utf-8")
    if len(_TABLE.findall(text)) != 1:
        raise InputError(f"{mission_path}: [flight_volume] must stand as a table of its own to be replaced; paste it instead")
    changed = _TABLE.sub(lambda _: flight_volume_toml(volume), text)
    draft = mission_path.with_name(f".{mission_path.name}.draft")
    try:
        draft.write_text(changed, encoding="utf-8")
        load_mission(draft)
        os.replace(draft, mission_path)
    except InputError as error:
        raise InputError(str(error).replace(str(draft), f"{mission_path} with the new fence")) from None
    except OSError as error:
        raise InputError(f"{mission_path}: cannot be written: {error.strerror}") from None
    finally:
        draft.unlink(missing_ok=True)
