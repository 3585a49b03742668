"""`make install-nuc` into a folder: what it installs is well formed, can be installed again, and cannot arm by itself."""

from __future__ import annotations

import configparser
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
UNIT = "etc/systemd/system/flightapp@.service"
RULES = "etc/udev/rules.d/90-flightapp.rules"


def install(folder: Path, *variables: str) -> subprocess.CompletedProcess[str]:
    command = ["make", "install-nuc", f"DESTDIR={folder}", "PROGRAM=no", *variables]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=30, check=False)


def files_of(folder: Path) -> dict[str, str]:
    return {str(file.relative_to(folder)): file.read_text() for file in sorted(folder.rglob("*")) if file.is_file()}


def test_installing_twice_changes_nothing_and_keeps_what_a_person_wrote(tmp_path: Path) -> None:
    first = install(tmp_path)
    assert first.returncode == 0, first.stderr
    assert set(files_of(tmp_path)) == {UNIT, RULES, "etc/flightapp/vehicle.env.example"}
    assert "/etc/flightapp/NAME.env" in first.stdout
    assert "name the autopilot's adapter" in first.stdout
    own = tmp_path / "etc/flightapp/p1.env"
    own.write_text("MISSION=/etc/flightapp/ours.toml\nPROFILE=/etc/flightapp/ours-profile.toml\n")
    before = files_of(tmp_path)
    second = install(tmp_path)
    assert files_of(tmp_path) == before
    assert "/etc/flightapp/NAME.env" not in second.stdout, "what is done is no longer asked for"


def test_the_adapter_of_the_autopilot_gets_its_name_by_serial_number(tmp_path: Path) -> None:
    install(tmp_path)
    assert 'SYMLINK+="pixhawk"' not in (tmp_path / RULES).read_text()
    said = install(tmp_path, "PIXHAWK_SERIAL=FT7ABC01")
    assert said.returncode == 0, said.stderr
    assert 'ATTRS{serial}=="FT7ABC01", SYMLINK+="pixhawk"' in (tmp_path / RULES).read_text()
    assert "name the autopilot's adapter" not in said.stdout
    refused = install(tmp_path, 'PIXHAWK_SERIAL=a"b')
    assert refused.returncode != 0
    assert "letters, digits" in refused.stderr


def test_every_line_of_the_rules_is_a_rule(tmp_path: Path) -> None:
    install(tmp_path, "PIXHAWK_SERIAL=FT7ABC01")
    term = r'[A-Z]+(\{[\w/]+\})?(==|!=|\+=|=)"[^"]*"'
    lines = [line for line in (tmp_path / RULES).read_text().splitlines() if line and not line.startswith("#")]
    assert len(lines) == 3
    for line in lines:
        assert re.fullmatch(rf"{term}(, {term})*", line), line


def test_udev_finds_nothing_wrong_with_the_rules(tmp_path: Path) -> None:
    udevadm = shutil.which("udevadm")
    if udevadm is None or subprocess.run([udevadm, "verify", "--help"], capture_output=True, check=False).returncode != 0:
        pytest.skip("udevadm verify came with systemd 254; not here")
    install(tmp_path, "PIXHAWK_SERIAL=FT7ABC01")
    said = subprocess.run([udevadm, "verify", str(tmp_path / RULES)], capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr


def unit_of(folder: Path) -> configparser.RawConfigParser:
    unit = configparser.RawConfigParser(strict=True)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read(folder / UNIT)
    return unit


def test_nothing_but_a_person_starts_a_flight(tmp_path: Path) -> None:
    install(tmp_path)
    unit = unit_of(tmp_path)
    service = unit["Service"]
    assert service["Restart"] == "no"
    assert not [name for name in service if name.startswith("Restart") and name != "Restart"]
    assert service["KillMode"] == "control-group"
    assert not unit.has_section("Install"), "a unit that can be enabled is a vehicle that arms when its computer starts"
    assert float(service["TimeoutStopSec"]) >= 120.0, "a landing takes its time"


def test_systemd_finds_nothing_wrong_with_the_unit(tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not installed")
    install(tmp_path)
    program = tmp_path / "flightapp"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    unit = tmp_path / "flightapp@.service"
    text = (tmp_path / UNIT).read_text().replace("/opt/flightapp/venv/bin/flightapp", str(program))
    unit.write_text(text)
    said = verified(analyze, unit)
    assert said.returncode == 0, said.stderr
    assert "flightapp@" not in said.stderr
    unit.write_text(text.replace("KillMode=control-group", "KillMode=whatever"))
    assert "flightapp@" in verified(analyze, unit).stderr, "the check itself works"


def verified(analyze: str, unit: Path) -> subprocess.CompletedProcess[str]:
    one = unit.with_name("flightapp@p1.service")
    one.write_text(unit.read_text())
    command = [analyze, "verify", "--man=no", "--recursive-errors=no", str(one)]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, env={**os.environ, "LC_ALL": "C"}, check=False)


def test_without_root_and_without_a_folder_it_is_refused(tmp_path: Path) -> None:
    if os.getuid() == 0:
        fake = tmp_path / "id"
        fake.write_text("#!/bin/sh\necho 1000\n")
        fake.chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    command = [str(ROOT / "tools/deploy/install.sh")]
    env = {**os.environ, "PATH": path, "DESTDIR": ""}
    said = subprocess.run(command, capture_output=True, text=True, timeout=30, env=env, check=False)
    assert said.returncode == 2
    assert "sudo make install-nuc" in said.stderr
