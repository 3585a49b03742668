"""The command line: parse, call one function, print. Bad input is one clear sentence and exit status 2."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shlex
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer.core import TyperCommand, TyperGroup

from flightapp.core.errors import FlightError, InputError

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
fence = typer.Typer(no_args_is_help=True, help="The flight volume as KML, for a map program.")
app.add_typer(fence, name="fence")

Profile = Annotated[Path, typer.Option("--profile", help="The vehicle's hardware profile.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of everything random.")]
Live = Annotated[
    int | None,
    typer.Option(
        "--live", metavar="[PORT]", min=0, max=65535, help="Serve a live view for Foxglove or Lichtblick; 8765, 0: any port."
    ),
]
LiveAddress = Annotated[str, typer.Option("--live-address", help="Address that the live view is bound to; 0.0.0.0: all.")]
LIVE_PORT, LOOPBACK = "8765", "127.0.0.1"
Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
SIM_PROFILE = Path("profiles/sim.toml")
DEMO_MISSION = Path("missions/demo_two_pursuers.toml")
NETWORK_MISSION = Path("missions/demo_three_pursuers.toml")
DENSE_SCENARIO = Path("missions/scenarios/a2-dense.toml")


@app.callback()
def flightapp() -> None:
    """Cooperative UAV pursuit on companion computers."""


class _LivePort(TyperCommand):
    """`--live` may stand without its port."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        given: list[str] = []
        for place, argument in enumerate(args):
            given.append(argument)
            following = args[place + 1] if place + 1 < len(args) else ""
            if argument == "--live" and not following.lstrip("-").isdigit():
                given.append(LIVE_PORT)
        return super().parse_args(ctx, given)


@app.command(cls=_LivePort)
def sim(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    profile: Profile = SIM_PROFILE,
    seed: Seed = 0,
    as_json: Json = False,
    run: Annotated[Path | None, typer.Option("--run", help="Folder for this run; default runs/TIME-MISSION.")] = None,
    certificates: Annotated[
        Path | None, typer.Option("--certificates", help="Folder of flightapp keys; fleet talks TLS.")
    ] = None,
    secure: Annotated[bool, typer.Option("--secure", help="As --certificates, with keys only for this run.")] = False,
    live: Live = None,
    live_address: LiveAddress = LOOPBACK,
) -> None:
    """Fly a whole mission on this machine: real MAVLink, Zenoh, depth frames, recordings.

    Exit status: 0 captured, 1 escaped, timed out or stopped by a person, 2 bad input, 3 fault.

    Example: flightapp sim missions/demo_two_pursuers.toml --seed 3
    """
    from flightapp.recording.live import LiveView
    from flightapp.sim.session import simulate

    view = None if live is None else LiveView(live, live_address)
    result = asyncio.run(simulate(mission, profile, seed, run, certificates=certificates, secure=secure, live=view))
    if as_json:
        print(json.dumps(result.summary, indent=2))
    else:
        print(result.text())
    raise typer.Exit(result.exit_status)


@app.command(cls=_LivePort)
def fly(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    profile: Profile,
    vehicle: Annotated[str, typer.Option("--vehicle", help="Name of this vehicle in the mission.")],
    seed: Seed = 0,
    run: Annotated[Path | None, typer.Option("--run", help="Folder for the recording; default as the profile says.")] = None,
    waive: Annotated[list[str] | None, typer.Option("--waive", help="Fly although this check fails; repeatable.")] = None,
    live: Live = None,
    live_address: LiveAddress = LOOPBACK,
) -> None:
    """Fly one vehicle, real or SITL. Ctrl-C lands it.

    The deadman replaces this process and ends the vehicle process when its control loop falls silent.

    Example: flightapp fly missions/demo_two_pursuers.toml --profile profiles/nuc-pixhawk6c-d435.toml --vehicle p1
    """
    from flightapp.config.mission import load_mission
    from flightapp.config.profile import load_profile
    from flightapp.recording.run_folder import create_run_folder, given_run_folder
    from flightapp.runtime.inputs import check_inputs

    loaded, hardware = load_mission(mission), load_profile(profile)
    check_inputs(loaded, hardware, mission, profile, vehicle)
    root = hardware.recording.folder
    folder = create_run_folder(root, loaded.name) if run is None else given_run_folder(run, shared=True)
    child = ["-m", "flightapp.runtime.vehicle_process", "--mission", str(mission), "--profile", str(profile)]
    child += ["--vehicle", vehicle, "--run", str(folder), "--seed", str(seed)]
    child += [argument for check in waive or [] for argument in ("--waive", check)]
    child += [] if live is None else ["--live", str(live), "--live-address", live_address]
    sys.stdout.flush()
    os.execv(
        sys.executable,
        [
            *(sys.executable, "-m", "flightapp.runtime.deadman", str(hardware.control.deadman_timeout_s)),
            *("--autopilot", hardware.autopilot.connection_url, str(loaded.vehicle(vehicle).system_id)),
            *(sys.executable, *child),
        ],
    )


