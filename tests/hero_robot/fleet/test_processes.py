"""Server and robots as processes with sockets, on this machine's clock: that they do what ``test_safety.py`` proves on simulated time."""

from __future__ import annotations

import csv
import json
import statistics
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest

from hero_robot.fleet.simulated import SimulatedFleet
from tests.hero_robot.fleet.properties import ESTOP, ESTOP_LIMIT, STOP_LIMIT
from tests.hero_robot.fleet.serving import PATIENCE, Serving, stop_times, wait_for

pytestmark = pytest.mark.real_time


@pytest.fixture
def report(record_property: Callable[[str, object], None]) -> Callable[[str, list[float]], None]:
    """Prints measured latencies, ms (seen with -s, and in the JUnit report)."""

    def tell(what: str, seconds: list[float]) -> None:
        text = f"{min(seconds) * 1e3:.1f} to {max(seconds) * 1e3:.1f} ms, median {statistics.median(seconds) * 1e3:.1f}"
        record_property(what, text)
        print(f"\n{what}: {text}")

    return tell


def test_an_emergency_stop_reaches_eight_robots(
    serving: Serving, robots: SimulatedFleet, report: Callable[[str, list[float]], None]
) -> None:
    """Each within the lease's limit, which holds on a busy machine; as soon as promised when the machine lets the processes run."""
    presses = []
    for _ in range(5):
        serving.start_all(robots)
        asked = time.monotonic_ns()
        serving.call("estop")
        presses.append(stop_times(robots, asked))
        wait_for(lambda: {event.state for event in robots.latest().values()} == {ESTOP}, PATIENCE, "all to be in ESTOP")
        serving.call("rearm")
    report("emergency stop, from the request to released servos", [time for press in presses for time in press])
    assert max(max(press) for press in presses) < STOP_LIMIT
    assert min(max(press) for press in presses) < ESTOP_LIMIT


def test_when_the_server_is_killed_all_stop_within_500_ms(
    serving: Serving, robots: SimulatedFleet, report: Callable[[str, list[float]], None]
) -> None:
    serving.start_all(robots)
    killed = serving.kill()
    times = stop_times(robots, killed)
    report("server killed", times)
    assert max(times) < STOP_LIMIT


def test_ending_the_server_stops_the_robots_and_latches_and_its_log_with_a_trackers_pose_is_whole(
    serving: Serving, robots: SimulatedFleet, fleet_path: Path
) -> None:
    serving.start_all(robots)
    time.sleep(0.5)
    assert serving.call("poses", poses=[{"robot": "hero_3", "x": 0.1, "y": 0.5, "theta": 1.0, "age": 0.02}]) == {"taken": 1}
    serving.end()
    assert serving.process.returncode == 0, serving.output.read_text()
    wait_for(lambda: {event.state for event in robots.latest().values()} == {ESTOP}, PATIENCE, "all to be in ESTOP")
    stop_times(robots, time.monotonic_ns())
    rows, poses = (
        list(csv.DictReader((fleet_path.parent / "log" / name).read_text().splitlines())) for name in ("commands.csv", "poses.csv")
    )
    assert [(row["robot"], float(row["x"]), float(row["theta"])) for row in poses if row["run"] == rows[-1]["run"]] == [
        ("hero_3", 0.1, 1.0)
    ]
    moving = {row["robot"] for row in rows if float(row["v"]) > 0 and row["run"] == rows[-1]["run"]}
    assert moving == {f"hero_{number}" for number in range(1, 9)}


def test_only_the_stop_is_open_to_a_stranger(serving: Serving, robots: SimulatedFleet) -> None:
    url = serving.session["url"]
    for path, headers in [("start", {}), ("rearm", {"X-Fleet-Token": "guessed"}), ("update", {}), ("poses", {}), ("hold", {})]:
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(urllib.request.Request(f"{url}/{path}", b"{}", headers), timeout=PATIENCE)
        refused.value.close()
        assert refused.value.code == 403
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(urllib.request.Request(f"{url}/", headers={"Host": "evil.example"}), timeout=PATIENCE)
    refused.value.close()
    with urllib.request.urlopen(urllib.request.Request(f"{url}/estop", b""), timeout=PATIENCE) as answer:
        assert json.load(answer) == {"outcomes": []}
    wait_for(lambda: all(event.state == ESTOP for event in robots.latest().values()), PATIENCE, "ESTOP")
    assert serving.status()["stopped"] is True
