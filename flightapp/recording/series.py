"""The messages of one topic as columns: a message is kept as it was written, and only what is asked for is decoded."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, overload

import msgspec
import numpy as np
import orjson
from numpy.typing import NDArray

from flightapp.core.types import Array

_NOT_READABLE = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
Places = NDArray[np.bool_] | NDArray[np.int64]
_NUMBER = bool | float


class Messages(Sequence[dict[str, Any]]):
    """Messages that are decoded when they are looked at, every time: keep what you need, not the dict."""

    def __init__(self, payloads: Sequence[bytes]) -> None:
        self._payloads = payloads

    def __len__(self) -> int:
        return len(self._payloads)

    @overload
    def __getitem__(self, index: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, index: slice) -> Messages: ...
    def __getitem__(self, index: int | slice) -> dict[str, Any] | Messages:
        if isinstance(index, slice):
            return Messages(self._payloads[index])
        return _content(self._payloads[index])

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return map(_content, self._payloads)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def taken(self, indices: Iterable[int]) -> Messages:
        """Some of them, by their places."""
        return Messages([self._payloads[index] for index in indices])

    def numbers(self, name: str) -> list[Any]:
        """The field `name` of every message, where it is a number; None where it is null, absent or something else."""
        return self._fields(name, _NUMBER)

    def rows(self, name: str) -> list[Any]:
        """The field `name` of every message, where it is a list of numbers and nulls; None otherwise."""
        return self._fields(name, list[_NUMBER | None])

    def values(self, name: str) -> list[Any]:
        """The field `name` of every message, whatever it is; None where it is null or absent."""
        return self._fields(name, Any)

    def _fields(self, name: str, kind: object) -> list[Any]:
        decode, depth = _decoder(name, kind).decode, name.count(".") + 1
        return [_field(decode, payload, depth) for payload in self._payloads]


class Series:
    """The messages of one topic in the order of their times `t_s` (n,), fleet time. Columns are decoded once and kept.

    shift_s: added to every time of the recording, to bring another machine's clock onto the time base of the run; `t_s` and the
    columns that are times have it already, `messages` are as they were written. whole: the series that this is a part of, and
    the places (n,) of its messages in there.
    """

    def __init__(
        self,
        topic: str,
        t_s: Array,
        messages: Messages,
        shift_s: float = 0.0,
        whole: tuple[Series, Places] | None = None,
    ) -> None:
        self.topic = topic
        self.t_s = t_s
        self.messages = messages
        self.shift_s = shift_s
        self._whole = whole
        self._columns: dict[str, Array] = {}
        self._values: dict[str, list[Any]] = {}

    def __len__(self) -> int:
        return len(self.messages)

    def column(self, name: str) -> Array:
        """One numeric field of every message, (n,); NaN where it is null or absent."""
        if self._whole is not None:
            series, places = self._whole
            return np.asarray(series.column(name)[places])
        if name not in self._columns:
            values = np.array(self.messages.numbers(name), dtype=np.float64)
            self._columns[name] = values + self.shift_s if name == "t_s" or name.endswith("_t_s") else values
        return self._columns[name].copy()

    def vectors(self, name: str, width: int = 3) -> Array:
        """One field that is a list of `width` numbers, (n, width); NaN where it is null or absent."""
        if self._whole is not None:
            series, places = self._whole
            return np.asarray(series.vectors(name, width)[places])
        key = f"{name}/{width}"
        if key not in self._columns:
            empty = [math.nan] * width
            rows = [row if row is not None and len(row) == width else empty for row in self.messages.rows(name)]
            self._columns[key] = np.array(rows, dtype=np.float64).reshape(-1, width)
        return self._columns[key].copy()

    def texts(self, name: str) -> list[str]:
        """One text field of every message; empty where it is null or absent."""
        return [str(value or "") for value in self.values(name)]

    def values(self, name: str) -> list[Any]:
        """One field of every message, whatever it is; None where it is null or absent. `diagnostics.stage` is a field in one."""
        if self._whole is not None:
            series, places = self._whole
            values = series.values(name)
            return [values[place] for place in places.tolist()]
        if name not in self._values:
            self._values[name] = self.messages.values(name)
        return self._values[name]

    def chosen(self, which: Places) -> Series:
        """The messages at these places (m,), or where a mask (n,) is true."""
        places = np.flatnonzero(which) if which.dtype == np.bool_ else which
        return Series(self.topic, self.t_s[places], self.messages.taken(places.tolist()), self.shift_s, (self, places))

    def shifted(self, shift_s: float) -> Series:
        """The same messages on another time base."""
        return Series(self.topic, self.t_s + shift_s, self.messages, self.shift_s + shift_s)


def no_messages(topic: str) -> Series:
    """A series of nothing."""
    return Series(topic, np.zeros(0), Messages([]))


def _content(payload: bytes) -> dict[str, Any]:
    """The message as a dict; empty if it is not a JSON object, which no recorder of ours writes."""
    try:
        content = orjson.loads(payload)
    except orjson.JSONDecodeError:
        return {}
    return content if isinstance(content, dict) else {}


@functools.cache
def _decoder(name: str, kind: Any) -> msgspec.json.Decoder[Any]:
    """Decodes one field of an object and passes over the others, several times as fast as decoding all of them."""
    kind = kind if kind is Any else kind | None
    for part in reversed(name.split(".")):
        kind = msgspec.defstruct("Only", [("value", kind, None)], rename={"value": part}, gc=False) | None
    return msgspec.json.Decoder(kind)


def _field(decode: Any, payload: bytes, depth: int) -> Any:
    try:
        value = decode(payload)
    except _NOT_READABLE:
        return None
    for _ in range(depth):
        value = None if value is None else value.value
    return value