@app.command()
def preflight(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    profile: Profile,
    vehicle: Annotated[str, typer.Option("--vehicle", help="Name of this vehicle in the mission.")],
    waive: Annotated[list[str] | None, typer.Option("--waive", help="A check that may fail; repeatable.")] = None,
    wait_s: Annotated[float, typer.Option("--wait", min=0, help="Seconds to wait for what converges.")] = 60.0,
    write: Annotated[bool, typer.Option("--write-parameters", help="Write wrong parameters; asks first.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before writing.")] = False,
    as_json: Json = False,
) -> None:
    """Go through the checklist of one vehicle on the ground. Exit status 0 ready, 3 not ready.

    Example: flightapp preflight missions/demo_two_pursuers.toml --profile profiles/nuc-pixhawk6c-d435.toml --vehicle p1
    """
    from flightapp.core.line_log import LineLog
    from flightapp.preflight import table
    from flightapp.preflight.px4_parameters import Finding
    from flightapp.preflight.result import is_ready
    from flightapp.preflight.session import preflight as check

    def may_write(wrong: list[Finding]) -> bool:
        if not as_json:
            table.print_parameters(wrong)
        return yes or typer.confirm("Write these parameters to the autopilot?", err=True)

    log = LineLog.install()
    try:
        going = check(mission, profile, vehicle, waived=waive or [], wait_s=wait_s, may_write=may_write if write else None)
        results, written = asyncio.run(going)
    finally:
        log.close()
    if as_json:
        print(json.dumps(table.as_json(results, written, vehicle), indent=2))
    else:
        for line in table.written_lines(written):
            print(line)
        table.print_checklist(results, vehicle)
    raise typer.Exit(0 if is_ready(results) else 3)


@app.command()
def command(
    action: Annotated[str, typer.Argument(help="hold, resume, rtl, land or abort.")],
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    connect: Annotated[list[str], typer.Option("--connect", help="Fleet endpoint of a vehicle, udp/HOST:PORT; repeatable.")],
    vehicle: Annotated[str | None, typer.Option("--vehicle", help="Only this vehicle.")] = None,
    timeout_s: Annotated[float, typer.Option("--timeout", min=0.1, help="Seconds to wait for an answer.")] = 3.0,
    record: Annotated[Path, typer.Option("--record", help="File that keeps who asked what.")] = Path("runs/commands.jsonl"),
    certificates: Annotated[Path | None, typer.Option("--certificates", help="The operator's folder of flightapp keys.")] = None,
    as_json: Json = False,
) -> None:
    """Command the fleet; each vehicle's answer is shown as it comes. Exit status 3 when one did not accept or answer.

    Example: flightapp command land missions/demo_two_pursuers.toml --connect udp/10.0.0.1:7447 --connect udp/10.0.0.2:7447
    """
    from flightapp.config.mission import load_mission
    from flightapp.fleet.audit import as_json as for_machines
    from flightapp.fleet.command import Wish, send_command
    from flightapp.fleet.operator import Answer

    def show(answer: Answer) -> None:
        if not as_json:
            verdict = "NO ANSWER" if answer.round_trip_s is None else "accepted" if answer.accepted else "REFUSED"
            took = "" if answer.round_trip_s is None else f" ({answer.round_trip_s * 1e3:.0f} ms)"
            print(f"{answer.vehicle}: {verdict}, {answer.text}{took}", flush=True)

    wish = Wish(action, vehicle, connect, timeout_s, record, certificates)
    answers = asyncio.run(send_command(load_mission(mission), wish, show))
    if as_json:
        print(json.dumps([for_machines(answer) for answer in answers], indent=2))
    raise typer.Exit(0 if all(answer.accepted for answer in answers) else 3)


@app.command()
def watch(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    connect: Annotated[list[str], typer.Option("--connect", help="Fleet endpoint of a vehicle, udp/HOST:PORT; repeatable.")],
    certificates: Annotated[Path | None, typer.Option("--certificates", help="The operator's folder of flightapp keys.")] = None,
    profile: Annotated[Path | None, typer.Option("--profile", help="The vehicles' profile, for thresholds of colours.")] = None,
    record: Annotated[Path, typer.Option("--record", help="File that keeps who asked what.")] = Path("runs/commands.jsonl"),
    as_json: Annotated[bool, typer.Option("--json", help="One line of JSON a second; needs no terminal.")] = False,
    once: Annotated[bool, typer.Option("--once", help="Look once and end; exit status 3 when no vehicle is heard.")] = False,
) -> None:
    """Watch the fleet live, and command it by key: every command's key is pressed twice.

    Listens only: vehicles fly the same with and without it. Colours are never the only sign.

    Example: flightapp watch missions/demo_two_pursuers.toml --connect udp/10.0.0.1:7447 --connect udp/10.0.0.2:7447
    """
    from flightapp.watch.frontend_machines import as_json_line, as_text
    from flightapp.watch.session import Watch, Wish

    watching = Watch(Wish(mission, connect, record, certificates, profile))
    if once:
        overview = asyncio.run(watching.once())
        print(as_json_line(overview) if as_json else as_text(overview, watching.thresholds))
        raise typer.Exit(0 if overview.is_heard else 3)
    if as_json:
        with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):
            asyncio.run(watching.tell(lambda overview: print(as_json_line(overview), flush=True)))
        return
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise InputError("watch: this is no terminal; add --json for a line a second, or --once for one look")
    asyncio.run(watching.show())


