"""What a person may type after `python -m perception`, checked: every mistake is one sentence."""

from __future__ import annotations

import argparse
import math
import sys
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting
from perception.parameters import PerceptionParameters
from perception.sources.opening import SOURCES_WANTED

_EXAMPLES = """examples:
  python -m perception synthetic --video look.mp4
  python -m perception realsense --serve 8080
  python -m perception frames/ --intrinsics 421.6,421.6,424,240 --out pictures/
  python -m perception run.mcap --json | jq .discs
"""


@dataclass(frozen=True, slots=True)
class ViewOptions:
    """Checked options; None where nothing was said. intrinsics: (fx, fy, cx, cy) in pixels.

    exclude: (k, 3) north_m, east_m, radius_m of circles in which nothing counts.
    """

    source: str
    intrinsics: tuple[float, float, float, float] | None
    size_px: tuple[int, int]
    rate_hz: float | None
    depth_unit_m: float
    vehicle: str | None
    out: Path | None
    video: Path | None
    video_rate_hz: float
    port: int | None
    host: str
    json: bool
    frames: int | None
    every: int
    real_time: bool
    memory: bool | None
    height_m: float | None
    pitch_rad: float
    roll_rad: float
    ground_down_m: float | None
    exclude: NDArray[np.float64]
    parameters: PerceptionParameters
    has_profile: bool
    band_m: float | None
    mounting: CameraMounting | None
    range_min_m: float | None
    range_max_m: float | None
    view_range_m: float | None


def parse(arguments: Sequence[str] | None = None) -> ViewOptions:
    """PerceptionInputError names the option, the value and what would be right; a wrong spelling exits with status 2."""
    given = _parser().parse_args(arguments)
    parameters, mounting, camera = _profile(given.profile)
    if given.stride_px is not None:
        parameters = parameters.model_copy(update={"stride_px": given.stride_px})
    range_min_m = camera.get("range_min_m") if given.range_min_m is None else given.range_min_m
    range_max_m = camera.get("range_max_m") if given.range_max_m is None else given.range_max_m
    if given.video is not None and given.video.suffix.lower() != ".mp4":
        raise PerceptionInputError(f"--video = '{given.video}': a name that ends in .mp4 is wanted")
    return ViewOptions(
        source=given.source,
        intrinsics=None if given.intrinsics is None else _intrinsics(given.intrinsics),
        size_px=_size(given.size),
        rate_hz=None if given.rate_hz is None else _positive("--rate-hz", given.rate_hz),
        depth_unit_m=_positive("--depth-unit-m", given.depth_unit_m),
        vehicle=given.vehicle,
        out=given.out,
        video=given.video,
        video_rate_hz=_between("--video-rate-hz", given.video_rate_hz, 1, 120),
        port=None if given.serve is None else int(_between("--serve", given.serve, 0, 65535)),
        host=given.host,
        json=given.json,
        frames=None if given.frames is None else int(_between("--frames", given.frames, 1, math.inf)),
        every=int(_between("--every", given.every, 1, math.inf)),
        real_time=given.real_time or given.serve is not None,
        memory=given.memory,
        height_m=None if given.height_m is None else _positive("--height-m", given.height_m),
        pitch_rad=math.radians(_between("--pitch-deg", given.pitch_deg, -60, 60)),
        roll_rad=math.radians(_between("--roll-deg", given.roll_deg, -60, 60)),
        ground_down_m=(
            None if given.ground_down_m is None else _between("--ground-down-m", given.ground_down_m, -10_000, 10_000)
        ),
        exclude=_circles(given.exclude),
        parameters=parameters,
        has_profile=given.profile is not None,
        band_m=None if given.band_m is None else _positive("--band-m", given.band_m),
        mounting=mounting,
        range_min_m=None if range_min_m is None else _between("--range-min-m", range_min_m, 0, 100),
        range_max_m=None if range_max_m is None else _positive("--range-max-m", range_max_m),
        view_range_m=None if given.view_range_m is None else _between("--view-range-m", given.view_range_m, 1, 100),
    )


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        sys.stderr.write(f"{message}; see python -m perception --help\n")
        sys.exit(2)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="python -m perception",
        description="Show what perception makes of depth frames: the depth image with the obstacle discs, and the top view.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("source", metavar="SOURCE", help=SOURCES_WANTED)
    shown = parser.add_argument_group("what comes out (any of them together; a list of discs on the terminal without)")
    shown.add_argument("--out", type=Path, metavar="FOLDER", help="one PNG a frame")
    shown.add_argument("--video", type=Path, metavar="FILE.mp4", help="a video (MPEG-4; VLC, mpv and ffmpeg play it)")
    shown.add_argument("--video-rate-hz", type=float, default=30.0, metavar="HZ", help="its pictures a second (%(default)g)")
    shown.add_argument("--serve", type=int, metavar="PORT", help="the newest picture for web browsers; 0 takes a free port")
    shown.add_argument("--host", default="127.0.0.1", help="address to serve at; 0.0.0.0 shows it to the network (%(default)s)")
    shown.add_argument("--json", action="store_true", help="one line of JSON a frame, on standard output")
    shown.add_argument("--every", type=int, default=1, metavar="K", help="draw every K-th frame only; all are processed")
    shown.add_argument("--frames", type=int, metavar="N", help="end after N frames")
    shown.add_argument("--view-range-m", type=float, metavar="M", help="how far colours and top view reach (as the range)")
    camera = parser.add_argument_group("the camera")
    camera.add_argument("--intrinsics", metavar="FX,FY,CX,CY", help="of the depth image, in pixels; PNG images need them")
    camera.add_argument("--size", default="848x480", metavar="WxH", help="of a camera's or synthetic image (%(default)s)")
    camera.add_argument("--rate-hz", type=float, metavar="HZ", help="of a camera (30), or of a folder of images (1)")
    camera.add_argument("--depth-unit-m", type=float, default=0.001, metavar="M", help="metres a count of a PNG (%(default)s)")
    camera.add_argument("--vehicle", metavar="NAME", help="whose frames to take from a recording of several vehicles")
    camera.add_argument("--profile", type=Path, metavar="FILE", help="mounting, range and parameters of a vehicle")
    camera.add_argument("--range-min-m", type=float, metavar="M", help="nearer depths do not count (as recorded, or 0.3)")
    camera.add_argument("--range-max-m", type=float, metavar="M", help="further depths do not count (as recorded, or 10)")
    camera.add_argument("--real-time", action="store_true", help="recordings at the pace at which they were taken")
    pose = parser.add_argument_group("where it is, for frames that come without a pose: level, looking north")
    pose.add_argument("--height-m", type=float, metavar="M", help="height above the floor, which then is no obstacle (unknown)")
    pose.add_argument("--pitch-deg", type=float, default=0.0, metavar="DEG", help="positive looks up (%(default)s)")
    pose.add_argument("--roll-deg", type=float, default=0.0, metavar="DEG", help="positive: right side down (%(default)s)")
    pose.add_argument("--ground-down-m", type=float, metavar="M", help="the ground, in the frame of recorded poses (0)")
    work = parser.add_argument_group("perception")
    work.add_argument("--memory", action=argparse.BooleanOptionalAction, help="on for streams, off for separate images")
    work.add_argument(
        "--band-m", type=float, metavar="M", help="obstacles count this much above and below (in flight 1, else 0.3)"
    )
    work.add_argument("--stride-px", type=int, choices=range(1, 9), metavar="1-8", help="use every n-th pixel")
    work.add_argument(
        "--exclude", action="append", default=[], metavar="N,E,R", help="nothing counts in this circle; may be repeated"
    )
    return parser


