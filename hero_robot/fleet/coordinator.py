"""What the fleet's server does: leases, emergency stop, synchronised start, controller update.

A function of a clock and of the frames that come in: no sockets, no threads, no waiting. :class:`~hero_robot.fleet.FleetServer` runs
it on a UDP socket and the machine's clock, a test on simulated time.

Safety rests on the robots, not on this program: a robot moves only under a lease that this program renews, so whatever happens
to it, to its machine or to the network, robots stop within the lease.
"""

from __future__ import annotations

import math
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterable

from hero_robot.fleet import frames
from hero_robot.fleet.delivery import RESEND_US, Command, Delivery, Operation, Outcome, Stages
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet, RobotEntry
from hero_robot.fleet.frames import REASONS, FrameType, RobotState, Status
from hero_robot.fleet.robot_link import RobotLink
from hero_robot.fleet.run_log import RunLog

GIVE_UP_US = 1_500_000
"""Time after which a command that is not acknowledged counts as lost, us."""

HELLO_US = 1_000_000
"""Time between measurements of the clocks, us; a robot that is not heard is asked four times as often."""

MISSED_US = 160_000
"""Silence, us, of three reports: the robot may have booted again."""

START_DELAY = 0.6
"""Time from asking for a start to the start, s: room for lost frames."""

PRESSES = 64
"""Presses of stop buttons that are remembered, to know a repeated request."""

LONG_AGO_US = -(10**12)

Genes = tuple[float, float, float, float]


def _in_hold(status: Status) -> bool:
    return status.state == RobotState.HOLD


def _failures(outcomes: list[Outcome]) -> str:
    return "; ".join(f"{outcome.robot} {outcome.reason}" for outcome in outcomes if not outcome.done)


