"""`flightapp keys`: what a field team gets, and what is said when something is wrong with it."""

from __future__ import annotations

import json
import shutil
import time
from ipaddress import ip_address
from pathlib import Path

import pytest
from cryptography.x509 import DNSName, IPAddress
from cryptography.x509.verification import PolicyBuilder, Store
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.config.mission import load_mission
from flightapp.config.profile import Network, load_profile
from flightapp.core.errors import InputError
from flightapp.fleet.security.credentials import load_credentials, read_certificate
from flightapp.fleet.security.keys import KeyWish, make_keys, parse_hosts
from flightapp.sim.fleet_files import prepare

ROOT = Path(__file__).parents[3]
DEMO = ROOT / "missions/demo_two_pursuers.toml"
ADDRESSES = [part for name in ("p1", "p2", "e1") for part in ("--address", f"{name}=10.0.0.{name[-1]}")]
DAY_S = 86400.0


def wish(folder: Path, *vehicles: str, days: float = 14.0) -> KeyWish:
    return KeyWish(folder, "f", vehicles, dict.fromkeys(vehicles, ("10.0.0.1", "p.local")), days)


def content(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_each_machine_gets_one_folder_that_verifies_and_only_its_owner_reads_the_key(tmp_path: Path) -> None:
    said = CliRunner().invoke(app, ["keys", str(tmp_path / "keys"), "--mission", str(DEMO), *ADDRESSES])
    assert said.exit_code == 0
    for name in ("p1", "p2", "e1", "operator"):
        folder = tmp_path / "keys" / name
        assert f"{folder}: to" in said.output
        assert {file.name for file in folder.iterdir()} == {"ca.pem", "certificate.pem", "private.key"}
        authority, own = (read_certificate(folder / file) for file in ("ca.pem", "certificate.pem"))
        strict = PolicyBuilder().store(Store([authority]))
        host = DNSName("operator") if name == "operator" else IPAddress(ip_address(f"10.0.0.{name[-1]}"))
        assert strict.build_server_verifier(host).verify(own, []) == [own, authority]
        assert strict.build_client_verifier().verify(own, []).chain == [own, authority]
        found = load_credentials(folder)
        assert found.name == name
        assert abs(found.ends_s - time.time() - 14 * DAY_S) < 60.0
    assert "10.0.0.1" in load_credentials(tmp_path / "keys/p1").hosts
    private = list((tmp_path / "keys").rglob("*.key"))
    assert len(private) == 5
    assert {file.stat().st_mode & 0o777 for file in private} == {0o600}


def test_a_second_run_adds_a_vehicle_and_leaves_the_others_as_they_are(tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    make_keys(wish(keys, "p1"), 1e9)
    before = content(keys)
    handed = make_keys(wish(keys, "p1", "p2", days=60.0), 1e9 + DAY_S)
    after = content(keys)
    assert {name: after[name] for name in before} == before
    assert [(one.name, one.is_new) for one in handed] == [("p1", False), ("p2", True), ("operator", False)]
    assert after["p2/ca.pem"] == after["p1/ca.pem"]
    assert handed[1].ends_s == pytest.approx(1e9 + 14 * DAY_S), "nobody outlives the authority"


def test_json_says_what_goes_where(tmp_path: Path) -> None:
    said = CliRunner().invoke(app, ["keys", str(tmp_path / "keys"), "--mission", str(DEMO), *ADDRESSES, "--json"])
    told = json.loads(said.output)
    assert [member["name"] for member in told["members"]] == ["p1", "p2", "e1", "operator"]
    assert all(member["new"] for member in told["members"])
    assert "PRIVATE" not in said.output


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"vehicles": ("p1", "operator")}, "a vehicle and an operator"),
        ({"vehicles": ("authority",)}, "no name for a certificate"),
        ({"vehicles": ("../p1",)}, "no name for a certificate"),
        ({"hosts": {"p1": ("10.0.0.1",), "p9": ("10.0.0.9",)}}, "no such vehicle; known: p1"),
        ({"hosts": {}}, "write --address p1=HOST"),
    ],
)
def test_a_wish_that_cannot_be_leaves_nothing_behind(tmp_path: Path, given: dict[str, object], words: str) -> None:
    values: dict[str, object] = {"vehicles": ("p1",), "hosts": {"p1": ("10.0.0.1",)}, **given}
    with pytest.raises(InputError, match=words):
        make_keys(KeyWish(folder=tmp_path / "keys", fleet="f", days=1.0, **values), 1e9)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


