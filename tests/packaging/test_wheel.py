"""The wheel holds everything, and works where nothing of the checkout is in sight."""

from __future__ import annotations

import json
import os
import re
import socket
import sys
import tarfile
import time
import tomllib
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.discovery.tiny_run import TINY
from tests.packaging.conftest import ROOT, InstalledWheel, call, interpreters, must

PACKAGES = ("swarm_envs", "discovery", "hero_robot", "hero_firmware")
THIS = f"{sys.version_info.major}.{sys.version_info.minor}"
Installed = Callable[[str], InstalledWheel]

pytestmark = pytest.mark.slow


def files_of(folder: Path) -> Iterator[str]:
    """The files of a package in the checkout, links followed, as the paths that they have when installed."""
    for place, folders, names in os.walk(folder, followlinks=True):
        folders[:] = [name for name in folders if name != "__pycache__"]
        yield from ((Path(place) / name).relative_to(folder.parent).as_posix() for name in names)


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def names_in(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if ".dist-info/" not in name}


def test_the_wheel_holds_every_file_of_the_packages(wheel: Path, sources: Path) -> None:
    ours = {name for package in PACKAGES for name in files_of(sources / package)}
    # of the firmware: what is compiled on this machine, not what is flashed onto a robot or tests the C code
    board = re.compile(r"hero_robot/firmware/c_sources/(fuzz|tests|hal/esp8266|CMakeLists\.txt|README\.md)")
    assert names_in(wheel) == {name for name in ours if not board.match(name)}
    assert {"discovery/configs/config.yaml", "hero_robot/firmware/c_sources/core/hero_robot.c", "swarm_envs/py.typed"} <= names_in(wheel)


