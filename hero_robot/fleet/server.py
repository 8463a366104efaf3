"""The fleet's server: leases, emergency stop, synchronised start, controller update, status.

Safety rests on the robots, not on this program: a robot moves only under a lease that this program renews, so whatever happens
to it, to its machine or to the network, robots stop within the lease.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from hero_robot.fleet import frames
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet
from hero_robot.fleet.frames import REASONS, FrameType, Result, RobotState, Status
from hero_robot.fleet.robot_link import RobotLink
from hero_robot.fleet.run_log import RunLog

RESEND = 0.02
"""Time between repetitions of a command that is not yet acknowledged, s."""

GIVE_UP = 1.5
"""Time after which a command that is not acknowledged counts as lost, s."""

HELLO_PERIOD = 1.0
"""Time between measurements of the clocks, s; a robot that is not heard is asked four times as often."""

MISSED_US = 160_000
"""Silence, us, of three reports: the robot may have booted again."""

START_DELAY = 0.6
"""Time from asking for a start to the start, s: room for lost frames."""


PASSING = (Result.DONE, Result.NO_LEASE)
"""Answers that do not end a command: a robot that has just become ready gets its lease with the next heartbeat."""


def server_us() -> int:
    """The server's clock, us."""
    return time.monotonic_ns() // 1000


@dataclass(frozen=True)
class Outcome:
    """What became of a command at one robot."""

    robot: str
    done: bool
    reason: str


