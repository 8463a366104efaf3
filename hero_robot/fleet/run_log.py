"""Logs of a fleet, in the folder format that calibration reads: one clock, seconds from the start of each run.

``log.yaml`` says what it is; ``commands.csv`` (run, robot, t, v, omega), ``detections.csv`` (run, robot, t, detected) and
``odometry.csv`` (run, robot, t, x, y, theta) get a row for each report of a robot; ``poses.csv`` (run, robot, t, x, y, theta)
one for each pose that a tracker gives.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import yaml

from hero_robot.fleet.frames import Status

COLUMNS = {
    "poses": ("run", "robot", "t", "x", "y", "theta"),
    "commands": ("run", "robot", "t", "v", "omega"),
    "detections": ("run", "robot", "t", "detected"),
    "odometry": ("run", "robot", "t", "x", "y", "theta"),
}


COMING_TO_REST_US = 1_000_000
"""Time after the end of a run, us, that still belongs to it."""


class RunLog:
    """Writes a log folder; every row is on disk when it is needed most, after a crash.

    Args:
        folder: New or empty, or a log of this fleet that is to be continued.
        fleet: Name of the fleet.
        wall_clock: The time of day that runs are named after.
    """

    def __init__(self, folder: Path, fleet: str, wall_clock: Callable[[], time.struct_time] = time.localtime) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.run: str | None = None
        self._wall_clock = wall_clock
        self._zero_us = self._end_us = 0
        self._files: dict[str, IO[str]] = {}
        self._writers: dict[str, Any] = {}
        self._describe(fleet)

    def _describe(self, fleet: str) -> None:
        description = {
            "name": self.folder.name,
            "robot": "HeRo+",
            "description": f"Runs of the fleet {fleet}, as its server logged them.",
            "units": {
                "t": "s from the start of the run, server's clock",
                "x": "m",
                "y": "m",
                "theta": "rad, counter-clockwise",
                "v": "m/s, as the robot's controller commanded",
                "omega": "rad/s, as the robot's controller commanded",
                "detected": "1 when the robot's debounced sensor saw something",
            },
            "source": "hero_robot.fleet",
            "licence": "the owner's",
        }
        path = self.folder / "log.yaml"
        if not path.exists():
            path.write_text(yaml.safe_dump(description, sort_keys=False), encoding="utf-8")

    def _writer(self, table: str) -> Any:
        if table not in self._writers:
            path = self.folder / f"{table}.csv"
            fresh = not path.exists()
            self._files[table] = path.open("a", encoding="utf-8", newline="", buffering=1)
            self._writers[table] = csv.writer(self._files[table])
            if fresh:
                self._writers[table].writerow(COLUMNS[table])
        return self._writers[table]

    def start(self, zero_us: int) -> str:
        """Begin a run whose time zero is this server time, us; returns its name."""
        self._zero_us, self._end_us = zero_us, zero_us + 10**15
        self.run = time.strftime("%Y-%m-%dT%H-%M-%S", self._wall_clock()) + f"-{zero_us // 1000 % 1000:03d}"
        return self.run

    def stop(self, server_us: int) -> None:
        """End the run at this server time, us; how the robots come to rest still belongs to it."""
        self._end_us = min(self._end_us, server_us + COMING_TO_REST_US)

    def _row(self, robot: str, server_us: int) -> tuple[str, str, str] | None:
        """First columns of a row, or None outside a run."""
        if self.run is None or not self._zero_us <= server_us <= self._end_us:
            return None
        return self.run, robot, f"{(server_us - self._zero_us) / 1e6:.6f}"

    def report(self, robot: str, status: Status, server_us: int) -> None:
        """Take a robot's report, made at this server time, us."""
        row = self._row(robot, server_us)
        if row is None:
            return
        self._writer("commands").writerow((*row, f"{status.v:.6f}", f"{status.omega:.6f}"))
        self._writer("detections").writerow((*row, int(status.seen)))
        self._writer("odometry").writerow((*row, f"{status.x:.6f}", f"{status.y:.6f}", f"{status.theta:.6f}"))

    def pose(self, robot: str, x: float, y: float, theta: float, server_us: int) -> None:
        """Take a tracker's pose, m and rad, of this server time, us."""
        row = self._row(robot, server_us)
        if row is None:
            return
        self._writer("poses").writerow((*row, f"{x:.6f}", f"{y:.6f}", f"{theta:.6f}"))

    def close(self) -> None:
        """Close the files."""
        for stream in self._files.values():
            stream.close()
        self._files.clear()
        self._writers.clear()
