"""A fleet's server as its operator runs it: a process of its own, driven through the command line's own calls.

What a test needs before it measures is waited for, and tried again, however long the machine takes. What it measures, it takes from the
robots' own clock.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hero_robot.fleet.command import _call, session_path
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.simulated import RobotEvent, SimulatedFleet

RUN = 2
CONTROLLER = [0.05, 0.5, 0.04, -0.8]
PATIENCE = 60.0
"""Time, s, that a busy machine gets for what is only a test's premise, or has no limit of its own."""


def free_ports(count: int) -> list[int]:
    """UDP ports of 127.0.0.1 that nobody has."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


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
        self.output = self.path.with_suffix(".txt")
        with self.output.open("w") as stream:
            self.process = subprocess.Popen(self.command, stdout=stream, stderr=subprocess.STDOUT)
        wait_for(lambda: self.process.poll() is not None or self._has_session(), PATIENCE, "the server")
        assert self.process.poll() is None, self.output.read_text()
        return self

    def _has_session(self) -> bool:
        try:
            self.session = json.loads(session_path(self.path).read_text())
        except (OSError, json.JSONDecodeError):
            return False
        return True

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.end()

    def call(self, path: str, **body: Any) -> dict[str, Any]:
        return _call(self.path, path, body)

    def status(self) -> dict[str, Any]:
        return _call(self.path, "status")

    def all_connected(self) -> bool:
        return all(robot["connected"] and robot["state"] != "BOOT" for robot in self.status()["robots"])

    def start_all(self, robots: SimulatedFleet) -> None:
        """Load a controller on every robot, start, and wait until all drive; again, when the machine was too busy for it."""
        deadline = time.monotonic() + PATIENCE
        while not self._try_to_start(robots):
            assert time.monotonic() < deadline, f"the robots did not all drive within {PATIENCE} s"

    def _try_to_start(self, robots: SimulatedFleet) -> bool:
        wait_for(self.all_connected, PATIENCE, "the robots")
        names = [robot["name"] for robot in self.status()["robots"]]
        try:
            for path, body in (("hold", {}), ("update", {"controllers": dict.fromkeys(names, CONTROLLER)}), ("start", {"delay": 0.6})):
                if not all(outcome["done"] for outcome in self.call(path, **body)["outcomes"]):
                    return False
        except FleetError:
            return False
        begun = time.monotonic()
        while time.monotonic() < begun + 3 and not all_drive(robots):
            time.sleep(0.005)
        return all_drive(robots)

    def kill(self) -> int:
        """End the server as a crash does; the time, ns."""
        os.kill(self.process.pid, signal.SIGKILL)
        now = time.monotonic_ns()
        self.process.wait()
        return now

    def end(self) -> None:
        """End the server as its operator does."""
        self.process.terminate()
        self.process.wait(PATIENCE)


def all_drive(robots: SimulatedFleet) -> bool:
    latest = robots.latest()
    return len(latest) == len(robots.processes) and all(event.state == RUN and event.driven for event in latest.values())


def stop_times(robots: SimulatedFleet, since_ns: int) -> list[float]:
    """Seconds from ``since_ns`` until each robot's servos were released for good, by the robots' own clock; all must be."""

    def last(robot: int) -> RobotEvent:
        return robots.latest()[robot]

    wait_for(lambda: not any(last(robot).driven for robot in robots.processes), PATIENCE, "all robots to stop")
    time.sleep(0.3)
    assert not any(last(robot).driven for robot in robots.processes), "a robot moved again"
    times = []
    for robot in robots.processes:
        events = [event for event in list(robots.events) if event.robot == robot]
        stopped = next(event for index, event in enumerate(events) if not any(later.driven for later in events[index:]))
        times.append((stopped.ns - since_ns) / 1e9)
    return times