class FleetServer(asyncio.DatagramProtocol):
    """Keeps the link to every robot of a fleet; all methods belong to one event loop.

    Args:
        fleet: Robots, addresses, keys, lease.
        log: Where runs are logged, if anywhere.
    """

    def __init__(self, fleet: Fleet, log: RunLog | None = None) -> None:
        self.fleet = fleet
        self.links = {entry.number: RobotLink(entry) for entry in fleet.robots}
        self.log = log
        self.stopped = False
        """Latched by :meth:`estop`: no heartbeat is sent until :meth:`rearm`."""
        self._stops = 0
        """How often the emergency stop was asked for."""
        self.run: str | None = None
        self.events: list[str] = []
        """What an operator should know, newest last."""
        self._transport: asyncio.DatagramTransport | None = None
        self._task: asyncio.Task[None] | None = None
        self._hello_us: dict[int, int] = {}
        self._arrivals: dict[int, asyncio.Event] = {number: asyncio.Event() for number in self.links}

    # --- life --------------------------------------------------------------------------------------------------------

    async def open(self, host: str = "0.0.0.0") -> None:
        """Open the socket and begin to look for the robots."""
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=(host, 0))
        self._task = asyncio.create_task(self._beat())

    async def close(self) -> None:
        """Stop granting motion and close; robots that run stop as their lease ends."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        if self._transport is not None:
            self._transport.close()
        if self.log is not None:
            self.log.close()

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        """A robot's report; whose it is, its tag decides, not its address."""
        number = frames.robot_of(data)
        link = self.links.get(number) if number is not None else None
        if link is None:
            return
        now = server_us()
        before = link.status
        status = link.receive(data, now)
        if status is None:
            return
        self._tell(link, before, status)
        if self.log is not None:
            self.log.report(link.entry.name, status, status.time_us - link.clock.middle)
        self._arrivals[link.entry.number].set()

    def error_received(self, exc: Exception) -> None:
        """A robot's port is closed, or the network is away: its lease ends by itself."""

    def _send(self, link: RobotLink, datagram: bytes) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.sendto(datagram, (link.entry.host, link.entry.port))

    def _tell(self, link: RobotLink, before: Status | None, status: Status) -> None:
        if before is None or before.state != status.state:
            faults = f" ({status.faults.name})" if status.state == RobotState.FAULT and status.faults else ""
            self._note(f"{link.entry.name}: {status.state.name}, {REASONS[status.reason]}{faults}")

    def _note(self, text: str) -> None:
        self.events.append(f"{time.strftime('%H:%M:%S')} {text}")
        del self.events[:-200]

    # --- the heartbeat -----------------------------------------------------------------------------------------------

    async def _beat(self) -> None:
        """Renew every lease, look for robots that are not there, repeat the emergency stop until each has it."""
        while True:
            now = server_us()
            for link in self.links.values():
                self._look_for(link, now)
                if not link.connected(now):
                    continue
                if not self.stopped:
                    self._send(link, link.heartbeat(now, self.fleet.lease))
                elif link.status is not None and link.status.state != RobotState.ESTOP:
                    self._send(link, link.command(FrameType.ESTOP)[1])
            await asyncio.sleep(RESEND if self.stopped else self.fleet.heartbeat)

    def _look_for(self, link: RobotLink, now_us: int) -> None:
        missed = now_us - link.heard_us > MISSED_US
        period = HELLO_PERIOD / 4 if missed else HELLO_PERIOD
        if now_us - self._hello_us.get(link.entry.number, -(10**12)) >= period * 1e6:
            self._hello_us[link.entry.number] = now_us
            self._send(link, link.hello(now_us))

    # --- commands ----------------------------------------------------------------------------------------------------

    def estop(self) -> None:
        """Stop every robot now, and latch: sent at once, repeated until each has said that it has stopped."""
        self.stopped = True
        self._stops += 1
        for link in self.links.values():
            if link.nonce != 0:
                self._send(link, link.command(FrameType.ESTOP)[1])
        self._note("EMERGENCY STOP")
        self._end_run()

    async def rearm(self) -> list[Outcome]:
        """Release the latch here and on every robot that is in ESTOP or FAULT; all are in HOLD afterwards.

        A robot's last report may be older than the stop: it may still run, or stop only after a release that passed it by. So
        each says first that it has stopped; while one does not, or when a stop is asked for meanwhile, the latch stays.
        """
        stops = self._stops
        if self.stopped:
            stopping = await self._all(self._present(), FrameType.ESTOP, lambda _: b"", lambda status: status.state == RobotState.ESTOP)
            if not all(outcome.done for outcome in stopping):
                self._note("rearm given up: " + "; ".join(f"{outcome.robot} {outcome.reason}" for outcome in stopping if not outcome.done))
                return stopping
            if stops != self._stops:
                return [Outcome(outcome.robot, False, "was stopped again meanwhile") for outcome in stopping]
        self.stopped = False
        self._note("rearm")
        links = [link for link in self._present() if link.status is not None and link.status.state in (RobotState.ESTOP, RobotState.FAULT)]
        return await self._all(links, FrameType.REARM, lambda _: b"", lambda status: status.state == RobotState.HOLD)

    async def hold(self) -> list[Outcome]:
        """Take every robot to HOLD and end the run."""
        self._end_run()
        links = [link for link in self._present() if link.status is not None and link.status.state in (RobotState.HOLD, RobotState.RUN)]
        return await self._all(
            links, FrameType.STOP, lambda _: b"", lambda status: status.state == RobotState.HOLD and not status.start_pending
        )

    async def update(self, controllers: dict[str, tuple[float, float, float, float]]) -> list[Outcome]:
        """Load a controller on each named robot, under a version above all that the fleet has.

        Raises:
            FleetError: For a name that the fleet does not have, or numbers that are none.
        """
        by_name = {link.entry.name: link for link in self.links.values()}
        for name, genes in controllers.items():
            if name not in by_name:
                raise FleetError(f"robot {name!r} is not in the fleet; expected {', '.join(by_name)}")
            if len(genes) != 4 or not all(math.isfinite(gene) and abs(gene) < 100 for gene in genes):
                raise FleetError(f"controller {genes} of {name}; expected four numbers v0, w0, v1, w1 in m/s and rad/s")
        version = 1 + max((link.status.version for link in self.links.values() if link.status is not None), default=0)
        links = [by_name[name] for name in controllers]
        return await self._all(
            links,
            FrameType.CONTROLLER,
            lambda link: frames.controller(version, controllers[link.entry.name]),
            lambda status: status.version == version,
        )

    async def start(self, delay: float = START_DELAY) -> list[Outcome]:
        """Start every robot at the same time, ``delay`` seconds from now, each told in its own clock; all of them or none.

        Raises:
            FleetError: When a robot is missing, not in HOLD, without the fleet's controller, or the delay is out of range.
        """
        if not 0.1 <= delay <= 9.0:
            raise FleetError(f"start delay {delay} s; expected 0.1 to 9")
        versions = self._check_start()
        at_us = server_us() + round(delay * 1e6)
        if self.log is not None:
            self.run = self.log.start(at_us)
        outcomes = await self._all(
            list(self.links.values()),
            FrameType.START,
            lambda link: frames.start(at_us + link.clock.middle, versions[link.entry.number]),
            lambda status: status.start_pending or status.state == RobotState.RUN,
            give_up=delay,
        )
        if not all(outcome.done for outcome in outcomes):
            self._note("start given up: " + "; ".join(f"{outcome.robot} {outcome.reason}" for outcome in outcomes if not outcome.done))
            await self.hold()
        return outcomes

    def _check_start(self) -> dict[int, int]:
        """Versions of the loaded controllers by robot number, when all may start."""
        if self.stopped:
            raise FleetError("start refused: the emergency stop is latched; rearm first")
        versions: dict[int, int] = {}
        for number, link in self.links.items():
            if not link.connected(server_us()) or link.status is None:
                raise FleetError(f"start refused: {link.entry.name} is not connected; switch it on or take it out of the fleet file")
            if link.status.state != RobotState.HOLD:
                raise FleetError(f"start refused: {link.entry.name} is in {link.status.state.name}; every robot must be in HOLD")
            if link.status.version == 0:
                raise FleetError(f"start refused: {link.entry.name} has no controller; update first")
            versions[number] = link.status.version
        return versions

    def pose(self, robot: str, x: float, y: float, theta: float, age: float = 0.0) -> None:
        """Take a pose from a tracker, m and rad, ``age`` seconds old, for the log.

        Raises:
            FleetError: For a robot that the fleet does not have, or numbers that are none.
        """
        if robot not in {entry.name for entry in self.fleet.robots}:
            raise FleetError(f"pose of {robot!r}, which is not in the fleet; expected {', '.join(e.name for e in self.fleet.robots)}")
        if not all(math.isfinite(number) for number in (x, y, theta, age)):
            raise FleetError(f"pose {(x, y, theta, age)} of {robot}; expected finite numbers x, y, theta, age")
        if self.log is not None:
            self.log.pose(robot, x, y, theta, server_us() - round(age * 1e6))

    def _end_run(self) -> None:
        self.run = None
        if self.log is not None:
            self.log.stop(server_us())

    # --- what commands are made of -----------------------------------------------------------------------------------

    def _present(self) -> Iterable[RobotLink]:
        now = server_us()
        return [link for link in self.links.values() if link.connected(now)]

    async def _all(
        self,
        links: Iterable[RobotLink],
        kind: FrameType,
        payload: Callable[[RobotLink], bytes],
        achieved: Callable[[Status], bool],
        give_up: float = GIVE_UP,
    ) -> list[Outcome]:
        return list(await asyncio.gather(*(self._one(link, kind, payload(link), achieved, give_up) for link in links)))

    async def _one(self, link: RobotLink, kind: FrameType, payload: bytes, achieved: Callable[[Status], bool], give_up: float) -> Outcome:
        """Repeat a command under new sequence numbers until the robot shows, or says, what became of it."""
        name, deadline = link.entry.name, time.monotonic() + give_up
        sent: list[int] = []
        while time.monotonic() < deadline:
            if link.nonce == 0:
                return Outcome(name, False, "is not connected")
            sequence, datagram = link.command(kind, payload)
            sent.append(sequence)
            self._send(link, datagram)
            self._arrivals[link.entry.number].clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._arrivals[link.entry.number].wait(), RESEND)
            status = link.status
            if status is None or status.last_sequence < sent[0]:
                continue
            if achieved(status):
                return Outcome(name, True, "done")
            if status.result_sequence in sent and status.result not in PASSING:
                return Outcome(name, False, f"refused: {status.result.name.lower().replace('_', ' ')}, in {status.state.name}")
        return Outcome(name, False, f"did not answer within {give_up:g} s")

    # --- what is shown -----------------------------------------------------------------------------------------------

    def snapshot(self) -> dict[str, Any]:
        """The fleet as plain data, for the page and the command line."""
        now = server_us()
        return {
            "fleet": self.fleet.name,
            "stopped": self.stopped,
            "run": self.run,
            "robots": [self._describe(link, now) for link in self.links.values()],
            "events": self.events[-20:],
        }

    def _describe(self, link: RobotLink, now_us: int) -> dict[str, Any]:
        status = link.status
        described: dict[str, Any] = {"name": link.entry.name, "connected": link.connected(now_us)}
        if status is None:
            return described | {"state": "UNKNOWN"}
        return described | {
            "state": status.state.name,
            "reason": REASONS[status.reason],
            "faults": [fault.name for fault in status.faults],
            "start_pending": status.start_pending,
            "detected": status.seen,
            "range": status.range,
            "battery": status.battery,
            "battery_low": status.battery_low,
            "version": status.version,
            "v": status.v,
            "omega": status.omega,
            "x": status.x,
            "y": status.y,
            "theta": status.theta,
            "lease": status.lease_us / 1e6,
            "silent": (now_us - link.heard_us) / 1e6,
            "round_trip": link.clock.round_trip_us / 1e6,
            "refused": status.refused,
        }
