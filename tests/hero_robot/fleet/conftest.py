from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from hero_robot.fleet.fleet_file import Fleet, read_fleet, write_new_fleet
from hero_robot.fleet.simulated import SimulatedFleet
from tests.hero_robot.fleet.network import BadNetwork, Weather, free_ports
from tests.hero_robot.fleet.serving import Serving, wait_for

ROBOTS = 8


@pytest.fixture(scope="session", autouse=True)
def compiler() -> None:
    pytest.importorskip("cffi", reason="cffi is absent: pip install cffi")
    if not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        pytest.skip("no C compiler (Debian: gcc)")


@pytest.fixture(scope="module")
def fleet_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lab") / "lab.yaml"
    write_new_fleet(path, ["127.0.0.1"] * ROBOTS, free_ports(ROBOTS), page_port=0)
    return path


@pytest.fixture(scope="module")
def fleet(fleet_path: Path) -> Fleet:
    return read_fleet(fleet_path)


@pytest.fixture(scope="module")
def network(fleet: Fleet) -> Iterator[BadNetwork]:
    """The fleet file's ports are the network's; the robots listen behind it."""
    behind = free_ports(ROBOTS)
    with BadNetwork({robot.port: port for robot, port in zip(fleet.robots, behind, strict=True)}) as bad:
        yield bad


@pytest.fixture(scope="module")
def robots(fleet: Fleet, network: BadNetwork) -> Iterator[SimulatedFleet]:
    with SimulatedFleet(fleet, ports={robot.number: network.ways[robot.port] for robot in fleet.robots}, seen_period=0.8) as simulated:
        yield simulated


@pytest.fixture(scope="module")
def operator(fleet_path: Path) -> Iterator[Serving]:
    pytest.importorskip("aiohttp", reason="aiohttp is absent: pip install aiohttp")
    with Serving(fleet_path, "--log", str(fleet_path.parent / "log")) as serving:
        yield serving


@pytest.fixture
def serving(operator: Serving, robots: SimulatedFleet, network: BadNetwork) -> Serving:
    """A running server, good weather, all robots in HOLD; a server that the test before has killed is started again."""
    network.weather = Weather()
    network.recorded.clear()
    if operator.process.poll() is not None:
        operator.__enter__()
    for robot in robots.fleet.robots:
        if robot.number not in robots.processes:
            robots.switch_on(robot)
    wait_for(operator.all_connected, 20, "the robots")
    operator.call("rearm")
    operator.call("hold")
    wait_for(lambda: all(event.state == 1 for event in robots.latest().values()), 5, "all to be in HOLD")
    return operator