def test_a_wheel_straight_from_the_checkout_and_one_from_the_sdist_are_the_same(sources: Path, wheel: Path, tmp_path: Path) -> None:
    must(sys.executable, "-m", "build", "--wheel", "-o", tmp_path, ".", cwd=sources)
    (straight,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(straight) as one, zipfile.ZipFile(wheel) as other:
        assert {info.filename: info.CRC for info in one.infolist()} == {info.filename: info.CRC for info in other.infolist()}


def test_the_sdist_holds_what_the_wheel_is_built_of_and_no_tests(sdist: Path, wheel: Path) -> None:
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert names_in(wheel) <= names
    assert {"pyproject.toml", "README.md", "LICENSE"} <= names
    assert not [name for name in names if name.startswith("tests/")]


def test_every_supported_version_of_python_is_declared() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = {text.rpartition(" ")[2] for text in project["classifiers"] if re.search(r"Python :: 3\.\d+$", text)}
    assert declared == {"3.11", "3.12", "3.13"}
    assert project["requires-python"] == ">=3.11"


@pytest.mark.parametrize("version", interpreters())
def test_with_the_base_dependencies_alone_environments_and_rollouts_run(installed: Installed, version: str, tmp_path: Path) -> None:
    program = """
import gymnasium as gym, json, sys
env = gym.make("swarm_envs:HeRo/Swarm-v0")
env.reset(seed=3)
for _ in range(20):
    seen, reward, ended, cut, info = env.step(env.action_space.sample() * 0 + 0.05)
import swarm_envs
runs = swarm_envs.rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1]], seed=1, steps=300)
print(json.dumps({
    "file": swarm_envs.__file__, "version": sys.version_info[:2], "seen": list(seen.shape), "poses": list(runs.poses.shape),
    "loaded": sorted({name.partition(".")[0] for name in sys.modules} & {"torch", "sklearn", "scipy", "pygame", "matplotlib"}),
}))
"""
    place = installed(version)
    said = json.loads(place.run("python", "-c", program, cwd=tmp_path))
    assert Path(said["file"]).is_relative_to(place.folder)
    assert "{}.{}".format(*said["version"]) == version
    assert (said["seen"], said["poses"]) == ([8], [1, 301, 8, 3])
    assert said["loaded"] == []


def test_with_the_base_dependencies_alone_swarms_are_drawn_labelled_and_stepped_in_parallel(installed: Installed, tmp_path: Path) -> None:
    program = """
import gymnasium as gym, json
import pettingzoo, swarm_envs
env = gym.make("HeRo/Swarm-v0", render_mode="rgb_array")
env.reset(seed=3)
swarms = gym.make_vec("HeRo/Swarm-v0", num_envs=2, vectorization_mode="vector_entry_point")
robots = pettingzoo.make("parallel", "HeRo/Swarm-v0").reset(seed=0)[0]
runs = swarm_envs.rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1]], seed=1)
swarm_envs.rendering.save_video(runs, "swarm.gif")
print(json.dumps([list(env.render().shape), list(swarms.reset(seed=0)[0].shape), len(robots), swarm_envs.behaviours.label(runs)]))
"""
    said = json.loads(installed(THIS).run("python", "-c", program, cwd=tmp_path))
    assert said == [[426, 513, 3], [2, 8], 8, ["cyclic pursuit"]]
    assert (tmp_path / "swarm.gif").read_bytes().startswith(b"GIF89a")


@pytest.mark.parametrize(
    ("command", "words", "extra"),
    [
        ("swarm-discover", (), "discovery"),
        ("swarm-calibrate", ("log", "--out", "found"), "calibration"),
        ("swarm-fleet", ("serve", "lab.yaml"), "fleet"),
    ],
)
def test_without_its_extra_a_command_says_in_one_line_what_to_install(
    installed: Installed, command: str, words: tuple[str, ...], extra: str, tmp_path: Path
) -> None:
    place = installed(THIS)
    if command == "swarm-fleet":
        place.run(command, "keys", "lab.yaml", "1", cwd=tmp_path)
    done = call(place.folder / "bin" / command, *words, cwd=tmp_path)
    assert done.returncode in (1, 2)
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert f"swarm-envs[{extra}]" in done.stderr


def test_swarm_discover_runs_from_its_configs_to_its_report(with_extras: InstalledWheel, tmp_path: Path) -> None:
    own = tmp_path / "own" / "experiment" / "mine.yaml"
    own.parent.mkdir(parents=True)
    own.write_text("# @package _global_\nname: mine\nseed: 5\n")
    words = ("--config-dir", "own", "experiment=mine", "representation=simclr_quick", *TINY)
    report = with_extras.run("swarm-discover", *words, cwd=tmp_path).splitlines()[-1]
    assert "<svg" in (tmp_path / report).read_text(encoding="utf-8")
    settings = (tmp_path / report).with_name("config.yaml").read_text(encoding="utf-8")
    assert "name: mine" in settings
    assert "seed: 5" in settings


def test_swarm_calibrate_predicts_a_log(with_extras: InstalledWheel, tmp_path: Path) -> None:
    folder = tmp_path / "my_log"
    folder.mkdir()
    (folder / "log.yaml").write_text("name: my_log\nrobot: HeRo+\nunits: {t: s, x: m, y: m, theta: rad, v: m/s, omega: rad/s}\n")
    (folder / "commands.csv").write_text("run,robot,t,v,omega\nrun_0,hero_1,0.0,0.05,0.0\n")
    poses = "".join(f"run_0,hero_1,{k / 10:.1f},{0.2 + 0.004 * k:.4f},0.5,0.0\n" for k in range(100))  # at 0.04 m/s, slower than told
    (folder / "poses.csv").write_text("run,robot,t,x,y,theta\n" + poses)
    said = json.loads(with_extras.run("swarm-calibrate", "--evaluate", "hero_plus", "my_log", "--json", cwd=tmp_path))
    assert said["5.0"]["position_m"] == pytest.approx(5 * 0.01, rel=0.05)


def test_swarm_fleet_serves_robots_that_run_the_firmware(with_extras: InstalledWheel, tmp_path: Path) -> None:
    with_extras.run("swarm-fleet", "keys", "lab.yaml", "2", "--port", str(free_port()), "--page-port", "0", cwd=tmp_path)
    server = with_extras.start("swarm-fleet", "serve", "lab.yaml", "--simulate", cwd=tmp_path, HERO_FIRMWARE_CACHE=str(tmp_path / "built"))
    try:
        assert server.stdout is not None
        assert "2 robots, page at http://127.0.0.1:" in server.stdout.readline()
        said = ""
        for _ in range(60):  # until both robots, processes of their own, have been heard
            said = with_extras.run("swarm-fleet", "status", "lab.yaml", cwd=tmp_path)
            if said.count(": HOLD") == 2:
                break
            time.sleep(0.5)
        assert said.count(": HOLD") == 2, said
    finally:
        server.terminate()
        server.communicate(timeout=30)
    assert list((tmp_path / "built").glob("*/hero_host"))
