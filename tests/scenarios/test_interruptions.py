"""What happens when a person, or the machine, ends one vehicle's flight early."""

import signal
from pathlib import Path

from tests.runtime.one_vehicle import until
from tests.scenarios.simulation import HOVER, simulation


def test_a_second_ctrl_c_ends_everything_at_once(tmp_path: Path) -> None:
    with simulation(tmp_path, HOVER) as hover:
        hover.until(lambda: hover.phase("e1") == "pursue", 60.0, "flight")
        hover.interrupt()
        hover.until(lambda: "press Ctrl-C again" in hover.said(), 5.0, "answer to Ctrl-C")
        hover.interrupt()
        assert hover.process.wait(timeout=20) == 3
        assert hover.processes() == []


def test_when_the_launcher_is_killed_no_process_stays(tmp_path: Path) -> None:
    with simulation(tmp_path, HOVER) as hover:
        hover.until(lambda: hover.phase("e1") == "pursue", 60.0, "flight")
        left = hover.processes()
        hover.process.send_signal(signal.SIGKILL)
        hover.process.wait()
        assert left
        until(lambda: hover.processes() == [], 60.0, "end of all processes")
