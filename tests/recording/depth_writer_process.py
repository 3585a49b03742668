"""Records depth frames until it is killed, and says the time of each that it has handed over: `depth_writer_process.py FILE`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from flightapp.recording.recorder import Recorder
from flightapp.runtime.depth_recording import DepthRecording
from flightapp.vehicle.pose_history import PoseHistory
from perception.types import DepthFrame
from tests.recording.depth_flight import CAMERA, EVERY_FRAME, LENS
from tests.recording.samples import T0_S

with Recorder(Path(sys.argv[1])) as recorder:
    recording = DepthRecording(recorder, PoseHistory(), CAMERA, EVERY_FRAME)
    started_s = time.monotonic()
    number = 0
    while True:
        number += 1
        t_s = T0_S + time.monotonic() - started_s
        pixels = np.full((LENS.height_px, LENS.width_px), number, np.uint16)
        recording.offer(DepthFrame(t_s, number, pixels, 0.001, LENS))
        sys.stdout.write(f"{t_s!r}\n")
        sys.stdout.flush()
        time.sleep(0.03)
