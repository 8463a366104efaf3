from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from hero_robot.fleet.fleet_file import Fleet, read_fleet, write_new_fleet
from hero_robot.fleet.simulated import SimulatedFleet
from tests.hero_robot.fleet.serving import PATIENCE, Serving, free_ports, wait_for

ROBOTS = 8


@pytest.fixture(scope="session", autouse=True)
def compiler() -> None:
    pytest.importorskip("cffi", reason="cffi is absent: pip install cffi")
    if not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        pytest.skip("no C compiler (Debian: gcc)")


# --- real processes, for the tests marked real_time -----------------------------------------------------------------------


@pytest.fixture(scope="module")
def fleet_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lab") / "lab.yaml"
    write_new_fleet(path, ["127.0.0.1"] * ROBOTS, free_ports(ROBOTS), page_port=0)
    return path


@pytest.fixture(scope="module")
def fleet(fleet_path: Path) -> Fleet:
    return read_fleet(fleet_path)


@pytest.fixture(scope="module")
def robots(fleet: Fleet) -> Iterator[SimulatedFleet]:
    with SimulatedFleet(fleet, seen_period=0.8) as simulated:
        yield simulated


@pytest.fixture(scope="module")
def operator(fleet_path: Path) -> Iterator[Serving]:
    pytest.importorskip("aiohttp", reason="aiohttp is absent: pip install aiohttp")
    with Serving(fleet_path, "--log", str(fleet_path.parent / "log")) as serving:
        yield serving


@pytest.fixture
def serving(operator: Serving, robots: SimulatedFleet) -> Serving:
    """A running server and all robots in HOLD; what the test before has killed or switched off runs again."""
    if operator.process.poll() is not None:
        operator.__enter__()
    for robot in robots.fleet.robots:
        if robot.number not in robots.processes:
            robots.switch_on(robot)

    def all_hold() -> bool:
        if operator.all_connected():
            operator.call("rearm")
            operator.call("hold")
        return all(event.state == 1 and not event.driven for event in robots.latest().values())

    wait_for(all_hold, PATIENCE, "all to be in HOLD")
    return operator
