"""A bundle holds what it takes to help, and nothing secret, wherever a secret was put."""

from __future__ import annotations

import hashlib
import json
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Message
from mcap.writer import Writer
from typer.testing import CliRunner

from flightapp.bundle import write_bundle
from flightapp.bundle.redaction import MARK, Redactor
from flightapp.cli import app
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan
from tests.analysis.ulog.flights import clean_flight

USER, HOST = "mmustermann", "drohne-nuc-17"
KEY = "-----BEGIN PRIVATE KEY-----\nMIIEvQIBADANBgkqhkiG9w0\nc2VjcmV0IG1hdGVyaWFs\n-----END PRIVATE KEY-----"
SECRETS = {
    "password": "hunter2-Geheim",
    "token": "tok_93kd82hdk2",
    "api key": "9f8e7d6c5b4a",
    "user": USER,
    "host": HOST,
    "other user": "erikaflieger",
    "key": "MIIEvQIBADANBgkqhkiG9w0",
    "serial": "FTAB12CDX",
    "uuid": "0006000000003736323032335111002f",
    "mac": "3c:52:82:aa:bb:cc",
    "mail": "max@example.org",
    "url login": "pilot:s3cr3tpw",
    "public address": "8.8.4.4",
    "jwt": "eyJhbGciOiJIUzI1NiJ9.eyJzdWIiOiIxMjM0In0.c2lnbmF0dXJl",
    "wifi": "TeamNetz5G",
}
LINES = [
    f'password = "{SECRETS["password"]}"',
    f"Authorization: Bearer {SECRETS['token']}",
    f"api_key: '{SECRETS['api key']}'",
    f"12:00:01 [p1] recording: /home/{USER}/runs/x",
    f"login from {USER} on {HOST}",
    f"config read from /home/{SECRETS['other user']}/flight.toml",
    f"hello {SECRETS['other user']}",
    KEY,
    f"camera serial_number={SECRETS['serial']}",
    f"port /dev/serial/by-id/usb-FTDI_FT232R_{SECRETS['serial']}-if00-port0",
    f"sys_uuid: {SECRETS['uuid']}",
    f"wlan0 {SECRETS['mac']}",
    f"ssid = {SECRETS['wifi']}",
    f"contact {SECRETS['mail']}",
    f'url = "rtsp://{SECRETS["url login"]}@10.0.0.5/stream"',
    f"ntp server {SECRETS['public address']}",
    f"cookie {SECRETS['jwt']}",
]
NEEDED = 'connection_url = "serial:///dev/ttyUSB0:921600"\nlisten = "udp/192.168.4.7:7447"\nlatitude_deg = 47.3977\n'


def planted_run(folder: Path) -> Path:
    """Every secret in every kind of input."""
    folder.mkdir()
    text = "\n".join(LINES)
    for name in ("mission.toml", "profile-p1.toml", "planner.params", "p1.log", "notes.txt"):
        (folder / name).write_text(f"{NEEDED}{text}\n")
    (folder / "p1-autopilot.jsonl").write_text("".join(json.dumps({"t_s": 1.0, "text": line}) + "\n" for line in LINES))
    (folder / "run.json").write_text(
        json.dumps({"mission": "demo", "settings": {"password": SECRETS["password"]}, "lines": LINES})
    )
    (folder / f"{USER}.log").write_text("fine\n")
    for name in ("operator.pem", "p1.key", "ca.crt"):
        (folder / name).write_text(KEY)
    (folder / "core.dump").write_bytes(b"\x00" + text.encode())
    (folder / "report.html").write_text(text)
    write_recording(folder / "p1.mcap")
    log = clean_flight()
    log.information |= {"sys_uuid": SECRETS["uuid"], "boot": f"host_name={HOST}"}
    log.messages += [(20.0 + number, 6, line) for number, line in enumerate(LINES)]
    log.write(folder / "p1.ulg")
    return folder


