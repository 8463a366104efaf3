"""Frames of the link, written from the layout in ``firmware/core/hero_frame.h`` and ``hero_report.h``, with Python's own hmac.

Nothing here is shared with the firmware's code: that both read each other's frames is a test of both.
"""

from __future__ import annotations

import enum
import hashlib
import hmac
import math
import struct
from dataclasses import dataclass

MAGIC = b"HF"
PROTOCOL = 1
FIX_ONE = 65536
"""One, as Q16.16."""

TAG_SIZE = 32
_HEADER = struct.Struct("<2sBBHHQI")
_STATUS = struct.Struct("<QBBBBIIBHHIiiiiIiiIH")


class FrameType(enum.IntEnum):
    """What a frame asks or says; from 0x80 on it comes from the robot."""

    HELLO = 0x01
    HEARTBEAT = 0x02
    START = 0x03
    STOP = 0x04
    ESTOP = 0x05
    REARM = 0x06
    CONTROLLER = 0x07
    WELCOME = 0x81
    STATUS = 0x82


class RobotState(enum.IntEnum):
    """States of the robot's supervisor."""

    BOOT = 0
    HOLD = 1
    RUN = 2
    ESTOP = 3
    FAULT = 4


class Result(enum.IntEnum):
    """What became of a command."""

    DONE = 0
    WRONG_STATE = 1
    OUT_OF_RANGE = 2
    OLD_VERSION = 3
    WRONG_VERSION = 4
    TOO_LATE = 5
    TOO_FAR = 6
    NO_LEASE = 7
    FAULT_STAYS = 8


class Fault(enum.IntFlag):
    """Why a robot is in FAULT."""

    SETTINGS = 1
    BATTERY = 2
    SENSOR = 4
    STALL = 8


@dataclass(frozen=True)
class Frame:
    """A frame whose tag has been checked, or is to be written."""

    kind: int
    """A :class:`FrameType`, or a number that is none."""
    robot: int
    nonce: int
    sequence: int
    payload: bytes = b""


def seal(key: bytes, frame: Frame) -> bytes:
    """The datagram of a frame, tagged under the robot's key."""
    header = _HEADER.pack(MAGIC, PROTOCOL, frame.kind, frame.robot, len(frame.payload), frame.nonce, frame.sequence)
    body = header + frame.payload
    return body + hmac.new(key, body, hashlib.sha256).digest()


def robot_of(datagram: bytes) -> int | None:
    """The robot number that a datagram claims, or None when it is no frame."""
    if len(datagram) < _HEADER.size + TAG_SIZE:
        return None
    magic, protocol, _, robot, size, _, _ = _HEADER.unpack_from(datagram)
    if magic != MAGIC or protocol != PROTOCOL or size != len(datagram) - _HEADER.size - TAG_SIZE:
        return None
    return int(robot)


def unseal(key: bytes, datagram: bytes) -> Frame | None:
    """The frame in a datagram, or None when it is not one under this key."""
    if robot_of(datagram) is None:
        return None
    body, tag = datagram[:-TAG_SIZE], datagram[-TAG_SIZE:]
    if not hmac.compare_digest(tag, hmac.new(key, body, hashlib.sha256).digest()):
        return None
    _, _, kind, robot, _, nonce, sequence = _HEADER.unpack_from(body)
    return Frame(kind, robot, nonce, sequence, body[_HEADER.size :])


def hello(challenge: int) -> bytes:
    """Payload of a HELLO."""
    return struct.pack("<Q", challenge)


def heartbeat(until_us: int) -> bytes:
    """Payload of a HEARTBEAT: motion is granted until this robot time, us."""
    return struct.pack("<Q", until_us)


def start(at_us: int, version: int) -> bytes:
    """Payload of a START: robot time, us, and version of the controller that must be loaded."""
    return struct.pack("<QI", at_us, version)


def controller(version: int, genes: tuple[float, float, float, float]) -> bytes:
    """Payload of a CONTROLLER: [v0, w0, v1, w1] in m/s and rad/s."""
    return struct.pack("<I4i", version, *(round(gene * FIX_ONE) for gene in genes))


@dataclass(frozen=True)
class Status:
    """A robot's account of itself."""

    time_us: int
    """Robot time, us since power-on."""
    state: RobotState
    reason: int
    """Why the state changed last: see :data:`REASONS`."""
    faults: Fault
    seen: bool
    """The detection that the controller acts on."""
    leased: bool
    start_pending: bool
    battery_low: bool
    last_sequence: int
    """Sequence of the last accepted command."""
    result_sequence: int
    """Sequence of the last command that was no heartbeat."""
    result: Result
    """What became of it."""
    battery: float
    """V."""
    range: float
    """m, 0 when nothing is there."""
    version: int
    """Of the loaded controller; 0: none."""
    v: float
    """Commanded forward speed, m/s."""
    omega: float
    """Commanded turn rate, rad/s."""
    x: float
    """Odometry, m."""
    y: float
    """Odometry, m."""
    theta: float
    """Odometry, rad in [0, 2 pi)."""
    left: float
    """Measured rim speed, m/s."""
    right: float
    """Measured rim speed, m/s."""
    lease_us: int
    """Time until the lease ends, us."""
    refused: int
    """Frames that the robot has refused since boot."""


REASONS = ("boot", "self-test passed", "started", "stopped", "lease ended", "emergency stop", "rearmed", "fault")
"""Names of ``Status.reason``."""


def read_status(payload: bytes) -> Status | None:
    """The status in a payload, or None when it is not one."""
    if len(payload) != _STATUS.size:
        return None
    time_us, state, reason, faults, flags, last, result_of, result, battery, distance, version, *motion = _STATUS.unpack(payload)
    v, omega, x, y, heading, left, right, lease, refused = motion
    if state not in set(RobotState) or result not in set(Result) or reason >= len(REASONS):
        return None
    return Status(
        time_us=time_us,
        state=RobotState(state),
        reason=reason,
        faults=Fault(faults),
        seen=bool(flags & 1),
        leased=bool(flags & 2),
        start_pending=bool(flags & 4),
        battery_low=bool(flags & 8),
        last_sequence=last,
        result_sequence=result_of,
        result=Result(result),
        battery=battery / 1e3,
        range=distance / 1e3,
        version=version,
        v=v / FIX_ONE,
        omega=omega / FIX_ONE,
        x=x / 2**24,
        y=y / 2**24,
        theta=heading / 2**32 * math.tau,
        left=left / FIX_ONE,
        right=right / FIX_ONE,
        lease_us=lease,
        refused=refused,
    )
