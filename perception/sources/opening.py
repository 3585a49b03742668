"""From what a person types to a source of depth frames: one row a kind of source."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from perception.clock import monotonic_s, unix_s
from perception.errors import PerceptionInputError
from perception.sources.api import DepthSource
from perception.sources.png_folder import PngFolderSource
from perception.sources.realsense import open_camera
from perception.sources.realsense_recording import RealSenseRecordingSource
from perception.sources.realsense_stream import DepthMode
from perception.types import Intrinsics


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """What a source may need beside its name; each takes what concerns it.

    intrinsics: needed by PNG images, which carry none; others bring their own. rate_hz: of the camera, and of a folder of
    images without times. is_real_time: recordings come at the pace they were recorded, not as fast as they are read.
    vehicle: whose frames to read from an MCAP recording of several. now_s, unix_s: the caller's time and the host's Unix time.
    """

    intrinsics: Intrinsics | None = None
    width_px: int = 848
    height_px: int = 480
    rate_hz: float = 30.0
    depth_unit_m: float = 0.001
    is_real_time: bool = False
    vehicle: str | None = None
    now_s: Callable[[], float] = monotonic_s
    unix_s: Callable[[], float] = unix_s


def open_source(what: str, options: SourceOptions) -> DepthSource:
    """The source that `what` names; PerceptionInputError, one sentence, if there is none or it cannot be opened.

    what: `realsense`, `realsense:SERIAL`, `synthetic`, FILE.db3, FILE.bag, FILE.mcap or the folder of a run, FILE.png or a
    folder of PNG files.
    """
    for kind in _KINDS:
        if what and kind.is_meant(what):
            return kind.open(what, options)
    raise PerceptionInputError(f"'{what}': no such file, folder or camera; wanted is {SOURCES_WANTED}")


@dataclass(frozen=True, slots=True)
class _Kind:
    wanted: str
    is_meant: Callable[[str], bool]
    open: Callable[[str, SourceOptions], DepthSource]


def _open_camera(what: str, options: SourceOptions) -> DepthSource:
    _, colon, serial_number = what.partition(":")
    if colon and not serial_number:
        raise PerceptionInputError(f"'{what}': the serial number is missing; realsense:SERIAL or realsense is wanted")
    return open_camera(
        now_s=options.now_s,
        unix_s=options.unix_s,
        mode=DepthMode(options.width_px, options.height_px, options.rate_hz),
        serial_number=serial_number or None,
    )


def _open_camera_recording(what: str, options: SourceOptions) -> DepthSource:
    return RealSenseRecordingSource(Path(what), now_s=options.now_s, is_real_time=options.is_real_time)


def _open_mcap(what: str, options: SourceOptions) -> DepthSource:
    # Imported here: reading recordings needs what flying with a camera does not.
    from perception.sources.mcap import McapSource

    return McapSource(Path(what), vehicle=options.vehicle)


def _open_images(what: str, options: SourceOptions) -> DepthSource:
    if options.intrinsics is None:
        raise PerceptionInputError(f"{what}: PNG images carry no intrinsics; FX,FY,CX,CY of the depth image are wanted")
    return PngFolderSource(Path(what), options.intrinsics, depth_unit_m=options.depth_unit_m, period_s=1 / options.rate_hz)


def _open_synthetic(_: str, options: SourceOptions) -> DepthSource:
    from perception.sources import demonstration
    from perception.sources.synthetic import SyntheticSource

    lens = options.intrinsics or demonstration.demonstration_intrinsics(options.width_px, options.height_px)
    return SyntheticSource(
        demonstration.demonstration_scene(),
        lens,
        demonstration.demonstration_motion,
        rate_hz=options.rate_hz,
        duration_s=demonstration.DURATION_S,
    )


def _is_run(what: str) -> bool:
    """A folder of recordings."""
    return Path(what).is_dir() and any(Path(what).glob("*.mcap"))


def _has_suffix(*suffixes: str) -> Callable[[str], bool]:
    return lambda what: Path(what).suffix.lower() in suffixes and not Path(what).is_dir()


_KINDS = (
    _Kind("realsense or realsense:SERIAL", lambda what: what.partition(":")[0] == "realsense", _open_camera),
    _Kind("synthetic", lambda what: what == "synthetic", _open_synthetic),
    _Kind("a recording FILE.db3 or FILE.bag of the RealSense SDK", _has_suffix(".db3", ".bag"), _open_camera_recording),
    _Kind(
        "a recording FILE.mcap of flightapp, or its run's folder",
        lambda what: _has_suffix(".mcap")(what) or _is_run(what),
        _open_mcap,
    ),
    _Kind("a 16-bit FILE.png or a folder of them", lambda what: Path(what).is_dir() or _has_suffix(".png")(what), _open_images),
)
SOURCES_WANTED = ", ".join(kind.wanted for kind in _KINDS)