def test_hosts_are_named_one_by_one() -> None:
    assert parse_hosts(["p1=10.0.0.1", "p1=p1.local", "p2=fe80::1"]) == {"p1": ("10.0.0.1", "p1.local"), "p2": ("fe80::1",)}
    for wrong in ("p1", "=10.0.0.1", "p1=", "p1=a b"):
        with pytest.raises(InputError, match="write NAME=HOST"):
            parse_hosts([wrong])


def test_keys_of_another_day_or_another_authority_are_not_mixed(tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    make_keys(wish(keys, "p1"), 1e9)
    with pytest.raises(InputError, match="has expired; make keys for the new day in a new folder"):
        make_keys(wish(keys, "p1", "p2"), 1e9 + 20 * DAY_S)
    make_keys(wish(tmp_path / "others", "p1"), 1e9)
    shutil.rmtree(keys / "authority")
    with pytest.raises(InputError, match="missing, 'p1' has keys of it"):
        make_keys(wish(keys, "p1", "p2"), 1e9)
    shutil.copytree(tmp_path / "others/authority", keys / "authority")
    with pytest.raises(InputError, match="another authority's"):
        make_keys(wish(keys, "p1"), 1e9)


def test_a_folder_that_is_not_whole_is_named_with_what_is_wrong(tmp_path: Path) -> None:
    make_keys(wish(tmp_path / "keys", "p1", "p2"), 1e9)
    make_keys(wish(tmp_path / "others", "p1"), 1e9)
    spoilt = tmp_path / "spoilt"
    for file, source, words in (
        ("private.key", "keys/p2/private.key", "is not the key of certificate.pem beside it"),
        ("ca.pem", "others/p1/ca.pem", "was not signed by ca.pem beside it"),
        ("private.key", "keys/p1/ca.pem", "is not a private key in PEM form"),
        ("certificate.pem", "keys/p1/private.key", "is not a certificate in PEM form"),
    ):
        shutil.rmtree(spoilt, ignore_errors=True)
        shutil.copytree(tmp_path / "keys/p1", spoilt)
        shutil.copyfile(tmp_path / source, spoilt / file)
        with pytest.raises(InputError, match=words) as refused:
            load_credentials(spoilt)
        assert str(spoilt / file if file != "ca.pem" else spoilt) in str(refused.value)
    (spoilt / "private.key").unlink()
    (spoilt / "certificate.pem").unlink()
    with pytest.raises(InputError, match=r"certificate\.pem: no such file"):
        load_credentials(spoilt)


@pytest.mark.parametrize(
    ("endpoints", "certificates", "words"),
    [
        (("udp/0.0.0.0:7447",), Path("keys/p1"), "cannot carry certificates; write quic/0.0.0.0:7447"),
        (("tcp/0.0.0.0:7447",), Path("keys/p1"), "cannot carry certificates"),
        (("quic/0.0.0.0:7447",), None, "needs certificates; make them with 'flightapp keys'"),
    ],
)
def test_a_profile_mixes_no_open_links_with_certificates(
    endpoints: tuple[str, ...], certificates: Path | None, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        Network(listen_endpoints=endpoints, certificates=certificates)


def test_a_simulated_fleets_profiles_name_the_keys_and_hold_none(tmp_path: Path) -> None:
    mission, profile = load_mission(DEMO), load_profile(ROOT / "profiles/sim.toml")
    files = prepare(mission, profile, tmp_path, tmp_path, range(20000, 20006), tmp_path / "keys")
    for own in files:
        network = load_profile(own.profile).network
        assert network.certificates == tmp_path / "keys" / own.vehicle.name
        assert all(endpoint.startswith("quic/") for endpoint in (*network.listen_endpoints, *network.connect_endpoints))
