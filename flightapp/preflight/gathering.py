"""From the rooms of a vehicle to the facts that the checks judge."""

from __future__ import annotations

from flightapp.fleet.security.credentials import load_credentials
from flightapp.preflight.computer import computer_facts
from flightapp.preflight.facts import CameraFacts, Facts, RecorderFacts, TeammateFacts, WayFacts
from flightapp.preflight.px4_parameters import Needed, needed_parameters
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.ground_ways import ways_from_the_ground
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.runtime.rooms import Rooms
from flightapp.vehicle.velocity_gains import PLANAR, VERTICAL


class Gatherer:
    """Reads the autopilot's parameters one by one, everything else at once."""

    def __init__(self, rooms: Rooms, loop: ControlLoop) -> None:
        self._rooms = rooms
        self._loop = loop
        self._began_s = rooms.clock.now_s()
        self._parameters: dict[str, float | None] = {}
        self._frames_at_first: tuple[float, int] | None = None
        self._ahead_s: dict[str, float] = {}
        self._ways: tuple[WayFacts, ...] = ()
        folder = rooms.profile.network.certificates
        self._credentials = None if folder is None else load_credentials(folder)

    @property
    def needed(self) -> tuple[Needed, ...]:
        """The rules for this vehicle."""
        return needed_parameters(self._rooms.mission, self._rooms.profile, self._rooms.vehicle)

    async def read_parameters(self) -> None:
        """Ask for every parameter of the table; FlightError where the autopilot does not answer properly."""
        for rule in self.needed:
            self._parameters[rule.name] = await self._rooms.autopilot.parameter(rule.name, is_integer=rule.is_integer)
        if self._rooms.tracker is not None:
            for name in (PLANAR, VERTICAL):
                self._parameters[name] = await self._rooms.autopilot.parameter(name, is_integer=False)

    async def plan_ways(self) -> None:
        """Plan what the mission wants planned, from the ground."""
        self._ways = await ways_from_the_ground(self._rooms)

    async def write_parameter(self, rule: Needed) -> float | None:
        """Write what `rule` wants, and read it back."""
        autopilot = self._rooms.autopilot
        await autopilot.set_parameter(rule.name, rule.write, is_integer=rule.is_integer)
        self._parameters[rule.name] = await autopilot.parameter(rule.name, is_integer=rule.is_integer)
        return self._parameters[rule.name]

    def facts(self) -> Facts:
        """What is known now."""
        rooms = self._rooms
        now_s = rooms.clock.now_s()
        motion = rooms.autopilot.motion()
        return Facts(
            t_s=now_s,
            waited_s=now_s - self._began_s,
            mission=rooms.mission,
            mission_digest=rooms.mission_digest,
            profile=rooms.profile,
            vehicle=rooms.vehicle,
            status=rooms.autopilot.status(),
            health=rooms.autopilot.health(),
            motion=motion,
            motion_age_s=None if motion is None else now_s - motion.arrived_s,
            battery=rooms.autopilot.battery(),
            details=rooms.autopilot.details(),
            parameters=dict(self._parameters),
            camera=None if self._loop.perception is None else self._camera(self._loop.perception, now_s),
            teammates=tuple(self._teammates(now_s)),
            computer=computer_facts(rooms.profile.recording.folder),
            credentials=self._credentials,
            recorder=RecorderFacts(rooms.journal.flush_slowest_s, rooms.journal.recording_error),
            ways=self._ways,
        )

    def _camera(self, perception: PerceptionThread, now_s: float) -> CameraFacts:
        newest, health = perception.newest, perception.health
        arrived = health.source.received
        if self._frames_at_first is None and arrived:
            self._frames_at_first = (now_s, arrived)
        first = self._frames_at_first
        rate_hz = 0.0 if first is None or now_s <= first[0] else (arrived - first[1]) / (now_s - first[0])
        return CameraFacts(
            frame_age_s=None if newest is None else now_s - newest.frame_s,
            latency_s=None if newest is None else newest.latency_s,
            rate_hz=rate_hz,
            failure=perception.failure or "",
            fault=health.source.fault,
            restarts=health.source.restarts,
            warning=health.source.warning,
        )

    def _teammates(self, now_s: float) -> list[TeammateFacts]:
        found = []
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if state is None:
                found.append(TeammateFacts(name, None, "", None, 0.0))
            else:
                self._ahead_s[name] = max(peer.ahead_s, self._ahead_s.get(name, peer.ahead_s))
                measured_s = self._rooms.team.post.clock_ahead_s.get(name)
                found.append(
                    TeammateFacts(name, now_s - state.t_s, state.mission, state.system_id, self._ahead_s[name], measured_s)
                )
        return found
