"""One simulated board with the robot's own code on it, for tests, displays and :class:`~hero_robot.firmware.FirmwareSwarm`."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path

from hero_robot.firmware.constants import FIX_ONE
from hero_robot.firmware.library import load

DATAGRAM_ROOM = 512
"""Bytes of room for a datagram: more than any frame has."""


class State(enum.IntEnum):
    """States of the supervisor, as ``hero_supervisor.h`` numbers them."""

    BOOT = 0
    HOLD = 1
    RUN = 2
    ESTOP = 3
    FAULT = 4


class Fault(enum.IntFlag):
    """Causes of FAULT, as ``hero_supervisor.h`` numbers them."""

    SETTINGS = 1
    BATTERY = 2
    SENSOR = 4
    STALL = 8


@dataclass(frozen=True)
class BoardView:
    """The inside of a board at one time."""

    now_us: int
    """Time since power-on, us."""
    nonce: int
    """Boot nonce; 0 while there is none."""
    lease_us: int
    """Robot time at which the granted motion ends, us; 0 without a lease."""
    last_sequence: int
    """Sequence of the last accepted command."""
    version: int
    """Version of the loaded controller; 0: none."""
    result: int
    """What became of the last command that was no heartbeat (``hero_result``)."""
    result_sequence: int
    """Sequence of that command."""
    state: State
    """State of the supervisor."""
    reason: int
    """Why the state changed last (``hero_reason``)."""
    faults: Fault
    """Faults present now."""
    seen: bool
    """The debounced detection."""
    start_pending: bool
    """A start has been accepted and its time has not come."""
    may_move: bool
    """RUN, and the lease has not ended."""
    range_mm: int
    """Last distance read, mm; 0: nothing there."""
    refused: int
    """Frames refused since boot."""
    pulse_us: tuple[int, int]
    """Servo pulses, left and right, us; 0: released."""
    edges: tuple[int, int]
    """Encoder edges, left and right."""
    path: tuple[float, float]
    """Path of the wheels' rims, m."""
    rim_speed: tuple[float, float]
    """Rim speeds of the servos, m/s."""
    measured: tuple[float, float]
    """Rim speeds that the firmware believes in, m/s."""
    command: tuple[float, float]
    """Motion that the controller asks for, m/s and rad/s."""
    x: float
    """Odometry, m."""
    y: float
    """Odometry, m."""
    heading: int
    """Odometry, binary angle: 2^32 is one turn."""

    @property
    def released(self) -> bool:
        """Neither servo gets pulses."""
        return self.pulse_us == (0, 0)


class SimulatedBoard:
    """A board with the firmware, simulated servos, encoders, range sensor, battery and a mailbox in place of the radio.

    Args:
        robot: Robot number.
        key: Its 32-byte key.
        seed: Of its nonces and of where its wheels stand within an encoder tick.
        robot_file: The robot whose constants are compiled in.
    """

    def __init__(self, robot: int, key: bytes, seed: int = 0, robot_file: str | Path = "hero_plus") -> None:
        self.library, self.ffi = load(robot_file)
        self._memory = self.ffi.new("uint64_t[]", (self.library.hero_sim_size() + 7) // 8)
        self.pointer = self.ffi.cast("struct hero_sim *", self._memory)
        self.robot, self.key, self.seed = robot, key, seed
        self._buffer = self.ffi.new("uint8_t[]", DATAGRAM_ROOM)
        self.library.hero_sim_init(self.pointer, robot, key, seed)

    def boot(self) -> None:
        """Switch the board on, or off and on again."""
        self.library.hero_sim_boot(self.pointer)

    def run(self, seconds: float) -> None:
        """Let time pass, s."""
        self.library.hero_sim_run(self.pointer, self.view().now_us + round(seconds * 1e6))

    def deliver(self, datagram: bytes) -> bool:
        """Put a datagram into the inbox; false when it is full."""
        return bool(self.library.hero_sim_deliver(self.pointer, datagram, len(datagram)))

    def collect(self) -> list[bytes]:
        """Take all datagrams that the robot has sent."""
        found = []
        while size := self.library.hero_sim_collect(self.pointer, self._buffer, DATAGRAM_ROOM):
            found.append(bytes(self.ffi.buffer(self._buffer, size)))
        return found

    def start(self, genes: tuple[float, float, float, float]) -> bool:
        """Boot, load the controller [v0, w0, v1, w1] and start; false when the firmware refused it."""
        return bool(self.library.hero_sim_start(self.pointer, [round(gene * FIX_ONE) for gene in genes]))

    def set(self, *, distance: float = 0.0, battery: float = 3.7, sensor_dead: bool = False) -> None:
        """What stands before the sensor (m, 0: nothing), the cell's voltage (V), and whether the sensor answers."""
        self.library.hero_sim_set(self.pointer, distance, round(battery * 1e3), sensor_dead)

    def set_halts(self, left_us: int, right_us: int) -> None:
        """Halt pulses of the servos, us, as built and as the board's settings say; before boot."""
        self.library.hero_sim_set_halts(self.pointer, left_us, right_us)

    def view(self) -> BoardView:
        """Look inside."""
        raw = self.ffi.new("struct hero_sim_view *")
        self.library.hero_sim_look(self.pointer, raw)
        return BoardView(
            now_us=raw.now_us,
            nonce=raw.nonce,
            lease_us=raw.lease_us,
            last_sequence=raw.last_sequence,
            version=raw.version,
            result=raw.result,
            result_sequence=raw.result_sequence,
            state=State(raw.state),
            reason=raw.reason,
            faults=Fault(raw.faults),
            seen=raw.seen,
            start_pending=raw.start_pending,
            may_move=raw.may_move,
            range_mm=raw.range_mm,
            refused=raw.refused,
            pulse_us=tuple(raw.pulse_us),
            edges=tuple(raw.edges),
            path=tuple(raw.path),
            rim_speed=tuple(raw.rim_speed),
            measured=(raw.measured[0] / FIX_ONE, raw.measured[1] / FIX_ONE),
            command=(raw.command[0] / FIX_ONE, raw.command[1] / FIX_ONE),
            x=raw.x / 2**24,
            y=raw.y / 2**24,
            heading=raw.heading,
        )