@app.command()
def keys(
    folder: Annotated[Path, typer.Argument(help="Folder for the keys; what is there is never overwritten.")],
    mission: Annotated[Path, typer.Option("--mission", help="Mission whose fleet and vehicles get certificates.")],
    address: Annotated[
        list[str] | None, typer.Option("--address", help="NAME=HOST under which others connect to a vehicle; repeatable.")
    ] = None,
    days: Annotated[float, typer.Option("--days", min=0.1, max=365, help="Validity.")] = 14.0,
    as_json: Json = False,
) -> None:
    """Make a certificate authority, and a certificate for each vehicle and the operator, for a field day.

    A second run adds vehicles that the mission has since got. For another day make new keys in a new folder.

    Example: flightapp keys keys/today --mission missions/demo_two_pursuers.toml --address p1=10.0.0.1 --address p2=10.0.0.2
    --address e1=10.0.0.3
    """
    from flightapp.config.mission import load_mission
    from flightapp.core.clock import SystemClock
    from flightapp.fleet.security import table
    from flightapp.fleet.security.keys import KeyWish, make_keys, parse_hosts

    loaded = load_mission(mission)
    names = tuple(vehicle.name for vehicle in loaded.vehicles)
    wish = KeyWish(folder, loaded.fleet, names, parse_hosts(address or []), days)
    handed = make_keys(wish, SystemClock().now_s())
    print(json.dumps(table.as_json(wish, handed), indent=2) if as_json else table.as_text(wish, handed))


@fence.command("export")
def export_fence(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    output: Annotated[Path, typer.Argument(help="KML file to write.")],
) -> None:
    """Write fence, contingency volume, protected boundary and starts as KML.

    Example: flightapp fence export missions/demo_two_pursuers.toml /tmp/demo.kml
    """
    from flightapp.config.kml import write_kml
    from flightapp.config.mission import load_mission

    write_kml(load_mission(mission), output)


@fence.command("import")
def import_fence(
    mission: Annotated[Path, typer.Argument(help="Mission file.")],
    kml: Annotated[Path, typer.Argument(help="KML file with the flight volume as a polygon.")],
    write: Annotated[bool, typer.Option("--write", help="Replace the mission's [flight_volume] instead of printing it.")] = False,
) -> None:
    """Print the [flight_volume] of a KML file for this mission. What the file does not say stays as in the mission.

    Example: flightapp fence import missions/demo_two_pursuers.toml /tmp/demo.kml
    """
    from flightapp.config.fence_text import flight_volume_toml, replace_flight_volume
    from flightapp.config.kml import read_kml
    from flightapp.config.mission import load_mission

    loaded = load_mission(mission)
    volume = read_kml(kml, loaded.datum.as_point(), loaded.flight_volume)
    if write:
        replace_flight_volume(mission, volume)
    else:
        print(flight_volume_toml(volume), end="")


