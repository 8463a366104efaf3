"""The server's end of the link to one robot: session, clocks, commands and their acknowledgement. No sockets, no clock."""

from __future__ import annotations

import secrets
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from hero_robot.fleet import frames
from hero_robot.fleet.fleet_file import RobotEntry
from hero_robot.fleet.frames import Frame, FrameType, Status

WINDOW_US = 30_000_000
"""Age, us, after which a measurement of the clocks is forgotten: 30 s at 100 ppm is 3 ms of drift."""

CONNECTION_TIMEOUT_US = 500_000
"""A robot that has been silent for longer, us, is not connected."""

CHALLENGES = 8
"""Hellos that may be under way at once."""


@dataclass
class ClockEstimate:
    """Offset of a robot's clock: robot time minus server time.

    ``lower_bound_us`` is what the truth cannot be below: a report that took no time at all would give it. Leases are
    counted with it, so that time on the way shortens them and can never lengthen them. ``offset_us`` halves the quickest
    round trip: the best estimate, for synchronised starts and time stamps.
    """

    bounds: deque[tuple[int, int]] = field(default_factory=deque)
    round_trips: deque[tuple[int, int, int]] = field(default_factory=deque)

    def take_report(self, robot_us: int, received_us: int) -> None:
        """Take the time in a report."""
        self.bounds.append((received_us, robot_us - received_us))
        while self.bounds[0][0] < received_us - WINDOW_US:
            self.bounds.popleft()
        while len(self.bounds) > 400:  # twenty seconds at full rate
            self.bounds.popleft()

    def take_round_trip(self, robot_us: int, sent_us: int, received_us: int) -> None:
        """Take a round trip: asked, answered, received."""
        self.round_trips.append((received_us, received_us - sent_us, robot_us - (sent_us + received_us) // 2))
        while self.round_trips[0][0] < received_us - WINDOW_US:
            self.round_trips.popleft()

    @property
    def lower_bound_us(self) -> int:
        """Lower bound of robot time minus server time, us."""
        return max(bound for _, bound in self.bounds)

    @property
    def offset_us(self) -> int:
        """Best estimate of robot time minus server time, us."""
        return min(self.round_trips, key=lambda trip: trip[1])[2]

    @property
    def round_trip_us(self) -> int:
        """Quickest recent round trip, us."""
        return min(trip[1] for trip in self.round_trips)


class RobotLink:
    """One robot as its server knows it; every method takes the server's time in us.

    Args:
        entry: The robot.
        random_bits: Draws a number of so many bits, for challenges.
    """

    def __init__(self, entry: RobotEntry, random_bits: Callable[[int], int] = secrets.randbits) -> None:
        self.entry = entry
        self._random_bits = random_bits
        self.nonce = 0
        self.sequence = 0
        self.report_sequence = 0
        self.status: Status | None = None
        self.heard_us = -(10**12)
        self.refused = 0
        self.clock = ClockEstimate()
        self._challenges: dict[int, int] = {}

    def connected(self, now_us: int) -> bool:
        """Whether there is a session and the robot has been heard lately."""
        return self.nonce != 0 and now_us - self.heard_us < CONNECTION_TIMEOUT_US

    def hello(self, now_us: int) -> bytes:
        """A datagram that asks who is there; measures the round trip as well."""
        challenge = self._random_bits(64)
        self._challenges[challenge] = now_us
        while len(self._challenges) > CHALLENGES:
            del self._challenges[next(iter(self._challenges))]
        return frames.seal(self.entry.key, Frame(FrameType.HELLO, self.entry.number, 0, 0, frames.hello(challenge)))

    def command(self, kind: FrameType, payload: bytes = b"") -> tuple[int, bytes]:
        """The next sequence number and the datagram of a command in this session."""
        self.sequence += 1
        return self.sequence, frames.seal(self.entry.key, Frame(kind, self.entry.number, self.nonce, self.sequence, payload))

    def heartbeat(self, now_us: int, lease: float) -> bytes:
        """A grant of motion until ``lease`` seconds from now, told in the robot's own time."""
        until = max(0, now_us + self.clock.lower_bound_us + round(lease * 1e6))
        return self.command(FrameType.HEARTBEAT, frames.heartbeat(until))[1]

    def receive(self, datagram: bytes, now_us: int) -> Status | None:
        """Take a datagram; the status in it, when it is authentic, of this boot and new."""
        frame = frames.unseal(self.entry.key, datagram)
        if frame is None or frame.robot != self.entry.number:
            self.refused += 1
            return None
        status = self._welcome(frame, now_us) if frame.kind == FrameType.WELCOME else self._report(frame)
        if status is None:
            self.refused += 1
            return None
        self.report_sequence = frame.sequence
        self.clock.take_report(status.time_us, now_us)
        self.status, self.heard_us = status, now_us
        return status

    def _report(self, frame: Frame) -> Status | None:
        if frame.kind != FrameType.STATUS or frame.nonce != self.nonce or frame.sequence <= self.report_sequence:
            return None
        return frames.read_status(frame.payload)

    def _welcome(self, frame: Frame, now_us: int) -> Status | None:
        """An answer to one of our own challenges: the only way into a session, so that no recorded boot can come back."""
        sent_us = self._challenges.pop(int.from_bytes(frame.payload[:8], "little"), None)
        status = frames.read_status(frame.payload[8:])
        if sent_us is None or status is None or (frame.nonce == self.nonce and frame.sequence <= self.report_sequence):
            return None
        if frame.nonce != self.nonce:
            self.nonce, self.sequence, self.clock = frame.nonce, status.last_sequence, ClockEstimate()
        self.sequence = max(self.sequence, status.last_sequence)
        self.clock.take_round_trip(status.time_us, sent_us, now_us)
        return status
