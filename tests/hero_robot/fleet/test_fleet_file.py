from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
import yaml

from hero_robot.fleet.command import main
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import read_fleet, secrets_header, write_new_fleet


def write(path: Path, **changes: object) -> Path:
    robot = {"name": "hero_1", "number": 1, "host": "127.0.0.1", "port": 4210, "key": bytes(range(32)).hex()}
    top = {name: changes.pop(name) for name in list(changes) if name in {"lease", "heartbeat", "colour"}}
    path.write_text(yaml.safe_dump({"robots": [robot | changes], **top}))
    path.chmod(0o600)
    return path


def test_a_new_fleet_reads_back_with_random_keys(tmp_path: Path) -> None:
    path = tmp_path / "lab.yaml"
    write_new_fleet(path, ["10.0.0.1", "10.0.0.2"], [4210, 4210])
    fleet = read_fleet(path)
    assert [robot.name for robot in fleet.robots] == ["hero_1", "hero_2"]
    assert fleet.robots[0].key != fleet.robots[1].key
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    with pytest.raises(FleetError, match="exists, and its keys may be in use"):
        write_new_fleet(path, ["10.0.0.1"], [4210])


def test_keys_that_others_may_read_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "lab.yaml")
    os.chmod(path, 0o644)
    with pytest.raises(FleetError, match="chmod 600"):
        read_fleet(path)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"key": "00" * 32}, "64 random hexadecimal digits"),
        ({"key": "abc"}, "64 random hexadecimal digits"),
        ({"port": 0}, "between 1 and 65535"),
        ({"number": "1"}, "given a str, expected a int"),
        ({"colour": "red"}, "unknown key 'colour'"),
        ({"lease": 0.6}, "lease <= 0.5"),
        ({"heartbeat": 0.4}, "heartbeat < lease"),
        ({"extra": 1}, "exactly the keys"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, changes: dict[str, object], reason: str) -> None:
    with pytest.raises(FleetError, match=reason) as caught:
        read_fleet(write(tmp_path / "lab.yaml", **changes))
    assert "\n" not in str(caught.value)


def test_secrets_carry_the_robots_own_key_and_any_password(tmp_path: Path) -> None:
    robot = read_fleet(write(tmp_path / "lab.yaml")).robots[0]
    text = secrets_header(robot, "lab", 'a"b\\c\u00e9?')
    assert f'"{robot.key.hex()}"' in text
    assert r'"a\042b\134c\303\251\077"' in text


def test_the_command_line_says_what_is_wrong_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["status", str(tmp_path / "none.yaml")]) == 2
    assert main(["serve", str(tmp_path / "none.yaml")]) == 2
    assert main(["keys", str(tmp_path / "lab.yaml"), "2", "--hosts", "10.0.0.1"]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 3
    assert "no server runs" in lines[0]


def test_nothing_here_needs_torch() -> None:
    import subprocess
    import sys

    code = "import hero_robot.fleet.command, hero_robot.fleet.server, sys; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
