"""Simulated robots: the firmware built for this machine, one process per robot, on the loopback."""

from __future__ import annotations

import json
import subprocess
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet, RobotEntry


@dataclass(frozen=True)
class RobotEvent:
    """A change that a simulated robot went through."""

    ns: int
    """Time on this machine's monotonic clock, ns."""
    robot: int
    state: int
    reason: int
    driven: bool
    """Whether its servos get pulses."""
    version: int


class SimulatedFleet:
    """Runs the robots of a fleet file that live on 127.0.0.1; a context manager.

    Args:
        fleet: Whose robots to run.
        ports: Where each listens instead of the port in the fleet file, by robot number.
        seen_period: Something stands before each robot for half of each such period, s; 0: never.

    Raises:
        FleetError: When a robot does not live on 127.0.0.1, or its port is taken.
    """

    def __init__(self, fleet: Fleet, ports: dict[int, int] | None = None, seen_period: float = 0.0) -> None:
        from hero_robot.firmware.library import build_host

        self.program: Path = build_host()
        self.fleet, self.ports, self.seen_period = fleet, ports or {}, seen_period
        self.events: list[RobotEvent] = []
        self.processes: dict[int, subprocess.Popen[str]] = {}
        self._listeners: dict[int, threading.Thread] = {}
        elsewhere = [robot.name for robot in fleet.robots if robot.host not in ("127.0.0.1", "localhost")]
        if elsewhere:
            raise FleetError(f"{elsewhere[0]} does not live on 127.0.0.1; only robots of this machine can be simulated")

    def __enter__(self) -> SimulatedFleet:
        for robot in self.fleet.robots:
            self.switch_on(robot)
        for number, process in self.processes.items():
            while number not in self.latest() and process.poll() is None:
                time.sleep(0.002)
            if process.poll() is not None:
                self.close()
                raise FleetError(f"simulated robot {number} did not start (its port may be taken); give free ports in the fleet file")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def switch_on(self, robot: RobotEntry) -> None:
        """Start a robot's process."""
        port = self.ports.get(robot.number, robot.port)
        command = [str(self.program), str(robot.number), str(port), robot.key.hex(), str(round(self.seen_period * 1e3))]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.processes[robot.number] = process
        listener = threading.Thread(target=self._listen, args=(process,), daemon=True)
        listener.start()
        self._listeners[robot.number] = listener

    def switch_off(self, number: int) -> None:
        """End a robot's process at once, as when its battery is pulled."""
        process = self.processes.pop(number)
        process.kill()
        self._listeners.pop(number).join()  # it reads to the end
        with process:  # closes the pipes
            process.wait()

    def _listen(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            self.events.append(RobotEvent(**json.loads(line)))

    def latest(self) -> dict[int, RobotEvent]:
        """The last change of each robot."""
        return {event.robot: event for event in list(self.events)}

    def close(self) -> None:
        """End all processes."""
        for number in list(self.processes):
            self.switch_off(number)