@app.command()
def report(
    run: Annotated[list[Path], typer.Argument(help="A run folder, recordings, or one log of PX4 (.ulg).")],
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--output", help="Folder for a .ulg's report; default beside the log.")] = None,
    fail_on: Annotated[
        Literal["warning", "failure"] | None,
        typer.Option("--fail-on", help="Exit with status 1 where something as bad as this was found."),
    ] = None,
    compare: Annotated[
        list[Path] | None,
        typer.Option("--compare", help="Another run, as a ghost on the map and in a table of differences; may be repeated."),
    ] = None,
    csv: Annotated[bool, typer.Option("--csv", help="Write all series on one time base too: series.csv.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="The same as series.parquet.")] = False,
) -> None:
    """Write report.html and summary.json from recordings, one or more run folders of one flight, or one log of PX4.

    Exit status: 0 the report is written, whatever was found; 1 with --fail-on; 2 bad input.

    Example: flightapp report runs/20260601-101500-demo_two_pursuers --compare runs/20260601-103000-demo_two_pursuers --csv
    """
    from flightapp.analysis import report as write
    from flightapp.analysis.findings import reaches
    from flightapp.analysis.ulog.command import log_among, report_log

    if (flight := log_among(run, output)) is not None:
        if compare or csv or parquet:
            raise InputError("--compare, --csv and --parquet are for recordings (.mcap), not for a log of PX4")
        told = report_log(flight, output)
        print(json.dumps(told.summary, indent=2) if as_json else told.text())
        raise typer.Exit(1 if reaches(told.summary, fail_on) else 0)
    summary, page = write(run, compare=compare or (), as_csv=csv, as_parquet=parquet)
    short = f"outcome: {summary['outcome']}\nverdict: {summary['headline']}\nreport:  {page}"
    print(json.dumps(summary, indent=2) if as_json else short)
    raise typer.Exit(1 if reaches(summary, fail_on) else 0)


@app.command()
def replay(
    run: Annotated[Path, typer.Argument(help="A run folder, or one recording.")],
    vehicle: Annotated[str | None, typer.Option("--vehicle", help="Only this vehicle.")] = None,
    planner: Annotated[str | None, typer.Option("--planner", help="Ask this planner instead of the one that flew.")] = None,
    parameters: Annotated[Path | None, typer.Option("--parameters", help="Parameter file, on top of what flew.")] = None,
    tolerance: Annotated[float, typer.Option("--tolerance", min=0.0, help="Smaller differences are none.")] = 0.0,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="JSON file for every single difference.")] = None,
) -> None:
    """Decide a recorded flight again: exactly what planner and supervisor were given then, through today's code, in lock step.

    With --planner or --parameters: what that would have decided there, open loop.

    Exit status: 0 identical, 1 something is decided differently, 2 bad input.

    Example: flightapp replay runs/20260601-101500-demo_two_pursuers --planner geo-apf --vehicle p1
    """
    from flightapp.replay import Wanted
    from flightapp.replay import replay as decide_again

    answer = decide_again(Wanted(run, vehicle, planner, parameters, tolerance))
    if output is not None:
        answer.write(output)
    print(json.dumps(answer.summary(), indent=2) if as_json else answer.text())
    raise typer.Exit(0 if answer.identical else 1)


@app.command()
def explain(
    conditions: Annotated[str, typer.Option("--set", help="Conditions that hold: NAME=1, separated by commas.")] = "",
    after_s: Annotated[float, typer.Option("--after", min=0, help="For how many seconds they have held.")] = 60.0,
    as_json: Json = False,
) -> None:
    """Which failsafe wins and why: the real table, asked.

    Example: flightapp explain --set link_lost=1,battery_low=1 --after 2
    """
    from flightapp.safety.failsafe import print_out
    from flightapp.safety.failsafe.explain import explain as ask
    from flightapp.safety.failsafe.explain import parse_conditions

    found = ask(parse_conditions(conditions), after_s)
    if as_json:
        print(json.dumps(print_out.as_json(found), indent=2))
    else:
        print_out.print_explanation(found)


@app.command()
def recover(
    file: Annotated[Path, typer.Argument(help="A recording that was cut off or damaged.")],
    output: Annotated[Path | None, typer.Option("--output", help="File to write; default FILE with -recovered.")] = None,
    as_json: Json = False,
) -> None:
    """Make a normal recording from one that was cut off or damaged, and say what could not be saved.

    Example: flightapp recover runs/20260601-101500-demo_two_pursuers/p1.mcap
    """
    from flightapp.recording.recover import recover as recover_file

    target = output or file.with_name(f"{file.stem}-recovered.mcap")
    found = recover_file(file, target)
    if as_json:
        told = {"file": str(found.output), "messages": found.messages, "span_s": found.span_s}
        print(json.dumps({**told, "complete": found.was_complete, "note": found.note}))
    else:
        print(f"{found.output}: {found.messages} messages over {found.span_s:.1f} s")
        if found.note:
            print(f"{file}: {found.note}")


@app.command()
def bundle(
    run: Annotated[Path, typer.Argument(help="A run folder.")],
    output: Annotated[Path | None, typer.Option("--output", help="File to write; default RUN-bundle.zip beside the run.")] = None,
    full: Annotated[bool, typer.Option("--full", help="Whole recordings with images, not two messages a second.")] = False,
    as_json: Json = False,
) -> None:
    """Put a run into one file to send when asking for help, without keys, passwords, names and serial numbers.

    Example: flightapp bundle runs/20260601-101500-demo_two_pursuers
    """
    from flightapp.bundle import write_bundle

    written = write_bundle(run, output, full=full)
    print(json.dumps(written.as_json(), indent=2) if as_json else written.text())


class _WithDefault(TyperGroup):
    """Whatever does not begin with the name of one of its commands goes to `default`."""

    default: str

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        known = bool(args) and (args[0] in self.commands or args[0] == "--help")
        return super().parse_args(ctx, args if known else [self.default, *args])


class _SpeedByDefault(_WithDefault):
    default = "speed"


