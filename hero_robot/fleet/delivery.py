"""Commands on their way: each is repeated until its robot has said what became of it. No sockets, and no clock but the caller's."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

from hero_robot.fleet.frames import FrameType, Result, Status
from hero_robot.fleet.robot_link import RobotLink

RESEND_US = 20_000
"""Time between repetitions of a command that is not yet acknowledged, us."""

NOT_FINAL = (Result.DONE, Result.NO_LEASE)
"""Answers that do not end a command: a robot that has just become ready gets its lease with the next heartbeat."""


@dataclass(frozen=True)
class Outcome:
    """What became of a command at one robot."""

    robot: str
    done: bool
    reason: str


@dataclass(frozen=True)
class Command:
    """What is asked of one robot."""

    kind: FrameType
    payload: bytes
    achieved: Callable[[Status], bool]
    """Whether a report shows that the command has had its effect."""


class Delivery:
    """One command for one robot, repeated under new sequence numbers until the robot shows, or says, what became of it.

    Args:
        link: The robot.
        command: What is asked of it.
        now_us: Server time, us; the command is due at once.
        give_up_us: Time after which it counts as lost, us.
    """

    def __init__(self, link: RobotLink, command: Command, now_us: int, give_up_us: int) -> None:
        self.link, self.command = link, command
        self.outcome: Outcome | None = None
        self.next_us = now_us
        self._give_up_us, self._deadline_us = give_up_us, now_us + give_up_us
        self._sent: list[int] = []

    def advance(self, now_us: int) -> bytes | None:
        """Look at the robot's last report and repeat the command when that is due; the datagram to be sent, if any."""
        if self.outcome is not None or now_us < self.next_us:
            return None
        self.outcome = self._answer() or self._end(now_us)
        if self.outcome is not None:
            return None
        sequence, datagram = self.link.command(self.command.kind, self.command.payload)
        self._sent.append(sequence)
        self.next_us = now_us + RESEND_US
        return datagram

    def _answer(self) -> Outcome | None:
        """What the robot's last report says about the command; None when it is older than that."""
        status = self.link.status
        if status is None or not self._sent or status.last_sequence < self._sent[0]:
            return None
        if self.command.achieved(status):
            return self._outcome(True, "done")
        if status.result_sequence in self._sent and status.result not in NOT_FINAL:
            return self._outcome(False, f"refused: {status.result.name.lower().replace('_', ' ')}, in {status.state.name}")
        return None

    def _end(self, now_us: int) -> Outcome | None:
        """Why the command is not sent again; None when it is."""
        if now_us >= self._deadline_us:
            return self._outcome(False, f"did not answer within {self._give_up_us / 1e6:g} s")
        return self._outcome(False, "is not connected") if self.link.nonce == 0 else None

    def _outcome(self, done: bool, reason: str) -> Outcome:
        return Outcome(self.link.entry.name, done, reason)


Stages = Generator[list[Delivery], list[Outcome], list[Outcome]]
"""Yields the deliveries of a stage, is sent what became of them, returns what the operator is told."""


class Operation:
    """A command to the fleet, in stages: each begins when every delivery of the one before has come to its end.

    Args:
        stages: Gives the deliveries of the first stage, and of each next one for the outcomes of the one before.
    """

    def __init__(self, stages: Stages) -> None:
        self.outcomes: list[Outcome] | None = None
        """What became of it, by robot; None while it is under way."""
        self.deliveries = next(stages)
        self._stages = stages

    @property
    def next_us(self) -> int:
        """Server time at which :meth:`advance` has something to do, us."""
        return min((delivery.next_us for delivery in self.deliveries if delivery.outcome is None), default=0)

    def report_came(self, link: RobotLink, now_us: int) -> None:
        """Note that this robot has reported: what is under way to it may have come to its end."""
        for delivery in self.deliveries:
            if delivery.link is link:
                delivery.next_us = min(delivery.next_us, now_us)

    def advance(self, now_us: int) -> list[tuple[RobotLink, bytes]]:
        """Do what is due; the datagrams to be sent."""
        sent: list[tuple[RobotLink, bytes]] = []
        while self.outcomes is None:
            for delivery in self.deliveries:
                datagram = delivery.advance(now_us)
                if datagram is not None:
                    sent.append((delivery.link, datagram))
            ended = [delivery.outcome for delivery in self.deliveries if delivery.outcome is not None]
            if len(ended) < len(self.deliveries):
                break
            try:
                self.deliveries = self._stages.send(ended)
            except StopIteration as last:
                self.outcomes = last.value
        return sent
