"""A chase of three for the tests: the demo with a third pursuer, no cameras, and an evader that starts nearer."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
PURSUERS = ("p1", "p2", "p3")
THIRD = """
[[vehicles]]
name = "p3"
role = "pursuer"
system_id = 4
start = { north_m = 0.0, east_m = 0.0, heading_deg = 0.0 }
strategy = { name = "ac2f" }
camera = false

[[vehicles]]
name = "e1"
"""


def chase_of_three(folder: Path, evader_north_m: float = 40.0) -> Path:
    """The mission file, written into `folder`."""
    text = (ROOT / "missions/demo_two_pursuers.toml").read_text()
    text = text.replace('\n[[vehicles]]\nname = "e1"\n', THIRD).replace("{ north_m = 55.0,", f"{{ north_m = {evader_north_m},")
    text = text.replace('strategy = { name = "ac2f" }\n\n', 'strategy = { name = "ac2f" }\ncamera = false\n\n')
    mission = folder / "three.toml"
    mission.write_text(text)
    return mission
