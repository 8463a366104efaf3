"""A fleet's server as its operator runs it: a process of its own, driven through the command line's own calls."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hero_robot.fleet.command import _call, session_path
from hero_robot.fleet.simulated import RobotEvent, SimulatedFleet

RUN = 2
CONTROLLER = [0.05, 0.5, 0.04, -0.8]


def wait_for(condition: Callable[[], bool], seconds: float, what: str) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"waited {seconds} s for {what}"
        time.sleep(0.005)


class Serving:
    """``python -m hero_robot.fleet serve`` in the background; a context manager."""

    def __init__(self, fleet_path: Path, *options: str) -> None:
        self.path = fleet_path
        self.command = [sys.executable, "-m", "hero_robot.fleet", "serve", str(fleet_path), "--page-port", "0", *options]

    def __enter__(self) -> Serving:
        session_path(self.path).unlink(missing_ok=True)
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        wait_for(lambda: self.process.poll() is not None or self._has_session(), 60, "the server")
        assert self.process.poll() is None, self.process.stdout.read() if self.process.stdout else ""
        return self

    def _has_session(self) -> bool:
        try:
            self.session = json.loads(session_path(self.path).read_text())
        except (OSError, json.JSONDecodeError):
            return False
        return True

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(10)

    def call(self, path: str, **body: Any) -> dict[str, Any]:
        return _call(self.path, path, body)

    def status(self) -> dict[str, Any]:
        return _call(self.path, "status")

    def all_connected(self) -> bool:
        return all(robot["connected"] and robot["state"] != "BOOT" for robot in self.status()["robots"])

    def start_all(self, robots: SimulatedFleet) -> None:
        """Load a controller on every robot, start, and wait until all drive."""
        wait_for(self.all_connected, 20, "the robots")
        names = [robot["name"] for robot in self.status()["robots"]]
        updated = self.call("update", controllers=dict.fromkeys(names, CONTROLLER))
        assert all(outcome["done"] for outcome in updated["outcomes"]), updated
        started = self.call("start", delay=0.6)
        assert all(outcome["done"] for outcome in started["outcomes"]), started
        wait_for(lambda: all_drive(robots), 10, "all robots to drive")

    def kill(self) -> int:
        """End the server as a crash does; the time, ns."""
        os.kill(self.process.pid, signal.SIGKILL)
        now = time.monotonic_ns()
        self.process.wait()
        return now


def all_drive(robots: SimulatedFleet) -> bool:
    latest = robots.latest()
    return len(latest) == len(robots.processes) and all(event.state == RUN and event.driven for event in latest.values())


def stop_times(robots: SimulatedFleet, since_ns: int, within: float = 2.0) -> list[float]:
    """Seconds from ``since_ns`` until each robot's servos were released for good; all must be."""

    def last(robot: int) -> RobotEvent:
        return robots.latest()[robot]

    wait_for(lambda: not any(last(robot).driven for robot in robots.processes), within, "all robots to stop")
    time.sleep(0.3)
    assert not any(last(robot).driven for robot in robots.processes), "a robot moved again"
    times = []
    for robot in robots.processes:
        events = [event for event in list(robots.events) if event.robot == robot]
        stopped = next(event for index, event in enumerate(events) if not any(later.driven for later in events[index:]))
        times.append((stopped.ns - since_ns) / 1e9)
    return times
