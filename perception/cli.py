"""The command line: recorded depth frames -> pictures and a list of discs."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypedDict

import cv2
import numpy as np

from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting, camera_pose
from perception.parameters import PerceptionParameters
from perception.picture import draw
from perception.pipeline import PerceptionPipeline
from perception.sources.png_folder import list_frames, read_depth_png
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose

_EXAMPLE = "example: python -m perception frames/ --intrinsics 421.6,421.6,424,240 --out pictures/"


class DiscRow(TypedDict):
    """One disc as listed: position of the centre in front (north) and to the right (east) of the camera."""

    number: int
    north_m: float
    east_m: float
    radius_m: float
    distance_m: float
    bearing_deg: float


class FrameRow(TypedDict):
    """One frame as listed."""

    file: str
    picture: str
    discs: list[DiscRow]
    unseen_deg: list[list[float]]
    events: list[str]


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0, or 2 on bad input."""
    options = _parser().parse_args(arguments)
    try:
        rows = _run(options)
    except PerceptionInputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(json.dumps(rows, indent=2) + "\n" if options.json else _table(rows))
    return 0


def _run(options: argparse.Namespace) -> list[FrameRow]:
    focal_and_centre = _intrinsics(options.intrinsics)
    for field in ("height_m", "band_m", "range_max_m", "depth_unit_m"):
        if not (math.isfinite(getattr(options, field)) and getattr(options, field) > 0):
            raise PerceptionInputError(f"--{field.replace('_', '-')} = {getattr(options, field)}: a positive number is wanted")
    if not abs(options.pitch_deg) <= 60:
        raise PerceptionInputError(f"--pitch-deg = {options.pitch_deg}: between -60 and 60 is wanted")
    if options.range_max_m <= options.range_min_m or options.range_min_m < 0:
        raise PerceptionInputError(
            f"--range-min-m = {options.range_min_m}: at least 0 and less than --range-max-m = {options.range_max_m} is wanted"
        )
    files = list_frames(options.frames)
    # Everything is read once before anything is written: a bad file leaves no half-finished folder behind.
    width, height = _common_size(files)
    intrinsics = Intrinsics(width, height, *focal_and_centre)
    if not (0 < intrinsics.cx_px < width and 0 < intrinsics.cy_px < height):
        raise PerceptionInputError(
            f"--intrinsics = '{options.intrinsics}': the centre ({intrinsics.cx_px:g}, {intrinsics.cy_px:g}) lies outside the "
            f"{width}x{height} image {files[0].name}; FX,FY,CX,CY of the depth image are wanted, in pixels"
        )
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PerceptionInputError(f"--out = '{options.out}': cannot be made a folder: {error.strerror}") from None
    return [_one(file, number, intrinsics, options) for number, file in enumerate(files)]


def _one(file: Path, number: int, intrinsics: Intrinsics, options: argparse.Namespace) -> FrameRow:
    """Process one file, write its picture, return its row."""
    parameters = PerceptionParameters(band_m=options.band_m, memory_s=0.0, stride_px=options.stride_px)
    mounting = CameraMounting()
    pipeline = PerceptionPipeline(
        parameters,
        mounting,
        range_min_m=options.range_min_m,
        range_max_m=options.range_max_m,
        ground_down_m=options.height_m,
    )
    pose = VehiclePose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, math.radians(options.pitch_deg), 0.0)
    frame = DepthFrame(float(number), number, read_depth_png(file), options.depth_unit_m, intrinsics)
    obstacles = pipeline.process(frame, pose)
    picture = draw(
        frame, obstacles, camera_pose(pose, mounting), band_m=options.band_m, range_max_m=options.range_max_m, title=file.name
    )
    target = options.out / f"{file.stem}-discs.png"
    new = target.with_name(f".{target.name}")
    try:
        new.write_bytes(cv2.imencode(".png", picture)[1].tobytes())
        new.replace(target)
    except OSError as error:
        raise PerceptionInputError(f"{target}: cannot be written: {error.strerror}") from None
    return _row(file, target, obstacles)


