"""Programs written for the earlier package names run for one more version, and are told the new name."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        ("hero_firmware", "hero_robot.firmware", "FirmwareSwarm"),
        ("hero_firmware.build", "hero_robot.firmware.build", "measure"),
        ("discovery.deployment", "hero_robot.fleet", "FleetServer"),
        ("discovery.deployment.errors", "hero_robot.fleet.errors", "FleetError"),
    ],
)
def test_an_old_name_gives_the_same_object_and_names_the_new_package(
    old: str, new: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for loaded in [module for module in sys.modules if module.startswith(("hero_firmware", "discovery.deployment"))]:
        monkeypatch.delitem(sys.modules, loaded)
    top = ".".join(new.split(".")[:2])
    with pytest.warns(DeprecationWarning, match=f"is now {top}; import that"):
        module = importlib.import_module(old)
    assert getattr(module, name) is getattr(importlib.import_module(new), name)


@pytest.mark.parametrize(
    ("command", "new"),
    [
        (["-m", "discovery.deployment", "keys", "lab.yaml", "2"], "python -m hero_robot.fleet"),
        (["-m", "hero_firmware.build", "--sizes"], "python -m hero_robot.firmware.build"),
    ],
    ids=["fleet", "firmware"],
)
def test_the_old_commands_still_work_and_say_the_new_ones(
    command: list[str], new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert f"is now {new}; use that" in done.stderr


def test_the_bridges_old_path_runs_the_bridge(tmp_path: Path) -> None:
    bridge = ROOT / "discovery" / "deployment" / "ros_bridge.py"
    done = subprocess.run([sys.executable, bridge], capture_output=True, text=True, check=False, cwd=tmp_path)
    told, reason = done.stderr.splitlines()
    assert told == "discovery/deployment/ros_bridge.py is now hero_robot/fleet/ros_bridge.py; use that"
    assert reason.startswith("expected the session file of a running server")


def test_the_host_side_imports_nothing_of_discovery() -> None:
    modules = sorted(
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for folder in ("firmware", "fleet")
        for path in (ROOT / "hero_robot" / folder).glob("*.py")
        if path.name not in ("__init__.py", "__main__.py")
    )
    assert len(modules) > 10
    program = f"import importlib, sys\nfor name in {modules}: importlib.import_module(name)\n" + (
        "sys.exit(', '.join(name for name in sys.modules if name.split('.')[0] in ('discovery', 'torch')) or None)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
