"""The view's loop: frames from a source, through perception, to every output that was asked for."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from perception.clock import monotonic_s
from perception.geometry import camera_pose, is_finite
from perception.sources.api import DepthSource
from perception.sources.opening import SourceOptions, open_source
from perception.types import DepthFrame, Intrinsics
from perception.view.arguments import ViewOptions
from perception.view.images import common_intrinsics, is_images, names_of
from perception.view.lettering import Picture
from perception.view.picture import draw, with_notice
from perception.view.picture_folder import PictureFolder
from perception.view.rows import FrameRow, as_json, as_line, as_table, frame_row
from perception.view.serve import LiveView
from perception.view.setup import setup_for
from perception.view.shot import Shot
from perception.view.statistics import RunStatistics
from perception.view.top_view import HeightSlice
from perception.view.video import VideoFile

_POLL_S = 0.002
_SILENCE_S = 1.0
"""After this long without a frame the view says so."""
_LINE_PERIOD_S = 1.0
_TABLES_MAX = 20
"""Up to this many frames are listed disc by disc, more as a line a second."""
_STILL_RATE_HZ = 1.0
_CAMERA_RATE_HZ = 30.0


def run(options: ViewOptions) -> None:
    """Until the source ends, `options.frames` frames are through, or somebody presses Ctrl-C.

    PerceptionInputError for what cannot be read or written; the outputs are complete up to there.
    """
    with ExitStack() as stack:
        view = _View(options, stack)
        stop = stack.enter_context(_stopped_by_signals())
        started_s = monotonic_s()
        try:
            view.show_all(stop)
        except BrokenPipeError:
            # Whoever read the list has seen enough; what Python flushes at its end must not complain again.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        summary = view.summary(monotonic_s() - started_s)
    sys.stderr.write(f"{summary}\n")


class _View:
    """Source, perception and outputs of one run; `stack` closes them."""

    def __init__(self, options: ViewOptions, stack: ExitStack) -> None:
        self._options = options
        self._is_images = is_images(options.source)
        self._is_live = options.source.partition(":")[0] == "realsense"
        self._names = names_of(options.source) if self._is_images else []
        self._has_memory = not self._is_images if options.memory is None else options.memory
        self._source = _opened(options, self._is_images, self._has_memory)
        stack.callback(self._source.close)
        self._setup = setup_for(options, self._source)
        self._pipeline = self._setup.new_pipeline()
        self._statistics = RunStatistics()
        self._folder = PictureFolder(options.out) if options.out else None
        self._video = self._live = None
        if options.video:
            still_s = 1.0 if self._is_images and not self._has_memory else 0.0
            self._video = VideoFile(options.video, options.video_rate_hz, still_s)
            stack.callback(self._video.close)
        if options.port is not None:
            self._live = LiveView(options.host, options.port)
            stack.callback(self._live.close)
            sys.stderr.write(f"watch at {self._live.address} ; Ctrl-C ends\n")
            sys.stderr.flush()
        self._picture: Picture | None = None
        self._json = ""
        self._line_due_s = -math.inf
        self._first: tuple[float, float] | None = None

    def show_all(self, stop: threading.Event) -> None:
        heard_s = monotonic_s()
        while not stop.is_set() and not self._is_complete():
            frame = self._source.latest()
            if frame is None:
                if self._source.is_finished:
                    self._stay(stop)
                    return
                if monotonic_s() - heard_s >= _SILENCE_S:
                    self._say_silence()
                    heard_s = monotonic_s()
                stop.wait(_POLL_S)
                continue
            if not self._wait_for_its_time(frame, stop):
                return
            self._show(frame)
            heard_s = monotonic_s()

    def summary(self, elapsed_s: float) -> str:
        return self._statistics.summary(elapsed_s, self._source.health)

    def _is_complete(self) -> bool:
        return self._options.frames is not None and self._statistics.frames >= self._options.frames

    def _show(self, frame: DepthFrame) -> None:
        shot = self._perceived(frame)
        picture_file: Path | None = None
        if (self._folder or self._video or self._live) and (self._statistics.frames - 1) % self._options.every == 0:
            self._picture = self._drawn(shot)
            if self._folder:
                stem = Path(shot.name).stem if self._is_images else f"{frame.number:06d}"
                picture_file = self._folder.add(stem, self._picture)
            if self._video:
                self._video.add(frame.t_s, self._picture)
        row = frame_row(shot, None if picture_file is None else str(picture_file))
        self._json = as_json(row)
        if self._live and self._picture is not None:
            self._live.show(self._picture, self._json)
        self._list(shot, row)

    def _perceived(self, frame: DepthFrame) -> Shot:
        setup, exclude = self._setup, self._options.exclude
        pose = frame.pose if frame.pose is not None else setup.level_pose
        if not self._has_memory:
            self._pipeline = self._setup.new_pipeline()
        started_s = monotonic_s()
        obstacles = self._pipeline.process(frame, pose, exclude)
        process_s = monotonic_s() - started_s
        latency_s = monotonic_s() - frame.t_s if self._is_live else None
        timing = self._statistics.add(frame.t_s, process_s, latency_s, obstacles.events)
        drawn_pose = pose if is_finite(pose) else setup.level_pose
        number = self._statistics.frames - 1
        name = self._names[number] if number < len(self._names) else f"frame {frame.number}"
        camera = camera_pose(drawn_pose, setup.mounting)
        return Shot(name, frame, drawn_pose, camera, exclude, obstacles, self._source.health, timing)

    def _drawn(self, shot: Shot) -> Picture:
        setup, parameters = self._setup, self._setup.parameters
        height_slice = HeightSlice(
            parameters.band_m, setup.ground_down_m, parameters.ground_margin_m, parameters.ground_margin_slope
        )
        view_range_m = self._options.view_range_m or setup.range_max_m
        return draw(shot, height_slice, range_max_m=setup.range_max_m, view_range_m=view_range_m)

    def _list(self, shot: Shot, row: FrameRow) -> None:
        """On standard output: JSON Lines if wanted, else a table a frame while they are few, else a line a second."""
        options = self._options
        frames = min(options.frames or math.inf, len(self._names) or math.inf)
        if options.json:
            sys.stdout.write(self._json + "\n")
        elif frames <= _TABLES_MAX:
            sys.stdout.write(as_table(row) + "\n")
        elif monotonic_s() >= self._line_due_s:
            self._line_due_s = monotonic_s() + _LINE_PERIOD_S
            sys.stdout.write(as_line(shot) + "\n")
        sys.stdout.flush()

    def _wait_for_its_time(self, frame: DepthFrame, stop: threading.Event) -> bool:
        """With `real_time`, a recorded frame waits until it is its turn; False if somebody stops meanwhile."""
        if self._is_live or not self._options.real_time:
            return True
        now_s = monotonic_s()
        if self._first is None or not 0 <= frame.t_s - self._first[0] - (now_s - self._first[1]) < 2 * _SILENCE_S:
            self._first = (frame.t_s, now_s)
        return not stop.wait(max(0.0, frame.t_s - self._first[0] - (now_s - self._first[1])))

    def _say_silence(self) -> None:
        fault = self._source.health.fault
        notice = f"no frame for {_SILENCE_S:g} s" + (f": {fault}" if fault else "")
        sys.stderr.write(f"{notice}\n")
        if self._live and self._picture is not None:
            self._live.show(with_notice(self._picture, notice), self._json)

    def _stay(self, stop: threading.Event) -> None:
        """The last picture of a recording stays on the web page until somebody has seen enough."""
        if self._live:
            sys.stderr.write("end of the recording; the last picture stays until Ctrl-C\n")
            sys.stderr.flush()
            stop.wait()


def _opened(options: ViewOptions, are_images: bool, is_sequence: bool) -> DepthSource:
    intrinsics = None
    width, height = options.size_px
    if are_images:
        intrinsics = common_intrinsics(options.source, options.intrinsics)
    elif options.intrinsics is not None:
        intrinsics = Intrinsics(width, height, *options.intrinsics)
    rate_hz = options.rate_hz or (_STILL_RATE_HZ if are_images and not is_sequence else _CAMERA_RATE_HZ)
    return open_source(
        options.source,
        SourceOptions(
            intrinsics=intrinsics,
            width_px=width,
            height_px=height,
            rate_hz=rate_hz,
            depth_unit_m=options.depth_unit_m,
            is_real_time=options.real_time,
            vehicle=options.vehicle,
        ),
    )


@contextmanager
def _stopped_by_signals() -> Iterator[threading.Event]:
    """Set by the first Ctrl-C or SIGTERM; a second Ctrl-C breaks off. Only the main thread may catch signals."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def note(_: int, __: FrameType | None) -> None:
        stop.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    before: dict[signal.Signals, Any] = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
