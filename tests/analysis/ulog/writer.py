"""A small writer of ULog files, for flights with injected faults (format: docs.px4.io, ULog file format, version 1)."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

MAGIC = b"ULog\x01\x12\x35\x01"


@dataclass
class UlogWriter:
    """Topics with float fields only. Times in s since the log began; `boot_s` is the autopilot's clock then."""

    boot_s: float = 100.0
    information: dict[str, str] = field(default_factory=lambda: {"ver_hw": "PX4_FMU_V6C", "sys_name": "PX4"})
    parameters: dict[str, float] = field(default_factory=dict)
    topics: dict[str, tuple[npt.NDArray[np.float64], dict[str, npt.NDArray[np.float64]]]] = field(default_factory=dict)
    messages: list[tuple[float, int, str]] = field(default_factory=list)

    def topic(self, name: str, t_s: npt.ArrayLike, **fields: npt.ArrayLike) -> None:
        times = np.asarray(t_s, dtype=np.float64)
        columns = {key.replace("__", "["): np.broadcast_to(np.asarray(v, np.float64), times.shape) for key, v in fields.items()}
        self.topics[name] = (times, {key + "]" if "[" in key else key: value for key, value in columns.items()})

    def change(self, name: str, **fields: npt.ArrayLike) -> None:
        """Replace fields of a topic that is there."""
        times, columns = self.topics[name]
        self.topics[name] = (
            times,
            columns | {k: np.broadcast_to(np.asarray(v, np.float64), times.shape) for k, v in fields.items()},
        )

    def cut_after(self, t_s: float) -> None:
        """Drop everything later, as a loss of power does."""
        for name, (times, columns) in self.topics.items():
            kept = times <= t_s
            self.topics[name] = (times[kept], {key: value[kept] for key, value in columns.items()})
        self.messages = [message for message in self.messages if message[0] <= t_s]

    def write(self, path: Path) -> Path:
        path.write_bytes(self.content())
        return path

    def content(self) -> bytes:
        parts = [MAGIC, struct.pack("<Q", self._stamp(0.0)), _message(b"B", bytes(40))]
        for key, text in self.information.items():
            name = f"char[{len(text.encode())}] {key}".encode()
            parts.append(_message(b"I", bytes([len(name)]) + name + text.encode()))
        for name, (_, columns) in self.topics.items():
            layout = "uint64_t timestamp;" + "".join(f"{kind};" for kind in _layout(columns))
            parts.append(_message(b"F", f"{name}:{layout}".encode()))
        for key, value in self.parameters.items():
            name = f"float {key}".encode()
            parts.append(_message(b"P", bytes([len(name)]) + name + struct.pack("<f", value)))
        for number, name in enumerate(self.topics):
            parts.append(_message(b"A", struct.pack("<BH", 0, number) + name.encode()))
        return b"".join([*parts, *(data for _, data in sorted(self._data(), key=lambda one: one[0]))])

    def _data(self) -> list[tuple[float, bytes]]:
        found = []
        for number, (times, columns) in enumerate(self.topics.values()):
            rows = np.column_stack([np.zeros(len(times)), *columns.values()])[:, 1:]
            for t_s, row in zip(times.tolist(), rows.tolist(), strict=True):
                found.append((t_s, _message(b"D", struct.pack(f"<HQ{len(row)}f", number, self._stamp(t_s), *row))))
        for t_s, level, text in self.messages:
            found.append((t_s, _message(b"L", struct.pack("<BQ", ord("0") + level, self._stamp(t_s)) + text.encode())))
        return found

    def _stamp(self, t_s: float) -> int:
        return round((self.boot_s + t_s) * 1e6)


def _layout(columns: Mapping[str, object]) -> list[str]:
    """Array elements `name[0]`, `name[1]` that follow each other are one field."""
    arrays: dict[str, int] = {}
    for key in columns:
        name = key.split("[")[0]
        arrays[name] = arrays.get(name, 0) + 1
    return [f"float[{count}] {name}" if f"{name}[0]" in columns else f"float {name}" for name, count in arrays.items()]


def _message(kind: bytes, payload: bytes) -> bytes:
    return struct.pack("<H", len(payload)) + kind + payload
