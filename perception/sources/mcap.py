"""The depth frames of a flight recorded by flightapp (MCAP): pixels, intrinsics, capture time, the vehicle's pose, the camera.

Each frame is two messages of the same log time: `<topic>` is a foxglove.CompressedImage (16-bit PNG), `<topic>/info` is JSON with
all the rest. They are read in order, one frame ahead of the caller. A file that was cut off plays up to the cut, and one that is
damaged plays without what was damaged.
"""

from __future__ import annotations

import json
import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import IO, Any

import cv2
import numpy as np
from mcap.records import Channel, Header, Message, Metadata, Schema
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray

from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting
from perception.mcap_walk import MAGIC, Walk, why_no_mcap
from perception.sources.api import SourceHealth
from perception.types import DepthFrame, Intrinsics, VehiclePose

PROFILE = "flightapp"
IMAGE_SCHEMA = "foxglove.CompressedImage"
VERSION = 1
"""Of the messages on `<topic>/info`."""


@dataclass(frozen=True, slots=True)
class RecordedCamera:
    """How the camera sat on the vehicle, how far it was believed, and the ground it flew over."""

    mounting: CameraMounting
    range_min_m: float
    range_max_m: float
    ground_down_m: float


class McapSource:
    """Returns every recorded depth frame once, one a call, at the times of the recording.

    path: a recording, or a folder with one in it. vehicle: chooses among the recordings of a folder, and must be the file's own
    otherwise. PerceptionInputError, one sentence, where there is no depth frame to read. A damaged frame later in the file is
    left out: it counts in `health.lost`, and `health.fault` says what was wrong.
    """

    def __init__(self, path: Path, topic: str = "/depth", *, vehicle: str | None = None) -> None:
        self.path = _one_recording(path, vehicle)
        self._received = 0
        self._lost = 0
        self._fault = ""
        try:
            self._file = self.path.open("rb")
        except OSError as error:
            raise PerceptionInputError(f"{self.path}: cannot be read: {error.strerror}") from None
        try:
            self._messages = _Messages(self._file, self.path, topic)
            first = next(iter(self._messages), None)
            self._check_vehicle(vehicle)
            if first is None:
                raise PerceptionInputError(f"{self.path}: {self._messages.why_nothing()}")
            self._next: DepthFrame | None
            self._next, self.camera = self._decoded(*first)
        except PerceptionInputError:
            self._file.close()
            raise

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received, lost=self._lost, fault=self._fault)

    @property
    def is_finished(self) -> bool:
        return self._next is None

    def latest(self) -> DepthFrame | None:
        frame = self._next
        if frame is not None:
            self._received += 1
            self._next = self._following()
        return frame

    def close(self) -> None:
        self._next = None
        self._messages.close()
        self._file.close()

    def _following(self) -> DepthFrame | None:
        self._fault = ""
        for info, image in self._messages:
            try:
                frame, self.camera = self._decoded(info, image)
            except PerceptionInputError as error:
                self._lost += 1
                self._fault = str(error)
            else:
                return frame
        self._fault = self._messages.why_incomplete(self._received)
        return None

    def _check_vehicle(self, vehicle: str | None) -> None:
        recorded = self._messages.vehicle
        if vehicle is not None and recorded is not None and vehicle != recorded:
            raise PerceptionInputError(f"{self.path}: is the recording of vehicle '{recorded}', not of '{vehicle}'")

    def _decoded(self, info: bytes, image: _Image) -> tuple[DepthFrame, RecordedCamera]:
        try:
            content = json.loads(info)
            if content["version"] != VERSION:
                raise PerceptionInputError(
                    f"{self.path}: its depth frames are of version {content['version']}, this program reads version {VERSION}; "
                    "read it with the program that recorded it"
                )
            return _frame(content, _pixels(image.decoded(self.path))), _camera(content)
        except KeyError as error:
            raise PerceptionInputError(f"{self.path}: a depth frame lacks the field {error}; the file is damaged") from None
        except (ValueError, TypeError, OverflowError, RecursionError) as error:
            raise PerceptionInputError(f"{self.path}: a depth frame cannot be read: {error}; the file is damaged") from None


@dataclass(frozen=True, slots=True)
class _Image:
    """One message of the image topic, as it stands in the file."""

    topic: str
    encoding: str
    schema: Schema | None
    data: bytes
    decoders: DecoderFactory

    def decoded(self, path: Path) -> bytes:
        """The compressed image."""
        if self.schema is None or self.schema.name != IMAGE_SCHEMA or self.encoding != "protobuf":
            found = "messages without a schema" if self.schema is None else f"{self.schema.name} in {self.encoding}"
            raise PerceptionInputError(f"{path}: '{self.topic}' holds {found}; {IMAGE_SCHEMA} in protobuf is wanted")
        try:
            decode = self.decoders.decoder_for("protobuf", self.schema)
            return bytes(decode(self.data).data) if decode is not None else b""
        except Exception as error:  # protobuf's own kind, which carries no type information
            raise ValueError(f"its {IMAGE_SCHEMA} message: {error}") from None


