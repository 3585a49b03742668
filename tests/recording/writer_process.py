"""Records until it is killed, and says after each step what it has logged: `python writer_process.py FILE`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from flightapp.recording.recorder import Recorder
from tests.recording.samples import T0_S, obstacles, own

with Recorder(Path(sys.argv[1])) as recorder:
    started_s = time.monotonic()
    while True:
        t_s = T0_S + time.monotonic() - started_s
        recorder.log("/own", own(t_s), t_s)
        recorder.log("/obstacles", obstacles(t_s), t_s)
        sys.stdout.write(f"{t_s!r}\n")
        sys.stdout.flush()
        time.sleep(0.01)
