"""A PNG image or a folder of them, looked through before anything is made of them."""

from __future__ import annotations

from pathlib import Path

from perception.errors import PerceptionInputError
from perception.sources.png_folder import list_frames, read_depth_png
from perception.types import Intrinsics


def is_images(source: str) -> bool:
    """Whether `source` names images; a folder with a flight's recording in it is one run."""
    if Path(source).is_dir():
        return not any(Path(source).glob("*.mcap"))
    return Path(source).suffix.lower() == ".png"


def names_of(source: str) -> list[str]:
    return [file.name for file in list_frames(Path(source))]


def common_intrinsics(source: str, focal_and_centre: tuple[float, float, float, float] | None) -> Intrinsics:
    """Intrinsics of images that all have one size. Reads every file: a bad one is found before anything is written."""
    files = list_frames(Path(source))
    if focal_and_centre is None:
        raise PerceptionInputError(
            f"--intrinsics: missing; {source} carries none: FX,FY,CX,CY of the depth image are wanted, in pixels"
        )
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
    fx, fy, cx, cy = focal_and_centre
    if not (cx < size[0] and cy < size[1]):
        raise PerceptionInputError(
            f"--intrinsics = '{fx:g},{fy:g},{cx:g},{cy:g}': the centre ({cx:g}, {cy:g}) lies outside the {size[0]}x{size[1]} "
            f"image {files[0].name}; FX,FY,CX,CY of the depth image are wanted, in pixels"
        )
    return Intrinsics(*size, fx, fy, cx, cy)