def write_recording(path: Path) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile=FILE_PROFILE, library="test")
        writer.add_metadata(
            "run", {"vehicle": "p1", "hostname": HOST, "password": SECRETS["password"], "folder": f"/home/{USER}/x"}
        )
        writer.add_attachment(0, 0, "profile.toml", "text/plain", "\n".join(LINES).encode())
        schema = writer.register_schema("X", "jsonschema", b"{}")
        events = writer.register_channel("/event", "json", schema)
        own = writer.register_channel("/own", "json", schema)
        binary = writer.register_channel("/log", "protobuf", schema)
        for number, line in enumerate(LINES):
            name = "preflight" if number % 2 else "note"
            event = {"t_s": float(number), "level": "info", "name": name, "text": line, "data": {"token": SECRETS["token"]}}
            writer.add_message(events, number * 10**6, json.dumps(event).encode(), number * 10**6)
        for number in range(500):
            state = {"t_s": 0.02 * number, "position_ned_m": [number * 1.5, 2.25, -3.0]}
            writer.add_message(own, number * 20_000_000, json.dumps(state).encode(), number * 20_000_000)
        writer.add_message(binary, 0, b"\x0a\x20\x00" + LINES[3].encode(), 0)
        writer.add_message(binary, 10**9, b"\x0a\x20\x00harmless words", 10**9)
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.fixture(scope="module")
def bundled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bundle")
    return write_bundle(planted_run(folder / "run"), names={USER, HOST}).path


def contents(bundle: Path, scratch: Path) -> dict[str, bytes]:
    """Every file of the bundle; recordings with their chunks unpacked, as anyone can."""
    found: dict[str, bytes] = {}
    with zipfile.ZipFile(bundle) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            if name.endswith(".mcap"):
                path = scratch / name
                path.write_bytes(data)
                data += b"".join(repr(record).encode() for record in Scan(path))
            found[name] = data
    return found


@pytest.mark.parametrize("full", [False, True])
def test_no_planted_secret_is_in_any_file_of_the_bundle(tmp_path: Path, full: bool) -> None:
    run = planted_run(tmp_path / "run")
    files = contents(write_bundle(run, tmp_path / "out.zip", full=full, names={USER, HOST}).path, tmp_path)
    leaks = {(name, what) for name, data in files.items() for what, secret in SECRETS.items() if secret.encode() in data}
    names = {(name, what) for name in files for what, secret in SECRETS.items() if secret in name}
    assert leaks | names == set()
    assert {"mission.toml", "profile-p1.toml", "p1.log", "p1.mcap", "p1.ulg", "versions.json", "preflight.json"} <= set(files)


def test_keys_certificates_and_what_cannot_be_checked_stay_behind_and_that_is_said(bundled: Path) -> None:
    with zipfile.ZipFile(bundled) as archive:
        manifest = json.loads(archive.read("manifest.json"))
    reasons = {entry["file"]: entry["reason"] for entry in manifest["left_out"]}
    assert reasons["p1.key"] == reasons["operator.pem"] == reasons["ca.crt"] == "a key or certificate"
    assert "cannot be checked" in reasons["core.dump"]
    assert "report.html" in reasons


