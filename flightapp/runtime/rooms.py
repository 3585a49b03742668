"""The parts that one vehicle process is made of."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.clock import Clock
from flightapp.core.types import Boundary, Limits, ObstacleSet
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.coordination.team_plan import TeamPlan
from flightapp.fleet.team import Team
from flightapp.planning.api import Planner
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.journal import Journal
from flightapp.safety.supervisor import Supervisor
from flightapp.vehicle.autopilot import Autopilot

if TYPE_CHECKING:
    from flightapp.control.tracker import VelocityTracker  # compiled: loaded only where it flies


@dataclass(frozen=True, slots=True)
class Rooms:
    """The parts one control loop works with, built by `composition` and `vehicle_process`."""

    clock: Clock
    mission: Mission
    mission_digest: str
    """Digest of the mission file, to find out whether all vehicles fly the same one."""
    vehicle: Vehicle
    profile: Profile
    limits: Limits
    autopilot: Autopilot
    planner: Planner
    supervisor: Supervisor
    target_filter: TargetFilter
    team: Team
    journal: Journal
    heartbeat: Heartbeat
    boundary: Boundary
    surveyed: ObstacleSet
    """Obstacles known from the mission, for a vehicle that flies without a camera."""
    election_memory: Path
    """File of the term and the vote that must survive a restart."""
    team_plan: TeamPlan | None = None
    """What this vehicle plans by for the team when it leads; None: by sectors around the evader."""
    tracker: VelocityTracker | None = None
    """Between planner and supervisor, where the autopilot's own velocity loop is not to be alone."""