def _row(file: Path, picture: Path, obstacles: PerceivedObstacles) -> FrameRow:
    discs = [
        DiscRow(
            number=i,
            north_m=round(float(disc[0]), 3),
            east_m=round(float(disc[1]), 3),
            radius_m=round(float(disc[2]), 3),
            distance_m=round(float(np.hypot(disc[0], disc[1]) - disc[2]), 3),
            bearing_deg=round(math.degrees(math.atan2(disc[1], disc[0])), 1),
        )
        for i, disc in enumerate(obstacles.discs, start=1)
    ]
    unseen = [[round(math.degrees(bearing), 1) for bearing in sector] for sector in obstacles.unseen]
    return FrameRow(file=str(file), picture=str(picture), discs=discs, unseen_deg=unseen, events=list(obstacles.events))


def _table(rows: list[FrameRow]) -> str:
    lines = []
    for row in rows:
        lines.append(f"{row['file']}  ->  {row['picture']}")
        lines.extend(f"  ! {event}" for event in row["events"])
        if row["discs"]:
            lines.append("     no.  distance_m  bearing_deg  north_m  east_m  radius_m")
        lines.extend(
            f"    {d['number']:4d}  {d['distance_m']:10.2f}  {d['bearing_deg']:11.1f}  {d['north_m']:7.2f}  {d['east_m']:6.2f}"
            f"  {d['radius_m']:8.2f}"
            for d in row["discs"]
        )
        if not row["discs"]:
            lines.append("    no obstacle")
    return "\n".join(lines) + "\n"


def _intrinsics(text: str) -> tuple[float, float, float, float]:
    wanted = "four numbers FX,FY,CX,CY in pixels are wanted, for example 421.6,421.6,424,240"
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise PerceptionInputError(f"--intrinsics = '{text}': {wanted}") from None
    if len(numbers) != 4 or not all(math.isfinite(number) and number > 0 for number in numbers):
        raise PerceptionInputError(f"--intrinsics = '{text}': {wanted}")
    return numbers[0], numbers[1], numbers[2], numbers[3]


def _common_size(files: Sequence[Path]) -> tuple[int, int]:
    """Width and height that all images have."""
    size: tuple[int, int] | None = None
    for file in files:
        height, width = read_depth_png(file).shape
        if size is not None and size != (width, height):
            raise PerceptionInputError(
                f"{file}: {width}x{height} pixels, {files[0].name} has {size[0]}x{size[1]}; one size for all is wanted, "
                "because the intrinsics belong to one"
            )
        size = (width, height)
    assert size is not None
    return size


class _Parser(argparse.ArgumentParser):
    """One sentence on bad input, as everywhere else."""

    def error(self, message: str) -> Any:
        sys.stderr.write(f"{message}; see python -m perception --help\n")
        sys.exit(2)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="python -m perception",
        description="Find obstacles in recorded depth frames, as seen by a level camera that looks north.",
        epilog=_EXAMPLE,
    )
    parser.add_argument("frames", type=Path, metavar="FRAME_OR_FOLDER", help="16-bit PNG depth image, or a folder of them")
    parser.add_argument("--intrinsics", required=True, metavar="FX,FY,CX,CY", help="of the depth image, in pixels")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="where one picture a frame is written")
    parser.add_argument("--json", action="store_true", help="list the discs as JSON")
    parser.add_argument("--height-m", type=float, default=1.0, help="height of the camera above the floor (%(default)s)")
    parser.add_argument("--pitch-deg", type=float, default=0.0, help="pitch of the camera, positive looks up (%(default)s)")
    parser.add_argument("--band-m", type=float, default=0.3, help="obstacles count this much above and below (%(default)s)")
    parser.add_argument("--range-min-m", type=float, default=0.3, help="nearer depths are not believed (%(default)s)")
    parser.add_argument("--range-max-m", type=float, default=10.0, help="further depths are not believed (%(default)s)")
    parser.add_argument("--depth-unit-m", type=float, default=0.001, help="metres a count (%(default)s)")
    parser.add_argument("--stride-px", type=int, choices=range(1, 9), default=2, metavar="1-8", help="use every n-th pixel")
    return parser