def _positive(option: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise PerceptionInputError(f"{option} = {value}: a positive number is wanted")
    return value


def _between(option: str, value: float, least: float, most: float) -> float:
    if not (least <= value <= most and math.isfinite(value)):
        wanted = f"between {least} and {most}" if math.isfinite(most) else f"at least {least}"
        raise PerceptionInputError(f"{option} = {value}: {wanted} is wanted")
    return value


def _numbers(text: str, count: int) -> list[float] | None:
    """`count` finite numbers with commas between them, or None."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return None
    return numbers if len(numbers) == count and all(math.isfinite(number) for number in numbers) else None


def _intrinsics(text: str) -> tuple[float, float, float, float]:
    numbers = _numbers(text, 4)
    if numbers is None or min(numbers) <= 0:
        raise PerceptionInputError(
            f"--intrinsics = '{text}': four numbers FX,FY,CX,CY in pixels are wanted, for example 421.6,421.6,424,240"
        )
    return numbers[0], numbers[1], numbers[2], numbers[3]


def _size(text: str) -> tuple[int, int]:
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal() and 64 <= int(width) <= 1920 and 48 <= int(height) <= 1080):
        raise PerceptionInputError(f"--size = '{text}': WIDTHxHEIGHT between 64x48 and 1920x1080 is wanted, for example 848x480")
    return int(width), int(height)


def _circles(texts: Sequence[str]) -> NDArray[np.float64]:
    circles = np.zeros((len(texts), 3))
    for circle, text in zip(circles, texts, strict=True):
        numbers = _numbers(text, 3)
        if numbers is None or numbers[2] <= 0:
            raise PerceptionInputError(f"--exclude = '{text}': NORTH,EAST,RADIUS in metres is wanted, for example 5,-1.5,0.8")
        circle[:] = numbers
    return circles


def _profile(path: Path | None) -> tuple[PerceptionParameters, CameraMounting | None, dict[str, float]]:
    """What a vehicle's profile says about perception: [perception], [camera.mounting], and the ranges in [camera]."""
    if path is None:
        return PerceptionParameters(), None, {}
    try:
        with path.open("rb") as file:
            tables = tomllib.load(file)
    except OSError as error:
        raise PerceptionInputError(f"--profile = '{path}': cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise PerceptionInputError(f"--profile = '{path}': not a TOML file: {error}") from None
    camera = _checked(path, "camera", tables, dict)
    try:
        parameters = PerceptionParameters(**_checked(path, "perception", tables, dict))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise PerceptionInputError(f"{path}: perception.{field}: {first['msg']}") from None
    mounting = _checked(path, "mounting", camera, dict)
    names = set(CameraMounting.__dataclass_fields__)
    angles_and_places = {name: _checked(path, name, mounting, float) for name in names & set(mounting)}
    ranges = {name: _checked(path, name, camera, float) for name in ("range_min_m", "range_max_m") if name in camera}
    return parameters, CameraMounting(**angles_and_places), ranges


def _checked(path: Path, name: str, table: dict[str, Any], kind: Callable[[Any], Any]) -> Any:
    """`table[name]` as a table or a number; an empty one where there is none."""
    value = table.get(name, {})
    is_right = isinstance(value, dict) if kind is dict else isinstance(value, int | float) and math.isfinite(value)
    if not is_right or isinstance(value, bool):
        raise PerceptionInputError(f"{path}: {name} = {value!r}: a {'table' if kind is dict else 'number'} is wanted")
    return kind(value)
