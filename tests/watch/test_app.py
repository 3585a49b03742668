"""`flightapp watch` on real Zenoh sessions over loopback, its terminal by textual's pilot."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
import zenoh
from textual.pilot import Pilot
from textual.widgets import DataTable, Static
from typer.testing import CliRunner

from flightapp.cli import app as command_line
from flightapp.core.clock import ManualClock, SystemClock
from flightapp.core.errors import InputError
from flightapp.fleet.security.access import Membership, membership_of
from flightapp.fleet.security.keys import KeyWish, make_keys
from flightapp.fleet.session import zenoh_config
from flightapp.sim.fleet_files import ReservedPorts
from flightapp.watch.data_model_confirmation import CONFIRM_WITHIN_S
from flightapp.watch.data_model_fleet import Overview
from flightapp.watch.data_model_rows import Link
from flightapp.watch.frontend_app import WatchApp
from flightapp.watch.session import Watch, Wish
from tests.watch.loopback import LoopbackVehicle
from tests.watch.scenes import MISSION, MISSION_FILE

ROOT = Path(__file__).parents[2]
DEADLINE_S = 20.0
NOBODY = "udp/127.0.0.1:9"


@pytest.fixture
def port() -> Iterator[int]:
    ports = ReservedPorts(1)
    yield ports.numbers[0]
    ports.release()


@pytest.fixture
def endpoint(port: int) -> str:
    return f"udp/127.0.0.1:{port}"


def start_vehicle(endpoint: str, ahead_s: float) -> subprocess.Popen[bytes]:
    """p1 as a process of its own."""
    return subprocess.Popen([sys.executable, "-m", "tests.watch.loopback", "p1", endpoint, str(ahead_s)], cwd=ROOT)


@asynccontextmanager
async def vehicle(endpoint: str, membership: Membership | None = None) -> AsyncIterator[LoopbackVehicle]:
    """p1, flying."""
    session = await asyncio.to_thread(zenoh.open, zenoh_config([endpoint], [], membership=membership))
    flown = LoopbackVehicle(session, "p1")
    flying = asyncio.create_task(flown.fly())
    try:
        yield flown
    finally:
        flying.cancel()
        await asyncio.to_thread(session.close)


@asynccontextmanager
async def watched(wish: Wish, clock: ManualClock | None = None) -> AsyncIterator[tuple[WatchApp, Pilot[None]]]:
    """`clock`: of the time between two presses, which stands still unless a test moves it."""
    async with Watch(wish).opened() as source:
        app = WatchApp(source, clock or ManualClock())
        async with app.run_test(size=(100, 30)) as pilot:
            yield app, pilot
        await app.all_sent()


async def until(pilot: Pilot[None], condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(DEADLINE_S):
        while not condition():
            await pilot.pause(0.02)


def shown(app: WatchApp, widget: str) -> str:
    return str(app.query_one(f"#{widget}", Static).content)


def cell(app: WatchApp, name: str, heading: str) -> str:
    return str(app.query_one("#fleet", DataTable).get_cell(name, heading))


def run(story: Coroutine[object, object, None]) -> None:
    asyncio.run(story)


def test_a_vehicle_with_a_wrong_clock_is_shown_marked_silent_when_it_is_killed_and_back_when_it_is_restarted(
    endpoint: str, tmp_path: Path
) -> None:
    async def story() -> None:
        process = start_vehicle(endpoint, 2.5)
        try:
            async with watched(Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl")) as (app, pilot):
                await until(pilot, lambda: cell(app, "p1", "phase") == "pursue")
                await until(pilot, lambda: cell(app, "p1", "clock").startswith("+2"))
                assert cell(app, "p1", "clock").endswith("!")
                await until(pilot, lambda: float(cell(app, "p1", "link s").split()[0]) < 0.7)
                assert cell(app, "p1", "h m") == "6.5"
                assert cell(app, "p1", "m/s") == "5.0"
                assert cell(app, "p1", "guards") == "separation"
                assert cell(app, "p2", "phase") == "not heard"
                await until(pilot, lambda: cell(app, "p1", "name") == "p1*")
                assert "p1* leads, term 4" in shown(app, "title")
                assert "↑p1" in shown(app, "map")
                assert "p1 is 2.5 s ahead of this machine's" in shown(app, "alarms")
                process.kill()
                process.wait()
                await until(pilot, lambda: "LOST" in cell(app, "p1", "link s"))
                assert "ALARM p1 silent for" in shown(app, "alarms")
                await until(pilot, lambda: "?p1" in shown(app, "map"))
                process = start_vehicle(endpoint, 2.5)
                await until(pilot, lambda: "LOST" not in cell(app, "p1", "link s"))
                assert "p1 is heard again" in shown(app, "events")
        finally:
            process.kill()
            process.wait()

    run(story())


def test_a_command_is_sent_at_the_second_press_to_who_is_selected_and_its_answer_shown_and_recorded(
    endpoint: str, tmp_path: Path
) -> None:
    record = tmp_path / "commands.jsonl"

    async def story() -> None:
        async with vehicle(endpoint) as p1, watched(Wish(MISSION_FILE, [endpoint], record)) as (app, pilot):
            await until(pilot, lambda: cell(app, "p1", "phase") == "pursue")
            await pilot.press("h")
            assert shown(app, "order") == "HOLD the whole fleet? Press h again to send it."
            await pilot.press("down")
            await until(pilot, lambda: shown(app, "order") == "no command was sent from here")
            await pilot.press("h")
            assert shown(app, "order") == "HOLD p1? Press h again to send it."
            await pilot.press("l")
            assert shown(app, "order") == "LAND p1? Press l again to send it."
            await pilot.press("escape")
            await pilot.press("l", "h", "h")
            await until(pilot, lambda: "p1: accepted, obeys hold (" in shown(app, "order"))
            assert shown(app, "order").endswith(" ms)")
            assert p1.obeyed == ["hold"]
            await pilot.press("u", "u")
            await until(pilot, lambda: "p1: REFUSED, not possible in phase takeoff (" in shown(app, "order"))
        assert p1.obeyed == ["hold", "resume"]

    run(story())
    hold, resume = [json.loads(line) for line in record.read_text().splitlines()]
    assert (hold["action"], hold["vehicles"], resume["action"]) == ("hold", ["p1"], "resume")
    assert hold["answers"][0]["accepted"]
    assert hold["answers"][0]["round_trip_ms"] > 0.0


def test_a_press_that_is_not_confirmed_in_time_does_nothing(endpoint: str, tmp_path: Path) -> None:
    async def story() -> None:
        wish = Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl")
        clock = ManualClock()
        async with vehicle(endpoint) as p1, watched(wish, clock) as (app, pilot):
            await until(pilot, lambda: cell(app, "p1", "phase") == "pursue")
            await pilot.press("a")
            assert "ABORT the whole fleet?" in shown(app, "order")
            clock.advance(CONFIRM_WITHIN_S + 0.1)
            await until(pilot, lambda: "no command was sent" in shown(app, "order"))
            await pilot.press("a")
            assert "ABORT the whole fleet?" in shown(app, "order"), "the second press came too late and asks anew"
        assert p1.obeyed == []

    run(story())
    assert not (tmp_path / "commands.jsonl").exists()


def test_who_quits_right_after_confirming_has_still_sent_it(endpoint: str, tmp_path: Path) -> None:
    async def story() -> None:
        wish = Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl")
        async with vehicle(endpoint) as p1, watched(wish) as (app, pilot):
            await until(pilot, lambda: cell(app, "p1", "phase") == "pursue")
            await pilot.press("down", "l", "l", "q")
        assert p1.obeyed == ["land"]

    run(story())
    assert '"accepted":true' in (tmp_path / "commands.jsonl").read_text()


@pytest.mark.parametrize("size", [(80, 24), (40, 12)])
def test_without_any_vehicle_it_says_so_and_where_it_listens_also_in_a_small_terminal(
    size: tuple[int, int], tmp_path: Path
) -> None:
    async def story() -> None:
        async with watched(Wish(MISSION_FILE, [NOBODY], tmp_path / "commands.jsonl")) as (app, pilot):
            await pilot.resize_terminal(*size)
            await until(pilot, lambda: "no vehicle is heard" in shown(app, "alarms"))
            assert "no vehicle of fleet demo heard" in shown(app, "title")
            assert NOBODY in shown(app, "title")
            for widget in ("title", "fleet", "target", "alarms", "order", "help"):
                region = app.query_one(f"#{widget}").region
                assert region.height > 0, widget
                assert region.bottom <= size[1], widget
            assert (app.query_one("#map").region.width > 0) is (size[0] >= 60)

    run(story())


def test_it_publishes_nothing_and_asks_only_for_the_time_until_a_person_commands(endpoint: str, tmp_path: Path) -> None:
    """A member that it connects to hears everything that it says."""
    asked: set[str] = set()
    said: list[str] = []

    def note(query: zenoh.Query) -> None:
        with query:
            asked.add(str(query.key_expr))

    async def story() -> None:
        spy = await asyncio.to_thread(zenoh.open, zenoh_config([endpoint], []))
        everything = spy.declare_subscriber("**", lambda sample: said.append(str(sample.key_expr)))
        tokens = spy.liveliness().declare_subscriber("**", lambda sample: said.append(str(sample.key_expr)), history=True)
        queries = spy.declare_queryable("flightapp/**", note)
        try:
            async with watched(Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl")) as (_, pilot):
                times = {f"flightapp/{MISSION.fleet}/{name}/clock" for name in ("p1", "p2", "e1")}
                await until(pilot, lambda: asked >= times)
                assert asked == times
                await pilot.press("down", "h", "h")
                await until(pilot, lambda: f"flightapp/{MISSION.fleet}/p1/command" in asked)
            assert said == []
            declared = [everything, tokens, queries]
            assert len(declared) == 3
        finally:
            await asyncio.to_thread(spy.close)

    run(story())


def test_in_a_fleet_with_certificates_the_operators_are_enough_to_watch_and_command(port: int, tmp_path: Path) -> None:
    names = tuple(one.name for one in MISSION.vehicles)
    keys = tmp_path / "keys"
    make_keys(KeyWish(keys, MISSION.fleet, names, dict.fromkeys(names, ("127.0.0.1",)), 1.0), SystemClock().now_s())
    endpoint = f"quic/127.0.0.1:{port}"

    async def story() -> None:
        wish = Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl", keys / "operator")
        async with vehicle(endpoint, membership_of(MISSION, keys / "p1")) as p1, watched(wish) as (app, pilot):
            await until(pilot, lambda: cell(app, "p1", "phase") == "pursue" and cell(app, "p1", "clock") != "-")
            await until(pilot, lambda: cell(app, "p1", "name") == "p1*")
            await pilot.press("down", "h", "h")
            await until(pilot, lambda: "p1: accepted" in shown(app, "order"))
            assert p1.obeyed == ["hold"]

    run(story())


def test_for_machines_it_says_a_line_of_json_a_second_or_looks_once_without_a_terminal(endpoint: str, tmp_path: Path) -> None:
    told: list[Overview] = []

    async def listen() -> None:
        async with asyncio.timeout(DEADLINE_S):
            telling = asyncio.create_task(Watch(Wish(MISSION_FILE, [endpoint], tmp_path / "commands.jsonl")).tell(told.append))
            while not (len(told) > 1 and told[-1].leadership.leader == "p1" and told[-1].rows[0].link is Link.FRESH):
                await asyncio.sleep(0.02)
            telling.cancel()

    process = start_vehicle(endpoint, 0.0)
    try:
        run(listen())
        arguments = ["watch", str(MISSION_FILE), "--connect", endpoint, "--profile", str(ROOT / "profiles/sim.toml"), "--once"]
        once = CliRunner().invoke(command_line, arguments)
        machines = CliRunner().invoke(command_line, [*arguments, "--json"])
    finally:
        process.kill()
        process.wait()
    assert told[-1].now_s - told[-2].now_s > 0.5
    assert (once.exit_code, machines.exit_code) == (0, 0)
    assert "p1* leads, term 4" in once.output
    assert "e1 was not heard yet" in once.output
    assert json.loads(machines.output)["vehicles"][0]["height_m"] == 6.5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--connect", "nonsense"], "--connect 'nonsense' is not an endpoint"),
        (["--connect", "quic/127.0.0.1:9"], "needs certificates"),
        (["--connect", NOBODY], "this is no terminal; add --json"),
        (["--connect", NOBODY, "--profile", "missing.toml"], "missing.toml"),
    ],
)
def test_what_cannot_be_watched_is_said_in_one_sentence(arguments: list[str], words: str) -> None:
    said = CliRunner().invoke(command_line, ["watch", str(MISSION_FILE), *arguments])
    assert isinstance(said.exception, InputError)
    assert words in str(said.exception)