bench_app = typer.Typer(
    cls=_SpeedByDefault, help="Measure speed (the default), perception or the target filter.", rich_markup_mode=None
)
app.add_typer(bench_app, name="bench")


@bench_app.command()
def speed(
    mission: Annotated[Path, typer.Argument(help="Mission whose obstacles the camera sees.")] = DEMO_MISSION,
    profile: Profile = SIM_PROFILE,
    scenario: Annotated[Path, typer.Option("--scenario", help="Scenario that the fast simulator flies.")] = DENSE_SCENARIO,
    seconds: Annotated[float, typer.Option("--seconds", min=0.1, help="About how long to measure times and rates.")] = 20.0,
    steps: Annotated[int, typer.Option("--steps", min=200, help="Decisions over which memory is watched.")] = 20_000,
    as_json: Json = False,
) -> None:
    """Measure planner, perception, supervisor, recorder, fleet messages, fast simulator and memory on this machine.

    Wall and CPU time, both, so that a busy machine can be told from slow code.

    Example: flightapp bench --seconds 10 --steps 1000000
    """
    from flightapp.bench import run_bench
    from flightapp.bench.table import print_bench

    result = run_bench(mission, profile, scenario, seconds, steps)
    if as_json:
        print(json.dumps(result, indent=2))
    else:
        print_bench(result)


@bench_app.command()
def perception(
    profile: Profile = SIM_PROFILE,
    seed: Seed = 0,
    quick: Annotated[bool, typer.Option("--quick", help="A few trials of each kind.")] = False,
    as_json: Json = False,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the picture.")] = None,
) -> None:
    """Hold perception against rendered scenes that are known exactly: what it finds, what it invents, what it misses.

    With the camera and the perception parameters of the profile. Missed aims are said, they are no error.

    Example: flightapp bench perception --out truth
    """
    from flightapp.bench.perception_truth import run_perception_truth
    from flightapp.bench.perception_truth.table import print_perception

    result = run_perception_truth(profile, seed, quick, out)
    if as_json:
        print(json.dumps(result, indent=2))
    else:
        print_perception(result)


@bench_app.command()
def tracking(
    tracks: Annotated[
        list[Path], typer.Argument(help="Recorded flights: lines timestamp,x,y,z,... in s and m, z up, one header.")
    ],
    seed: Seed = 0,
    slowed: Annotated[float, typer.Option("--slowed", min=0.1, max=20.0, help="Flown so many times slower.")] = 1.0,
    as_json: Json = False,
) -> None:
    """Hold the target filter against recorded flights, with loss, delay, sighting noise and occlusions, and measure its cost.

    Beside it stands the constant-velocity filter. Racing drones are the hardest evaders; --slowed 3 is nearer to a field test.

    Example: flightapp bench tracking tests/estimation/data/fpv_race_10hz.csv
    """
    from flightapp.bench.tracking import print_tracking, run_tracking

    result = run_tracking(tracks, seed, slowed)
    if as_json:
        print(json.dumps(result, indent=2))
    else:
        print_tracking(result)


Scenario = Annotated[Path, typer.Argument(help="Scenario file.")]
Set = Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a field of the scenario; repeatable.")]
Parameters = Annotated[Path | None, typer.Option("--parameters", help="Planner-parameter file, on top of the scenario's.")]
WorkerCount = Annotated[int | None, typer.Option("--workers", help="Worker processes; default all local cores.")]
Backend = Annotated[str, typer.Option("--backend", help="local, dask or ray (extras of the same names).")]


class _PlannersByDefault(_WithDefault):
    default = "planners"


campaign_app = typer.Typer(
    cls=_PlannersByDefault,
    help="Many missions: compare planners on a SCENARIO (the default) or in all of them, inject faults, worsen the network;"
    " studies of path planners, controllers and potential fields beside their papers.",
    rich_markup_mode=None,
)
app.add_typer(campaign_app, name="campaign")