class FleetCoordinator:
    """Keeps the link to every robot of a fleet.

    Every method that takes ``now_us``, the server's time in us, which never falls, may put datagrams into the outbox. Whoever runs
    this sends them (:meth:`take_outbox`), hands over what comes in (:meth:`receive`) and calls :meth:`advance` at ``next_us``.

    Args:
        fleet: Robots, addresses, keys, lease.
        log: Where runs are logged, if anywhere.
        wall_clock: The time of day that events are recorded with.
        random_bits: Draws a number of so many bits, for the challenges that begin a session.
    """

    def __init__(
        self,
        fleet: Fleet,
        log: RunLog | None = None,
        *,
        wall_clock: Callable[[], time.struct_time] = time.localtime,
        random_bits: Callable[[int], int] = secrets.randbits,
    ) -> None:
        self.fleet, self.log = fleet, log
        self.links = {entry.number: RobotLink(entry, random_bits) for entry in fleet.robots}
        self.stopped = False
        """Latched by :meth:`estop`: no heartbeat is sent until :meth:`rearm`."""
        self.run: str | None = None
        """Name of the run that is under way and logged."""
        self.events: list[str] = []
        """What an operator should know, newest last."""
        self._wall_clock = wall_clock
        self._now_us = LONG_AGO_US
        self._heartbeat_us = LONG_AGO_US
        self._hello_us = dict.fromkeys(self.links, LONG_AGO_US)
        self._estops = 0
        self._presses: deque[str] = deque(maxlen=PRESSES)
        self._operations: list[Operation] = []
        self._outbox: list[tuple[RobotEntry, bytes]] = []

    # --- driven by a clock and a socket ------------------------------------------------------------------------------

    @property
    def next_us(self) -> int:
        """Server time at which :meth:`advance` has to be called, us."""
        return min([self._heartbeat_us, *(operation.next_us for operation in self._operations)])

    def take_outbox(self) -> list[tuple[RobotEntry, bytes]]:
        """The datagrams that have to be sent now, and to whom."""
        taken, self._outbox = self._outbox, []
        return taken

    def advance(self, now_us: int) -> None:
        """Do what is due at this time."""
        self._now_us = now_us
        if now_us >= self._heartbeat_us:
            self._renew_leases()
        self._advance_operations()

    def receive(self, datagram: bytes, now_us: int) -> None:
        """Take a robot's report; whose it is, its tag decides, not its address."""
        self._now_us = now_us
        number = frames.robot_of(datagram)
        link = self.links.get(number) if number is not None else None
        if link is None:
            return
        before = link.status
        status = link.receive(datagram, now_us)
        if status is None:
            return
        self._record_change(link, before, status)
        if self.log is not None:
            self.log.report(link.entry.name, status, status.time_us - link.clock.offset_us)
        for operation in self._operations:
            operation.report_came(link, now_us)
        self._advance_operations()

    def _advance_operations(self) -> None:
        for operation in self._operations:
            for link, datagram in operation.advance(self._now_us):
                self._send(link, datagram)
        self._operations = [operation for operation in self._operations if operation.outcomes is None]

    def _send(self, link: RobotLink, datagram: bytes) -> None:
        self._outbox.append((link.entry, datagram))

    def _renew_leases(self) -> None:
        """Renew every lease, look for robots that are not there, repeat the emergency stop until each has it."""
        for link in self.links.values():
            self._look_for(link)
            if not link.connected(self._now_us):
                continue
            if not self.stopped:
                self._send(link, link.heartbeat(self._now_us, self.fleet.lease))
            elif link.status is not None and link.status.state != RobotState.ESTOP:
                self._send(link, link.command(FrameType.ESTOP)[1])
        self._heartbeat_us = self._now_us + (RESEND_US if self.stopped else round(self.fleet.heartbeat * 1e6))

    def _look_for(self, link: RobotLink) -> None:
        missed = self._now_us - link.heard_us > MISSED_US
        if self._now_us - self._hello_us[link.entry.number] >= (HELLO_US // 4 if missed else HELLO_US):
            self._hello_us[link.entry.number] = self._now_us
            self._send(link, link.hello(self._now_us))

    def _record_change(self, link: RobotLink, before: Status | None, status: Status) -> None:
        if before is None or before.state != status.state:
            faults = f" ({status.faults.name})" if status.state == RobotState.FAULT and status.faults else ""
            self._record(f"{link.entry.name}: {status.state.name}, {REASONS[status.reason]}{faults}")

    def _record(self, text: str) -> None:
        self.events.append(f"{time.strftime('%H:%M:%S', self._wall_clock())} {text}")
        del self.events[:-200]

    # --- commands ----------------------------------------------------------------------------------------------------

    def estop(self, now_us: int, press: str | None = None) -> None:
        """Stop every robot now, and latch: sent at once, repeated until each has said that it has stopped.

        Args:
            now_us: Server time, us.
            press: Names the press of a button, where a page asks several times for safety's sake: it stops each time and is recorded once.
        """
        self._now_us = now_us
        if not (self.stopped and press is not None and press in self._presses):
            self._record("EMERGENCY STOP")
        if press is not None:
            self._presses.append(press)
        self.stopped = True
        self._estops += 1
        for link in self.links.values():
            if link.nonce != 0:
                self._send(link, link.command(FrameType.ESTOP)[1])
        self._heartbeat_us = min(self._heartbeat_us, now_us + RESEND_US)
        self._end_run()

    def rearm(self, now_us: int) -> Operation:
        """Release the latch here and on every robot that is in ESTOP or FAULT; all are in HOLD afterwards.

        A robot's last report may be older than the stop: it may still run, or stop only after a release that passed it by. So
        each says first that it has stopped; while one does not, or when a stop is asked for meanwhile, the latch stays.
        """
        return self._begin(self._rearm(), now_us)

    def _rearm(self) -> Stages:
        estops = self._estops
        if self.stopped:
            stop = Command(FrameType.ESTOP, b"", lambda status: status.state == RobotState.ESTOP)
            stopping = yield self._deliveries(self._present(), lambda _: stop)
            if not all(outcome.done for outcome in stopping):
                self._record(f"rearm given up: {_failures(stopping)}")
                return stopping
            if estops != self._estops:
                return [Outcome(outcome.robot, False, "was stopped again meanwhile") for outcome in stopping]
        self.stopped = False
        self._record("rearm")
        release = Command(FrameType.REARM, b"", _in_hold)
        outcomes = yield self._deliveries(self._present(RobotState.ESTOP, RobotState.FAULT), lambda _: release)
        return outcomes

    def hold(self, now_us: int) -> Operation:
        """Take every robot to HOLD and end the run."""
        return self._begin(self._hold(), now_us)

    def _hold(self) -> Stages:
        self._end_run()
        stop = Command(FrameType.STOP, b"", lambda status: _in_hold(status) and not status.start_pending)
        outcomes = yield self._deliveries(self._present(RobotState.HOLD, RobotState.RUN), lambda _: stop)
        return outcomes

    def update(self, controllers: dict[str, Genes], now_us: int) -> Operation:
        """Load a controller on each named robot, under a version above all that the fleet has.

        Args:
            controllers: [v0, w0, v1, w1] in m/s and rad/s, by robot.
            now_us: Server time, us.

        Raises:
            FleetError: For a name that the fleet does not have, or numbers that are none.
        """
        by_name = {link.entry.name: link for link in self.links.values()}
        for name, genes in controllers.items():
            if name not in by_name:
                raise FleetError(f"robot {name!r} is not in the fleet; expected {', '.join(by_name)}")
            if len(genes) != 4 or not all(math.isfinite(gene) and abs(gene) < 100 for gene in genes):
                raise FleetError(f"controller {genes} of {name}; expected four numbers v0, w0, v1, w1 in m/s and rad/s")
        return self._begin(self._update({by_name[name]: genes for name, genes in controllers.items()}), now_us)

    def _update(self, controllers: dict[RobotLink, Genes]) -> Stages:
        version = 1 + max((link.status.version for link in self.links.values() if link.status is not None), default=0)

        def load(link: RobotLink) -> Command:
            return Command(FrameType.CONTROLLER, frames.controller(version, controllers[link]), lambda status: status.version == version)

        outcomes = yield self._deliveries(controllers, load)
        return outcomes

    def start(self, now_us: int, delay: float = START_DELAY) -> Operation:
        """Start every robot at the same time, ``delay`` seconds from now, each told in its own clock; all of them or none.

        Raises:
            FleetError: When a robot is missing, not in HOLD, without the fleet's controller, or the delay is out of range.
        """
        self._now_us = now_us
        if not 0.1 <= delay <= 9.0:
            raise FleetError(f"start delay {delay} s; expected 0.1 to 9")
        return self._begin(self._start(self._loaded_versions(), round(delay * 1e6)), now_us)

    def _start(self, versions: dict[int, int], delay_us: int) -> Stages:
        at_us = self._now_us + delay_us
        if self.log is not None:
            self.run = self.log.start(at_us)

        def begin(link: RobotLink) -> Command:
            return Command(
                FrameType.START,
                frames.start(at_us + link.clock.offset_us, versions[link.entry.number]),
                lambda status: status.start_pending or status.state == RobotState.RUN,
            )

        outcomes = yield self._deliveries(self.links.values(), begin, give_up_us=delay_us)
        if not all(outcome.done for outcome in outcomes):
            self._record(f"start given up: {_failures(outcomes)}")
            yield from self._hold()
        return outcomes

    def _loaded_versions(self) -> dict[int, int]:
        """Versions of the loaded controllers by robot number, when all may start."""
        if self.stopped:
            raise FleetError("start refused: the emergency stop is latched; rearm first")
        versions: dict[int, int] = {}
        for number, link in self.links.items():
            if not link.connected(self._now_us) or link.status is None:
                raise FleetError(f"start refused: {link.entry.name} is not connected; switch it on or take it out of the fleet file")
            if link.status.state != RobotState.HOLD:
                raise FleetError(f"start refused: {link.entry.name} is in {link.status.state.name}; every robot must be in HOLD")
            if link.status.version == 0:
                raise FleetError(f"start refused: {link.entry.name} has no controller; update first")
            versions[number] = link.status.version
        return versions

    def pose(self, robot: str, x: float, y: float, theta: float, taken_us: int) -> None:
        """Take a pose from a tracker, m and rad, of the server time ``taken_us``, us, for the log.

        Raises:
            FleetError: For a robot that the fleet does not have, or numbers that are none.
        """
        if robot not in {entry.name for entry in self.fleet.robots}:
            raise FleetError(f"pose of {robot!r}, which is not in the fleet; expected {', '.join(e.name for e in self.fleet.robots)}")
        if not all(math.isfinite(number) for number in (x, y, theta)):
            raise FleetError(f"pose {(x, y, theta)} of {robot}; expected finite numbers x, y, theta")
        if self.log is not None:
            self.log.pose(robot, x, y, theta, taken_us)

    def _end_run(self) -> None:
        self.run = None
        if self.log is not None:
            self.log.stop(self._now_us)

    # --- what commands are made of -----------------------------------------------------------------------------------

    def _begin(self, stages: Stages, now_us: int) -> Operation:
        self._now_us = now_us
        operation = Operation(stages)
        self._operations.append(operation)
        self._advance_operations()
        return operation

    def _present(self, *states: RobotState) -> list[RobotLink]:
        """The connected robots, or those of them that were last heard in one of these states."""
        present = [link for link in self.links.values() if link.connected(self._now_us)]
        return [link for link in present if not states or (link.status is not None and link.status.state in states)]

    def _deliveries(
        self, links: Iterable[RobotLink], command: Callable[[RobotLink], Command], give_up_us: int = GIVE_UP_US
    ) -> list[Delivery]:
        return [Delivery(link, command(link), self._now_us, give_up_us) for link in links]