def test_what_it_takes_to_help_is_kept(bundled: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(bundled) as archive:
        assert archive.read("mission.toml").decode().startswith(NEEDED)
        archive.extract("p1.mcap", tmp_path)
        versions = json.loads(archive.read("versions.json"))
        preflight = json.loads(archive.read("preflight.json"))
    recording = read_recording(tmp_path / "p1.mcap")
    assert len(recording.topic("/event")) == len(LINES)
    assert 15 <= len(recording.topic("/own")) <= 25
    assert recording.topic("/own").messages[1]["position_ned_m"] == [37.5, 2.25, -3.0]
    assert versions["packages"]["numpy"]
    assert len(preflight["p1"]) == len(LINES) // 2


def test_the_whole_recording_is_sent_when_asked_for(tmp_path: Path) -> None:
    path = write_bundle(planted_run(tmp_path / "run"), tmp_path / "full.zip", full=True, names={USER, HOST}).path
    with zipfile.ZipFile(path) as archive:
        archive.extract("p1.mcap", tmp_path)
    messages = [record for record in Scan(tmp_path / "p1.mcap") if isinstance(record, Message)]
    assert len(messages) == len(LINES) + 500 + 1


def test_the_log_of_the_autopilot_is_still_a_log(bundled: Path, tmp_path: Path) -> None:
    from flightapp.analysis.ulog.log import load_log

    with zipfile.ZipFile(bundled) as archive:
        archive.extract("p1.ulg", tmp_path)
    log = load_log(tmp_path / "p1.ulg")
    battery = log.topic("battery_status")
    assert battery is not None
    assert len(battery) == pytest.approx(120, abs=2)
    assert battery.column("voltage_v") is not None
    assert log.information["sys_uuid"] == "*" * len(SECRETS["uuid"])


def test_the_manifest_tells_size_and_checksum_of_every_file(bundled: Path) -> None:
    with zipfile.ZipFile(bundled) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        listed = {entry["file"]: entry for entry in manifest["files"]}
        assert set(listed) == set(archive.namelist()) - {"manifest.json"}
        for name, entry in listed.items():
            data = archive.read(name)
            assert entry["bytes"] == len(data)
            assert entry["sha256"] == hashlib.sha256(data).hexdigest()


def test_nothing_is_overwritten_and_nothing_half_written_stays(tmp_path: Path) -> None:
    run = planted_run(tmp_path / "run")
    (tmp_path / "out.zip").write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        write_bundle(run, tmp_path / "out.zip")
    assert (tmp_path / "out.zip").read_text() == "mine"
    with pytest.raises(InputError, match="cannot be written"):
        write_bundle(run, tmp_path / "nowhere" / "out.zip")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.zip", "run"]


def test_a_run_that_was_cut_off_is_bundled_with_what_there_is(tmp_path: Path) -> None:
    run = planted_run(tmp_path / "run")
    whole = (run / "p1.mcap").read_bytes()
    (run / "p1.mcap").write_bytes(whole[: 2 * len(whole) // 3])
    (run / "p2.mcap").write_bytes(b"")
    (run / "p1.ulg").write_bytes((run / "p1.ulg").read_bytes()[:200_000])
    bundle = write_bundle(run, tmp_path / "out.zip", names={USER, HOST})
    with zipfile.ZipFile(bundle.path) as archive:
        listed = {entry["file"]: entry for entry in json.loads(archive.read("manifest.json"))["files"]}
        assert json.loads(archive.read("summary.json"))
    assert listed["p1.mcap"]["was_complete"] is False
    assert listed["p1.ulg"]["samples"] > 0
    assert "empty" in dict(bundle.left_out)["p2.mcap"]


@pytest.mark.parametrize(("arguments", "wanted"), [(["none"], "no such run folder"), (["empty"], "nothing in this folder")])
def test_what_is_no_run_is_one_sentence(tmp_path: Path, arguments: list[str], wanted: str) -> None:
    (tmp_path / "empty").mkdir()
    done = CliRunner().invoke(app, ["bundle", str(tmp_path / arguments[0])])
    assert wanted in str(done.exception)


def test_the_command_line_says_what_it_wrote(tmp_path: Path) -> None:
    run = planted_run(tmp_path / "run")
    done = CliRunner().invoke(app, ["bundle", str(run), "--json"])
    assert done.exit_code == 0
    told = json.loads(done.output)
    assert told["bundle"] == str(tmp_path / "run-bundle.zip")
    assert sum(told["redacted"].values()) > 50
    assert Path(told["bundle"]).stat().st_size == told["bytes"]


VALUES = st.text("abcdefghijkmnpqrstuvwxyz23456789", min_size=6, max_size=20).map(lambda text: f"Zq{text}")


@given(
    value=VALUES,
    key=st.sampled_from(["password", "wifi_password", "API_KEY", "auth_token", "secret", "serial_number", "hostname"]),
    form=st.sampled_from(
        ["{0} = {1}", '{0} = "{1}"', "{0}='{1}'", '{{"{0}": "{1}"}}', "{0}: {1}", '{0} = ["x", "{1}"]', '{0} = """{1}"""']
    ),
    around=st.text("abc xyz_/\n\"'", max_size=10),
)
def test_a_value_whose_key_is_secret_goes_in_every_way_of_writing_it(value: str, key: str, form: str, around: str) -> None:
    text = Redactor().text(f"\n{form.format(key, value)}\n{around}")
    assert value not in text
    assert MARK in text


@given(st.text(max_size=200))
def test_redacting_twice_is_redacting_once(text: str) -> None:
    redactor = Redactor({USER})
    assert redactor.text(redactor.text(text)) == redactor.text(text)


@pytest.mark.parametrize(
    "text",
    [
        "position_ned_m = [12.5, 3.0, -4.25]",
        'connection_url = "serial:///dev/ttyUSB0:921600"',
        'connection_url = "udpin://127.0.0.1:30128"',
        "udp/192.168.1.20:7447",
        "commit 62f217d1f0a2b3c4d5e6f708192a3b4c5d6e7f80",
        "sha256 " + "0a" * 32,
        "opencv-python-headless==5.0.0.93 is a version, as is 1.16.1",
        "12:00:01.123 [p1] preflight: MPC_ACC_HOR warning: 3, wanted at least 5 m/s2",
        '{"t_s": 1795347064.17, "name": "phase", "level": "info", "nav_state_user_intention": 14}',
        "keyboard monkey tokyo authority host",
    ],
)
def test_what_helps_and_harms_nobody_stays(text: str) -> None:
    assert Redactor({USER, HOST}).text(text) == text