@campaign_app.command("planners")
def campaign(
    scenario: Scenario,
    planner: Annotated[
        list[str] | None, typer.Option("--planner", help="Planner to fly; repeatable, the first is compared with.")
    ] = None,
    seeds: Annotated[str | None, typer.Option("--seeds", help="17, 0-999 or 3,5,20-29: the same for every planner.")] = None,
    workers: WorkerCount = None,
    as_json: Json = False,
    changes: Set = None,
    parameters: Parameters = None,
    backend: Backend = "local",
    output: Annotated[Path | None, typer.Option("--output", help="New folder; default campaigns/TIME-SCENARIO.")] = None,
    record: Annotated[bool, typer.Option("--record", help="Record every run as MCAP, for flightapp report.")] = False,
    draw: Annotated[
        str | None, typer.Option("--draw", help="none, failed:N or seeds; default the first seed and failed:3.")
    ] = None,
) -> None:
    """Fly planners on the same seeds of a scenario, faster than real time, and compare them with statistics and pictures.

    Planners and seeds that are not given are those of the scenario's [campaign].

    Exit status: 0 finished, 2 bad input, 3 fault, 130 stopped by a person; what was finished by then is written.

    Example: flightapp campaign missions/scenarios/a2-dense.toml --planner geo-apf --planner ac2f --seeds 0-999
    """
    from flightapp.analysis.campaign.campaign import RECORDINGS, Campaign, run_campaign
    from flightapp.analysis.campaign.drawing import parse_drawing
    from flightapp.analysis.campaign.question import load_question, planners_and_seeds
    from flightapp.analysis.campaign.workers import Workers

    loaded, given = load_question(scenario, changes or [], parameters)
    planners, chosen = planners_and_seeds(scenario, loaded, planner or [], seeds)
    question = Campaign(loaded, planners, chosen, given, parse_drawing(draw, chosen), record)
    finished = run_campaign(question, Workers(workers, backend), output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print(finished.table)
        print(f"files:  {finished.folder}")
        if record and finished.complete:
            print(f"report: flightapp report {finished.folder / RECORDINGS}/PLANNER-SEED")
    raise typer.Exit(0 if finished.complete else INTERRUPTED)


@campaign_app.command("all")
def campaign_all(
    grid: Annotated[Path, typer.Argument(help="File that names planners, scenarios and seeds.")],
    seeds: Annotated[str | None, typer.Option("--seeds", help="17, 0-19 or 3,5,20-29; default the file's.")] = None,
    planner: Annotated[list[str] | None, typer.Option("--planner", help="Only this planner; repeatable.")] = None,
    scenario: Annotated[list[str] | None, typer.Option("--scenario", help="Only this scenario; repeatable.")] = None,
    again: Annotated[
        list[str] | None, typer.Option("--again", help="Planner or scenario whose episodes are flown again; repeatable.")
    ] = None,
    show: Annotated[bool, typer.Option("--show", help="Fly nothing: the table of what is there.")] = False,
    workers: WorkerCount = None,
    as_json: Json = False,
    output: Annotated[Path, typer.Option("--output", help="Folder of the episodes and the table.")] = Path("campaigns/all"),
) -> None:
    """Fly all planners in all scenarios, seed by seed, and write one table: Markdown, HTML, CSV and JSON.

    Every episode is kept as it ends: the same command goes on where a run was cut, and with more --seeds it adds to it.

    Exit status: 0 all flown, 2 bad input, 3 fault, 130 stopped by a person.

    Example: flightapp campaign all missions/tables/everything.toml --seeds 0-19
    """
    from flightapp.analysis.campaign.everything.campaign import fly_everything, show_everything
    from flightapp.analysis.campaign.everything.grid import load_grid
    from flightapp.analysis.campaign.workers import Workers

    loaded = load_grid(grid, planner or [], scenario or [], seeds)
    table = show_everything(loaded, output) if show else fly_everything(loaded, output, Workers(workers), again or [])
    if as_json:
        print(json.dumps({"complete": table.complete, "older": table.older, "figures": table.figures}, indent=2))
    else:
        print(table.markdown)
        for name, count in table.older.items():
            print(f"{name}: {count} episodes by an older version of it; --again {name} flies them again")
        print(f"{table.episodes} of {table.wanted} episodes; files: {table.folder}")
    raise typer.Exit(0 if table.complete or show else INTERRUPTED)


@campaign_app.command("faults")
def fault_campaign(
    seeds: Annotated[
        str, typer.Option("--seeds", help="17, 0-199 or 3,5,20-29; a seed gives the same mission every time.")
    ] = "0-199",
    workers: WorkerCount = None,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="New folder; default campaigns/TIME-faults.")] = None,
    mission: Annotated[
        Path | None, typer.Option("--mission", help="Fly this mission as it is; default variants of the demo mission.")
    ] = None,
    profile: Profile = SIM_PROFILE,
) -> None:
    """Fly whole missions on a virtual clock, inject random faults at random moments, and check what must always hold.

    The recordings of missions in which something did not hold stay in the folder.

    Exit status: 0 everything held, 1 something did not, 2 bad input, 3 fault, 130 stopped by a person.

    Example: flightapp campaign faults --seeds 0-199
    """
    from flightapp.analysis.campaign.seeds import parse_seeds
    from flightapp.analysis.campaign.workers import Workers
    from flightapp.sim.fault_campaign.campaign import FaultCampaign, run_fault_campaign
    from flightapp.sim.fault_campaign.table import print_fault_campaign

    question = FaultCampaign(mission or DEMO_MISSION, profile, parse_seeds(seeds), varies=mission is None)
    finished = run_fault_campaign(question, Workers(workers), output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print_fault_campaign(finished)
    raise typer.Exit((0 if finished.is_clean else 1) if finished.complete else INTERRUPTED)


@campaign_app.command("network")
def network_campaign(
    seeds: Annotated[str, typer.Option("--seeds", help="17, 0-9 or 3,5,20-29: the same over every kind of network.")] = "0-9",
    delays_ms: Annotated[str, typer.Option("--delays-ms", help="Of a packet, +- half of it; several with commas.")] = "5,100,200",
    losses: Annotated[str, typer.Option("--losses", help="Per cent of the packets; several with commas.")] = "0,10,30",
    partitions: Annotated[
        str, typer.Option("--partitions", help="none, one, halves: the first on the whole grid, the others at its ends.")
    ] = "none,one,halves",
    real: Annotated[int, typer.Option("--real", min=0, help="So many conditions are flown by real processes as well.")] = 0,
    proxy: Annotated[bool, typer.Option("--proxy", help="These through a proxy, also where namespaces are possible.")] = False,
    workers: WorkerCount = None,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="New folder; default campaigns/TIME-network.")] = None,
    mission: Annotated[Path, typer.Option("--mission", help="The pursuit that is flown.")] = NETWORK_MISSION,
    profile: Profile = SIM_PROFILE,
) -> None:
    """Fly a pursuit over networks that are slow, lossy or split for a while: on a virtual clock, and by real processes.

    Writes table.csv, table.md, network.png and missions.json. Recordings of what must not happen stay in the folder.

    Exit status: 0 everything held, 1 something did not, 2 bad input, 3 fault, 130 stopped by a person.

    Example: flightapp campaign network --seeds 0-9 --real 2
    """
    from flightapp.analysis.campaign.seeds import parse_seeds
    from flightapp.analysis.campaign.workers import Workers
    from flightapp.sim.network_campaign.campaign import NetworkCampaign, run_network_campaign
    from flightapp.sim.network_campaign.conditions import parse_grid
    from flightapp.sim.network_campaign.terminal import print_network_campaign

    grid = parse_grid(delays_ms, losses, partitions)
    question = NetworkCampaign(mission, profile, grid, parse_seeds(seeds), real, proxy)
    finished = run_network_campaign(question, Workers(workers), output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print_network_campaign(finished)
    raise typer.Exit((0 if finished.is_clean else 1) if finished.complete else INTERRUPTED)


@campaign_app.command("paths")
def path_campaign(
    seeds: Annotated[str, typer.Option("--seeds", help="Of the random scenes: 17, 0-99 or 3,5,20-29.")] = "0-99",
    planner: Annotated[
        list[str] | None, typer.Option("--planner", help="Path planner; repeatable, default all that are installed.")
    ] = None,
    obstacles: Annotated[int, typer.Option("--obstacles", help="In each random scene, 0 to 25; the paper has 17.")] = 17,
    iterations: Annotated[int, typer.Option("--iterations", min=1, help="Of the own planners.")] = 5000,
    peers_s: Annotated[float, typer.Option("--peers-s", min=0.001, help="CPU time of each of OMPL's planners.")] = 0.1,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="New folder; default campaigns/TIME-paths.")] = None,
) -> None:
    """Plan ways in three dimensions on the scenes of the RRT*-APF paper and on random ones, and compare the planners.

    Success, length, clearance, time, and whether a vehicle with limits and lag can fly the way. Writes table.md, trials.json
    and a picture for each of the paper's three ways.

    Exit status: 0 finished, 2 bad input, 3 fault.

    Example: flightapp campaign paths --seeds 0-99 --planner rrt-star-apf --planner ompl-aorrtc
    """
    from flightapp.analysis.campaign.seeds import parse_seeds
    from flightapp.analysis.path_study.study import Study, installed_planners, run_study

    question = Study(tuple(planner or installed_planners()), parse_seeds(seeds), obstacles, iterations, peers_s)
    finished = run_study(question, output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print(finished.table)
        print(f"files:  {finished.folder}")


@campaign_app.command("control")
def control_study(
    seeds: Annotated[str, typer.Option("--seeds", help="17, 0-99 or 3,5,20-29: a scene, its wind and its path each.")] = "0-99",
    way: Annotated[str, typer.Option("--way", help="level, descent or climb: start and goal of figures 13, 14 or 15.")] = "level",
    all_settings: Annotated[
        bool, typer.Option("--all-settings", help="All five rows of table 1; else 17 obstacles and steps of 2 m.")
    ] = False,
    method: Annotated[list[str] | None, typer.Option("--method", help='As "hybrid tuned"; repeatable, default all.')] = None,
    workers: WorkerCount = None,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="New folder; default campaigns/TIME-control.")] = None,
) -> None:
    """Fly a formation of five through obstacles in wind, with every controller and its printed and re-derived gains.

    On the source's ideal double integrator at 1 kHz, and at 50 Hz with the lag and delay of a vehicle under PX4. Writes
    tables.md and control.json: tables 1 and 2 and the figures of the source beside ours; control.png (figures 6 to 18),
    tracking.png and formation.png of the first scene.

    Exit status: 0 the acceptance is met, 1 it is not, 2 bad input, 3 fault, 130 stopped by a person.

    Example: flightapp campaign control --seeds 0-99
    """
    from flightapp.analysis.campaign.seeds import parse_seeds
    from flightapp.analysis.campaign.workers import Workers
    from flightapp.sim.control_study.campaign import ControlStudy, run_control_study, study_methods, study_settings
    from flightapp.sim.control_study.terminal import print_control_study

    study = ControlStudy(parse_seeds(seeds), study_settings(way, not all_settings), study_methods(method or []))
    finished = run_control_study(study, Workers(workers), output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print_control_study(finished)
    raise typer.Exit((0 if finished.acceptance.accepted else 1) if finished.complete else INTERRUPTED)


@campaign_app.command("apf")
def field_study(
    seeds: Annotated[str, typer.Option("--seeds", help="Of the random scenes: 17, 0-999 or 3,5,20-29.")] = "0-999",
    method: Annotated[list[str] | None, typer.Option("--method", help='As "APF+A"; repeatable, default all.')] = None,
    step_m: Annotated[float, typer.Option("--step-m", help="Of the vehicle in the random scenes; 0.02 is printed.")] = 0.0325,
    literal: Annotated[
        bool, typer.Option("--literal", help="Attraction and goal factor without bounds, return by zones: as printed.")
    ] = False,
    as_json: Json = False,
    output: Annotated[Path | None, typer.Option("--out", help="New folder; default campaigns/TIME-apf.")] = None,
) -> None:
    """Fly the scenes of the adaptive potential field's paper, and its ablation over random scenes with moving obstacles.

    In three dimensions and by the source's own fixed steps. IAPF-style and GWO-APF first search their gains on other scenes.
    Writes table.md, with the printed tables beside, scenes.png and apf.json.

    Exit status: 0 finished, 2 bad input, 3 fault.

    Example: flightapp campaign apf --seeds 0-999
    """
    from flightapp.analysis.campaign.seeds import parse_seeds
    from flightapp.sim.field_study.methods import METHODS
    from flightapp.sim.field_study.study import FieldStudy, run_field_study

    finished = run_field_study(FieldStudy(parse_seeds(seeds), tuple(method or METHODS), step_m, literal), output)
    if as_json:
        print(json.dumps(finished.summary, indent=2))
    else:
        print(finished.table)
        print(f"files:  {finished.folder}")


@app.command()
def tune(
    scenario: Scenario,
    planner: Annotated[str, typer.Option("--planner", help="Planner whose fine weights are tuned.")] = "ac2f",
    evaluations: Annotated[int, typer.Option("--evaluations", min=0, help="Evaluations after the initial ones.")] = 200,
    initial: Annotated[int, typer.Option("--initial", min=2, help="Latin-hypercube samples to begin with.")] = 20,
    batch: Annotated[int, typer.Option("--batch", min=1, help="Runs an evaluation, always on the same seeds.")] = 20,
    seeds: Annotated[str, typer.Option("--seeds", help="Where the batch's seeds are taken from, at least 10000.")] = "10000-",
    seed: Seed = 0,
    workers: WorkerCount = None,
    as_json: Json = False,
    changes: Set = None,
    parameters: Parameters = None,
    backend: Backend = "local",
    output: Annotated[
        Path | None, typer.Option("--output", help="Parameter file to write; default campaigns/tune-SCENARIO.toml.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint beside the output.")] = False,
) -> None:
    """Find the weights of the fine stage by Bayesian optimisation, and write them as a planner-parameter file.

    Beside the file stand its checkpoint (.jsonl) and the picture of the response surface (.png). Exit status as of campaign.

    Example: flightapp tune missions/scenarios/a2-dense.toml --evaluations 500 --batch 50
    """
    from flightapp.analysis.campaign.question import load_question
    from flightapp.analysis.campaign.seeds import parse_batch
    from flightapp.analysis.campaign.workers import Workers
    from flightapp.analysis.tuning.tune import Problem
    from flightapp.analysis.tuning.tuning_run import run_tuning

    loaded, given = load_question(scenario, changes or [], parameters)
    problem = Problem(loaded, planner, parse_batch(seeds, batch), given, initial, seed)
    finished = run_tuning(problem, evaluations, Workers(workers, backend), output, _command_line(), again=resume)
    print(json.dumps(finished.summary, indent=2) if as_json else finished.text())
    raise typer.Exit(0 if finished.complete else INTERRUPTED)


INTERRUPTED = 130
"""Exit status after Ctrl-C, as of a shell."""


def _command_line() -> str:
    return shlex.join(["flightapp", *sys.argv[1:]])


def main() -> None:
    """Entry point: one sentence instead of a traceback for everything a user can cause."""
    try:
        app()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    except FlightError as error:
        print(error, file=sys.stderr)
        sys.exit(3)