class _Messages:
    """Iterates over (info, image) of each depth frame, as far as the file can be read."""

    def __init__(self, file: IO[bytes], path: Path, topic: str) -> None:
        self._topic = topic
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._decoders = DecoderFactory()
        self.vehicle: str | None = None
        size = path.stat().st_size
        if why := why_no_mcap(file.read(len(MAGIC))):
            raise PerceptionInputError(f"{path}: {why}")
        self._path = path
        self._walk = Walk(file, size)
        self._records = self._walk.records()
        first = next(self._records, None)
        if first is None:
            raise PerceptionInputError(f"{path}: the recording broke off before its first record; nothing can be read")
        if isinstance(first, Header) and first.profile != PROFILE:
            raise PerceptionInputError(
                f"{path}: an MCAP file, but not a recording of {PROFILE} (profile {first.profile[:40]!r}, "
                f"written by {first.library[:40]!r})"
            )
        self._pairs = self._paired()

    def __iter__(self) -> Iterator[tuple[bytes, _Image]]:
        return self._pairs

    def close(self) -> None:
        self._pairs.close()
        self._records.close()

    def why_nothing(self) -> str:
        """Why there was not a single frame."""
        topics = {channel.topic for channel in self._channels.values()}
        if self._topic in topics and f"{self._topic}/info" not in topics:
            return f"the images on '{self._topic}' have no '{self._topic}/info' beside them that says what they show"
        lost = self._walk.losses.sentence
        amiss = ("" if self._walk.complete else " and breaks off") + (f" ({lost})" if lost else "")
        return f"holds no depth frames on '{self._topic}'{amiss}; a vehicle records them with recording.depth_rate_hz above 0"

    def why_incomplete(self, frames: int) -> str:
        """What is amiss with the file, once it is read through; empty if nothing is."""
        if not self._walk.complete:
            return f"{self._path}: the recording breaks off after {frames} depth frames"
        lost = self._walk.losses.sentence
        return f"{self._path}: {lost}" if lost else ""

    def _paired(self) -> Generator[tuple[bytes, _Image]]:
        info: tuple[int, bytes] | None = None
        for record in self._records:
            if isinstance(record, Message):
                channel = self._channels.get(record.channel_id)
                if channel is None:
                    continue
                if channel.topic == f"{self._topic}/info":
                    info = record.log_time, record.data
                elif channel.topic == self._topic and info is not None and info[0] == record.log_time:
                    schema = self._schemas.get(channel.schema_id)
                    yield info[1], _Image(self._topic, channel.message_encoding, schema, record.data, self._decoders)
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            elif isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Metadata) and record.name == "run":
                self.vehicle = record.metadata.get("vehicle")


def _pixels(image: bytes) -> NDArray[np.uint16]:
    depth = cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_UNCHANGED) if image else None
    if depth is None or depth.dtype != np.uint16 or depth.ndim != 2:
        raise ValueError("its image is not a 16-bit PNG of one channel")
    return np.ascontiguousarray(depth, np.uint16)


def _frame(content: dict[str, Any], depth: NDArray[np.uint16]) -> DepthFrame:
    height, width = depth.shape
    if (width, height) != (content["width_px"], content["height_px"]):
        raise ValueError(f"its image has {width}x{height} pixels, not {content['width_px']}x{content['height_px']}")
    fx, fy, cx, cy = (_number(content, name) for name in ("fx_px", "fy_px", "cx_px", "cy_px"))
    unit_m = _number(content, "depth_unit_m")
    if min(fx, fy, unit_m) <= 0:
        raise ValueError(f"fx_px = {fx}, fy_px = {fy} and depth_unit_m = {unit_m} must be positive")
    intrinsics = Intrinsics(width, height, fx, fy, cx, cy)
    return DepthFrame(_number(content, "t_s"), int(content["frame_number"]), depth, unit_m, intrinsics, _pose(content))


def _pose(content: dict[str, Any]) -> VehiclePose | None:
    """None where the autopilot had not told it."""
    if content["position_ned_m"] is None:
        return None
    position, velocity = (_triple(content[name]) for name in ("position_ned_m", "velocity_ned_m_s"))
    roll, pitch, yaw = (_number(content, name) for name in ("roll_rad", "pitch_rad", "yaw_rad"))
    return VehiclePose(position, velocity, roll, pitch, yaw)


def _camera(content: dict[str, Any]) -> RecordedCamera:
    mounting = CameraMounting(**{each.name: _number(content["mounting"], each.name) for each in fields(CameraMounting)})
    return RecordedCamera(mounting, *(_number(content, name) for name in ("range_min_m", "range_max_m", "ground_down_m")))


def _number(content: dict[str, Any], name: str) -> float:
    value = float(content[name])
    if not math.isfinite(value):
        raise ValueError(f"{name} = {value} is not a finite number")
    return value


def _triple(values: list[float]) -> tuple[float, float, float]:
    north, east, down = (float(value) for value in values)
    return north, east, down


def _one_recording(path: Path, vehicle: str | None) -> Path:
    """The file itself, or the only one of the folder that fits."""
    if path.is_file():
        return path
    if not path.is_dir():
        raise PerceptionInputError(f"{path}: no such file or folder; a recording (.mcap) or a run folder is wanted")
    files = sorted(path.glob("*.mcap"))
    chosen = files if vehicle is None else [file for file in files if file.stem == vehicle]
    if len(chosen) == 1:
        return chosen[0]
    names = ", ".join(file.name for file in files)
    if not files:
        raise PerceptionInputError(f"{path}: the folder holds no recording (.mcap)")
    if not chosen:
        raise PerceptionInputError(f"{path}: the folder holds no {vehicle}.mcap; name one of {names}")
    raise PerceptionInputError(f"{path}: the folder holds several recordings; name one of {names}")
