"""The fleet's server: a :class:`~hero_robot.fleet.coordinator.FleetCoordinator` on a UDP socket and this machine's clock."""

from __future__ import annotations

import asyncio
import math
import time
from typing import Any

from hero_robot.fleet.coordinator import START_DELAY, FleetCoordinator, Genes
from hero_robot.fleet.delivery import Operation, Outcome
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet
from hero_robot.fleet.run_log import RunLog
from hero_robot.fleet.snapshot import snapshot


def server_us() -> int:
    """The server's clock, us."""
    return time.monotonic_ns() // 1000


class FleetServer(asyncio.DatagramProtocol):
    """Runs a fleet; all methods belong to one event loop.

    Args:
        fleet: Robots, addresses, keys, lease.
        log: Where runs are logged, if anywhere.
    """

    def __init__(self, fleet: Fleet, log: RunLog | None = None) -> None:
        self.fleet, self.log = fleet, log
        self.coordinator = FleetCoordinator(fleet, log)
        self._transport: asyncio.DatagramTransport | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._due_us = 0
        self._waiting: list[tuple[Operation, asyncio.Future[list[Outcome]]]] = []

    async def open(self, host: str = "0.0.0.0") -> None:
        """Open the socket and begin to look for the robots."""
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=(host, 0))
        self._advance()

    async def close(self) -> None:
        """Stop granting motion and close; robots that run stop as their lease ends."""
        if self._timer is not None:
            self._timer.cancel()
        if self._transport is not None:
            self._transport.close()
        for _, future in self._waiting:
            future.cancel()
        if self.log is not None:
            self.log.close()

    # --- the socket and the clock ------------------------------------------------------------------------------------

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        """Hand a datagram over."""
        self.coordinator.receive(data, server_us())
        self._flush()

    def error_received(self, exc: Exception) -> None:
        """A robot's port is closed, or the network is away: its lease ends by itself."""

    def _advance(self) -> None:
        self._timer = None
        self.coordinator.advance(server_us())
        self._flush()

    def _flush(self) -> None:
        """Send what has to be sent, hand out what has come to its end, and wake up when the next thing is due."""
        if self._transport is None or self._transport.is_closing():
            return
        for robot, datagram in self.coordinator.take_outbox():
            self._transport.sendto(datagram, (robot.host, robot.port))
        for operation, future in self._waiting:
            if operation.outcomes is not None and not future.done():
                future.set_result(operation.outcomes)
        self._waiting = [waiting for waiting in self._waiting if not waiting[1].done()]
        due_us = self.coordinator.next_us
        if self._timer is not None and self._due_us <= due_us:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._due_us = due_us
        self._timer = asyncio.get_running_loop().call_later(max(0, due_us - server_us()) / 1e6, self._advance)

    async def _finish(self, operation: Operation) -> list[Outcome]:
        future: asyncio.Future[list[Outcome]] = asyncio.get_running_loop().create_future()
        self._waiting.append((operation, future))
        self._flush()
        return await future

    # --- commands: see the coordinator's -----------------------------------------------------------------------------

    def estop(self, press: str | None = None) -> None:
        """Stop every robot now, and latch: sent at once, repeated until each has said that it has stopped."""
        self.coordinator.estop(server_us(), press)
        self._flush()

    async def rearm(self) -> list[Outcome]:
        """Release the latch here and on every robot that is in ESTOP or FAULT; all are in HOLD afterwards."""
        return await self._finish(self.coordinator.rearm(server_us()))

    async def hold(self) -> list[Outcome]:
        """Take every robot to HOLD and end the run."""
        return await self._finish(self.coordinator.hold(server_us()))

    async def update(self, controllers: dict[str, Genes]) -> list[Outcome]:
        """Load a controller, [v0, w0, v1, w1] in m/s and rad/s, on each named robot.

        Raises:
            FleetError: For a name that the fleet does not have, or numbers that are none.
        """
        return await self._finish(self.coordinator.update(controllers, server_us()))

    async def start(self, delay: float = START_DELAY) -> list[Outcome]:
        """Start every robot at the same time, ``delay`` seconds from now; all of them or none.

        Raises:
            FleetError: When a robot is missing, not in HOLD, without the fleet's controller, or the delay is out of range.
        """
        return await self._finish(self.coordinator.start(server_us(), delay))

    def pose(self, robot: str, x: float, y: float, theta: float, age: float = 0.0) -> None:
        """Take a pose from a tracker, m and rad, ``age`` seconds old, for the log.

        Raises:
            FleetError: For a robot that the fleet does not have, or numbers that are none.
        """
        if not math.isfinite(age):
            raise FleetError(f"age {age} of a pose of {robot}; expected a finite number of seconds")
        self.coordinator.pose(robot, x, y, theta, server_us() - round(age * 1e6))

    def snapshot(self) -> dict[str, Any]:
        """The fleet as plain data, for the page and the command line."""
        return snapshot(self.coordinator, server_us())
