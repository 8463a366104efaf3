"""A whole lab on simulated time: the server's logic, the robots' own firmware and a bad network, in one queue of events.

There are no processes, sockets or clocks, so that what happens is settled by the seed alone, on any machine under any load. The firmware
is polled each millisecond, as its core asks for; everything else happens at its own microsecond.
"""

from __future__ import annotations

import heapq
import itertools
import random
import time
from collections.abc import Callable
from pathlib import Path

from hero_robot.firmware import SimulatedBoard
from hero_robot.fleet.coordinator import FleetCoordinator
from hero_robot.fleet.delivery import Operation, Outcome
from hero_robot.fleet.fleet_file import Fleet, RobotEntry
from hero_robot.fleet.run_log import RunLog
from hero_robot.fleet.simulated import RobotEvent
from tests.hero_robot.fleet.lossy_network import LossyNetwork, NetworkConditions

BOOT, RUN = 0, 2
CONTROLLER = (0.05, 0.5, 0.04, -0.8)
SEEN_PERIOD = 0.8
"""Something stands before each robot for half of each such period, s."""


class Lab:
    """A running server, and robots that are switched on one after the other within the first 0.2 s.

    Args:
        seed: Of keys, nonces, the network, and of when each robot is switched on.
        conditions: Of the network.
        robots: How many.
        log: Folder that the server logs into, if any.
    """

    def __init__(self, seed: int, conditions: NetworkConditions | None = None, robots: int = 8, log: Path | None = None) -> None:
        self.rng = random.Random(seed)
        self.now_us = self.rng.randrange(10**9, 2 * 10**9)
        self._order = itertools.count()
        self._queue: list[tuple[int, int, Callable[[], object]]] = []
        self.network = LossyNetwork(seed, self.later, conditions or NetworkConditions())
        numbers = range(1, robots + 1)
        self.fleet = Fleet("lab", tuple(RobotEntry(f"hero_{i}", i, "127.0.0.1", 4210, self.rng.randbytes(32)) for i in numbers))
        self.boards = {robot.number: SimulatedBoard(robot.number, robot.key, seed * 1000 + robot.number) for robot in self.fleet.robots}
        self._ffi, self._library = self.boards[1].ffi, self.boards[1].library
        self._view = self._ffi.new("struct hero_sim_view *")  # one for all: they are looked at often
        self.events: list[RobotEvent] = []
        self._powered: dict[int, SimulatedBoard] = {}
        self._last: dict[int, tuple[int, bool, int]] = {}
        self._log = log
        self.server: FleetCoordinator | None = None
        self.start_server()
        for number in numbers:
            self.later(self.rng.uniform(0, 0.2), lambda number=number: self.switch_on(number))
        self._show_something(True)

    # --- time --------------------------------------------------------------------------------------------------------

    def later(self, seconds: float, action: Callable[[], object]) -> None:
        """Let something happen so many seconds from now."""
        heapq.heappush(self._queue, (self.now_us + round(seconds * 1e6), next(self._order), action))

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self._run_to(self.now_us + round(seconds * 1e6), lambda: False)

    def run_until(self, condition: Callable[[], bool], seconds: float, what: str) -> None:
        """Let time pass until ``condition`` holds; it must within so many seconds."""
        self._run_to(self.now_us + round(seconds * 1e6), condition)
        assert condition(), f"waited {seconds} s for {what}"

    def _run_to(self, end_us: int, condition: Callable[[], bool]) -> None:
        while self.now_us < end_us and not condition():
            while self._queue and self._queue[0][0] <= self.now_us:
                heapq.heappop(self._queue)[2]()
            if self.server is not None and self.server.next_us <= self.now_us:
                self.server.advance(self.now_us)
                self._send()
            wake_us = min(end_us, self._queue[0][0]) if self._queue else end_us
            if self.server is not None:
                wake_us = min(wake_us, self.server.next_us)
            if wake_us > self.now_us:
                self._pass(wake_us - self.now_us)

    def _pass(self, most_us: int) -> None:
        """Let time pass on all boards, up to the millisecond in which one of them has something to tell."""
        if not self._powered:
            self.now_us += most_us
            return
        pointers = self._ffi.new("struct hero_sim *[]", [board.pointer for board in self._powered.values()])
        self.now_us += self._library.hero_sim_run_together(pointers, len(self._powered), min(most_us, 10**9))
        for number, board in self._powered.items():
            for datagram in board.collect():
                self.network.carry(lambda datagram=datagram: self._server_hears(datagram))
            self._look_at(number, board)

    def _look_at(self, number: int, board: SimulatedBoard) -> None:
        view = self._view
        self._library.hero_sim_look(board.pointer, view)
        seen = (view.state, view.pulse_us[0] != 0 or view.pulse_us[1] != 0, view.version)
        if self._last.get(number) != seen:
            self._last[number] = seen
            self.events.append(RobotEvent(self.now_us * 1000, number, seen[0], view.reason, seen[1], seen[2]))

    # --- the server --------------------------------------------------------------------------------------------------

    def start_server(self) -> None:
        """Start a server; one that runs is gone."""
        wall_clock = lambda: time.gmtime(self.now_us / 1e6)  # noqa: E731
        log = RunLog(self._log, self.fleet.name, wall_clock) if self._log else None
        self.server = FleetCoordinator(self.fleet, log, wall_clock=wall_clock, random_bits=self.rng.getrandbits)

    def close(self) -> None:
        """Close the log."""
        if self.server is not None and self.server.log is not None:
            self.server.log.close()

    def kill_server(self) -> None:
        """End the server as a crash does: what it has sent is still on its way."""
        self.server = None

    def _server_hears(self, datagram: bytes) -> None:
        if self.server is not None:
            self.server.receive(datagram, self.now_us)
            self._send()

    def _send(self) -> None:
        assert self.server is not None
        for robot, datagram in self.server.take_outbox():
            self.network.recorded.append((robot.number, datagram))
            self.network.carry(lambda robot=robot, datagram=datagram: self.deliver(robot.number, datagram))

    def deliver(self, number: int, datagram: bytes) -> None:
        """Put a datagram into a robot's inbox; lost when that is full or the robot is off."""
        if number in self._powered:
            self._powered[number].deliver(datagram)

    def estop(self, press: str | None = None) -> None:
        """Press the emergency stop."""
        assert self.server is not None
        self.server.estop(self.now_us, press)
        self._send()

    def finish(self, operation: Operation) -> list[Outcome]:
        """Let time pass until a command has come to its end."""
        self._send()
        self.run_until(lambda: operation.outcomes is not None, 20, "the command's end")
        assert operation.outcomes is not None
        return operation.outcomes

    def update(self, controllers: dict[str, tuple[float, float, float, float]] | None = None) -> list[Outcome]:
        """Load controllers; without any the same on every robot."""
        assert self.server is not None
        return self.finish(self.server.update(controllers or {robot.name: CONTROLLER for robot in self.fleet.robots}, self.now_us))

    def start(self, delay: float = 0.6) -> list[Outcome]:
        """Start all together."""
        assert self.server is not None
        return self.finish(self.server.start(self.now_us, delay))

    def hold(self) -> list[Outcome]:
        """Take all to HOLD."""
        assert self.server is not None
        return self.finish(self.server.hold(self.now_us))

    def rearm(self) -> list[Outcome]:
        """Release the emergency stop."""
        assert self.server is not None
        return self.finish(self.server.rearm(self.now_us))

    def all_connected(self) -> bool:
        """Whether the server hears every robot, and each is through its self-test."""
        assert self.server is not None
        return all(
            link.connected(self.now_us) and link.status is not None and link.status.state != 0 for link in self.server.links.values()
        )

    def start_all(self) -> None:
        """Load a controller on every robot, start, and wait until all drive."""
        self.run_until(self.all_connected, 20, "the robots")
        updated = self.update()
        assert all(outcome.done for outcome in updated), updated
        started = self.start()
        assert all(outcome.done for outcome in started), started
        self.run_until(self.all_drive, 10, "all robots to drive")

    # --- the robots --------------------------------------------------------------------------------------------------

    def switch_on(self, number: int) -> None:
        """Boot a robot."""
        self.boards[number].boot()
        self._powered[number] = self.boards[number]
        self._last.pop(number, None)

    def switch_off(self, number: int) -> None:
        """Take a robot's battery out."""
        del self._powered[number]

    def _show_something(self, there: bool) -> None:
        for board in self.boards.values():
            board.set(distance=0.3 if there else 0.0)
        self.later(SEEN_PERIOD / 2, lambda: self._show_something(not there))

    def latest(self) -> dict[int, RobotEvent]:
        """The last change of each robot that is on."""
        latest = {event.robot: event for event in self.events}
        return {number: event for number, event in latest.items() if number in self._powered}

    def states(self) -> set[int]:
        """States of all robots that are on."""
        return {event.state for event in self.latest().values()}

    def all_drive(self) -> bool:
        """Whether every robot is in RUN and drives its servos."""
        latest = self.latest()
        return len(latest) == len(self.boards) and all(event.state == RUN and event.driven for event in latest.values())

    def any_drives(self) -> bool:
        """Whether a robot drives its servos."""
        return any(driven for number, (_, driven, _) in self._last.items() if number in self._powered)

    def longest_drive(self) -> float:
        """Longest time that a robot has driven its servos for, s; all must be at rest."""
        assert not self.any_drives()
        longest = 0
        for number in self.boards:
            events = [event for event in self.events if event.robot == number]
            longest = max([longest, *(after.ns - event.ns for event, after in itertools.pairwise(events) if event.driven)])
        return longest / 1e9

    def stop_times(self, since_us: int, within: float = 2.0) -> list[float]:
        """Seconds from ``since_us`` until each robot's servos were released for good; all must be."""
        self.run_until(lambda: not self.any_drives(), within, "all robots to stop")
        self.run(0.3)
        assert not self.any_drives(), "a robot moved again"
        times = []
        for number in self._powered:
            driven = [event for event in self.events if event.robot == number]
            last = max(place for place, event in enumerate(driven) if event.driven)
            times.append((driven[last + 1].ns / 1e3 - since_us) / 1e6)
        return times
