"""How quantities travel: whole numbers of a small unit, which MessagePack writes in one to five bytes, a float in nine.

Resolution: 1 cm, 1 cm/s, 1 mrad, 1 ms; each far below what a GPS, a compass and a measured clock offset know.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

Name = Annotated[str, Meta(min_length=1, max_length=32)]
Word = Annotated[str, Meta(max_length=32)]
Sentence = Annotated[str, Meta(max_length=200)]
Centimetres = Annotated[int, Meta(ge=-10_000_000, le=10_000_000)]
"""Also of speed: cm/s."""
Milliradians = Annotated[int, Meta(ge=-3_142, le=3_142)]
Milliseconds = Annotated[int, Meta(ge=-3_600_000, le=3_600_000)]
"""From the send time: negative is before it."""
Vector = tuple[Centimetres, Centimetres, Centimetres]

Triple = tuple[float, float, float]


def centimetres(value_m: float) -> int:
    return round(value_m * 100.0)


def metres(value_cm: int) -> float:
    return value_cm / 100.0


def vector(value_m: Triple) -> Vector:
    north, east, down = value_m
    return round(north * 100.0), round(east * 100.0), round(down * 100.0)


def triple(value_cm: Vector) -> Triple:
    north, east, down = value_cm
    return north / 100.0, east / 100.0, down / 100.0


def milliradians(value_rad: float) -> int:
    return round(value_rad * 1000.0)


def radians(value_mrad: int) -> float:
    return value_mrad / 1000.0


def since(sent_s: float, t_s: float) -> int:
    """What travels for the stamp `t_s`."""
    return round((t_s - sent_s) * 1000.0)


def stamp(sent_s: float, offset_ms: int) -> float:
    """The stamp, on the clock that `sent_s` was corrected to."""
    return sent_s + offset_ms / 1000.0
