"""Model-based test of the supervisor: events in any order against the compiled core, through its link, beside a model of the rules.

The model knows only what the rules say about an authentic, fresh command; whatever else arrives must change nothing.
"""

from __future__ import annotations

import struct
from typing import Any

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from hero_robot.firmware import SimulatedBoard, State
from hero_robot.fleet import frames
from hero_robot.fleet.frames import Frame, FrameType

KEY = bytes(range(32))
LEASE_MAX = 500_000
HORIZON = 10_000_000
COMMANDS = [FrameType.HEARTBEAT, FrameType.START, FrameType.STOP, FrameType.ESTOP, FrameType.REARM, FrameType.CONTROLLER]
GENES = (0.05, 0.5, -0.05, -1.0)


class Supervisor(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.board = SimulatedBoard(7, KEY, 1)
        self.recorded: list[bytes] = []

    @initialize()
    def boot(self) -> None:
        self.board.set()
        self.board.boot()
        self.sequence = 0
        self.state = State.BOOT
        self.lease = self.version = self.granted = 0
        self.start: int | None = None
        self.advance(0.1)

    # --- the model ---------------------------------------------------------------------------------------------------

    def advance(self, seconds: float) -> None:
        """Let time pass a millisecond at a time, as the firmware is polled, and apply the rules at each."""
        for _ in range(round(seconds * 1e3)):
            self.board.run(1e-3)
            self.tick(self.board.view())

    def tick(self, view: Any) -> None:
        now = view.now_us
        if self.lease <= now:
            self.lease = 0
            if self.state == State.RUN:
                self.state = State.HOLD
            self.start = None
        if view.faults and self.state not in (State.ESTOP, State.FAULT):
            self.state, self.start, self.lease = State.FAULT, None, 0
        if self.state == State.BOOT and view.state != State.BOOT:
            self.state = State.HOLD
        if self.start is not None and now >= self.start:
            self.state, self.start = State.RUN, None

    def obey(self, kind: FrameType, number: int, version: int, good_genes: bool, now: int) -> None:
        """What the rules say about an authentic, fresh command."""
        holding, running = self.state == State.HOLD, self.state == State.RUN
        if kind == FrameType.ESTOP:
            self.state, self.start, self.lease = State.ESTOP, None, 0
        elif (kind == FrameType.STOP and (holding or running)) or (
            kind == FrameType.REARM and self.state in (State.ESTOP, State.FAULT) and not self.board.view().faults
        ):
            self.state, self.start = State.HOLD, None
        elif kind == FrameType.HEARTBEAT and (holding or running) and number > now:
            self.lease = min(number, now + LEASE_MAX)
        elif kind == FrameType.CONTROLLER and holding and self.start is None and version > self.version and good_genes:
            self.version = version
        elif kind == FrameType.START and holding and version == self.version > 0 and self.lease > now < number <= now + HORIZON:
            self.start = number
            self.granted += 1

    # --- events ------------------------------------------------------------------------------------------------------

    @rule(milliseconds=st.sampled_from([1, 5, 20, 100, 300, 499, 501, 900]))
    def time_passes(self, milliseconds: int) -> None:
        self.advance(milliseconds / 1e3)

    @rule(
        kind=st.sampled_from(COMMANDS),
        ahead=st.sampled_from([-5, 0, 2, 30, 200, 450, 700, 9_000, 11_000]),
        step=st.integers(0, 2),
        good_genes=st.booleans(),
        right_version=st.integers(0, 5),
    )
    def an_authentic_command(self, kind: FrameType, ahead: int, step: int, good_genes: bool, right_version: int) -> None:
        now = self.board.view().now_us + 1_000  # it is read at the next poll
        number = max(0, now + ahead * 1_000)
        version = self.version + (step if kind == FrameType.CONTROLLER or right_version == 0 else 0)
        genes = GENES if good_genes else (0.05, 3.2, 0.0, 0.0)
        payload = {
            FrameType.HEARTBEAT: frames.heartbeat(number),
            FrameType.START: frames.start(number, version),
            FrameType.CONTROLLER: frames.controller(version, genes),
        }.get(kind, b"")
        self.sequence += 1
        sealed = frames.seal(KEY, Frame(kind, 7, self.board.view().nonce, self.sequence, payload))
        self.recorded.append(sealed)
        self.board.deliver(sealed)
        # the robot obeys before it looks at the clock in the same poll
        faults_before = self.board.view()
        self.board.run(1e-3)
        assert self.board.view().now_us == now
        assert faults_before.now_us < now
        self.obey(kind, number, version, good_genes, now)
        self.tick(self.board.view())

    @rule()
    def a_whole_start(self) -> None:
        """What an operator does: rearm, load, lease, start."""
        for kind, ahead, step in [
            (FrameType.REARM, 0, 0),
            (FrameType.STOP, 0, 0),
            (FrameType.CONTROLLER, 0, 1),
            (FrameType.HEARTBEAT, 450, 0),
            (FrameType.START, 30, 0),
        ]:
            self.an_authentic_command(kind, ahead, step, True, 1)

    @rule()
    def an_emergency_stop_and_a_rearm(self) -> None:
        for kind in (FrameType.ESTOP, FrameType.REARM):
            self.an_authentic_command(kind, 0, 0, True, 1)

    @precondition(lambda self: self.recorded)
    @rule(choice=st.integers(0, 10**6))
    def a_recorded_frame_comes_again(self, choice: int) -> None:
        self.disturb(self.recorded[choice % len(self.recorded)])

    @rule(
        kind=st.sampled_from(COMMANDS),
        wrong=st.sampled_from(["key", "nonce", "robot", "sequence", "report", "bit"]),
        bit=st.integers(0, 10**6),
    )
    def a_false_frame(self, kind: FrameType, wrong: str, bit: int) -> None:
        now, nonce = self.board.view().now_us, self.board.view().nonce
        payload = {
            FrameType.HEARTBEAT: frames.heartbeat(now + 400_000),
            FrameType.START: frames.start(now + 2_000, max(self.version, 1)),
            FrameType.CONTROLLER: frames.controller(self.version + 1, GENES),
        }.get(kind, b"")
        frame = Frame(
            kind + (0x80 if wrong == "report" else 0),
            8 if wrong == "robot" else 7,
            nonce ^ (1 << bit % 64) if wrong == "nonce" else nonce,
            bit % (self.sequence + 1) if wrong == "sequence" else self.sequence + 1,
            payload,
        )
        sealed = bytearray(frames.seal(bytes(32) if wrong == "key" else KEY, frame))
        if wrong == "bit":
            sealed[bit % len(sealed)] ^= 1 << bit % 8
        self.disturb(bytes(sealed))

    @rule(rubbish=st.binary(max_size=200))
    def rubbish(self, rubbish: bytes) -> None:
        self.disturb(rubbish)

    def disturb(self, datagram: bytes) -> None:
        """Deliver what must change nothing."""
        before = self.board.view().last_sequence
        self.board.deliver(datagram)
        self.advance(1e-3)
        assert self.board.view().last_sequence == before

    @rule(kind=st.sampled_from(["sensor", "battery"]), seconds=st.sampled_from([0.1, 0.4, 2.2]))
    def a_part_breaks(self, kind: str, seconds: float) -> None:
        self.board.set(sensor_dead=kind == "sensor", battery=3.0 if kind == "battery" else 3.7)
        self.advance(seconds)

    @rule()
    def the_parts_are_mended(self) -> None:
        self.board.set()
        self.advance(0.1)

    @rule()
    def somebody_switches_it_off_and_on(self) -> None:
        self.boot()

    # --- what always holds -------------------------------------------------------------------------------------------

    @invariant()
    def the_model_and_the_robot_agree(self) -> None:
        view = self.board.view()
        assert view.state == self.state
        assert view.version == self.version
        assert view.lease_us == self.lease
        assert view.start_pending == (self.start is not None)

    @invariant()
    def it_moves_only_in_run_with_a_grant_and_a_lease(self) -> None:
        view = self.board.view()
        if view.state == State.RUN or not view.released:
            assert self.granted > 0
            assert view.version > 0
            assert view.now_us < view.lease_us <= view.now_us + LEASE_MAX
        if view.state != State.RUN:
            assert view.released


TestSupervisor = Supervisor.TestCase
TestSupervisor.settings = settings(
    max_examples=120, stateful_step_count=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)


def test_run_is_reached_by_an_operators_start() -> None:
    """The model test would be empty if nothing ever ran."""
    machine = Supervisor()
    machine.boot()
    machine.a_whole_start()
    machine.time_passes(100)
    assert machine.board.view().state == State.RUN
    machine.it_moves_only_in_run_with_a_grant_and_a_lease()
    assert not machine.board.view().released


def test_ten_thousand_false_frames_move_nothing() -> None:
    """Replays, forgeries, old nonces, wrong keys: none of 10,000 accepted, in HOLD, ESTOP and RUN."""
    machine = Supervisor()
    machine.boot()
    machine.a_whole_start()
    old_boot = list(machine.recorded)
    machine.somebody_switches_it_off_and_on()
    machine.a_whole_start()
    machine.recorded = old_boot + machine.recorded
    refused = 0
    for attempt in range(10_000):
        before = machine.board.view()
        kind, number = attempt % 4, attempt // 4
        if kind == 0:
            datagram = machine.recorded[number % len(machine.recorded)]
        else:
            key = bytes(31) + bytes([1]) if kind == 1 else KEY
            nonce = before.nonce + number + 1 if kind == 2 else before.nonce
            payload = struct.pack("<Q", before.now_us + 400_000)
            datagram = frames.seal(key, Frame(FrameType.HEARTBEAT, 7, nonce % 2**64, before.last_sequence + 1, payload))
            if kind == 3:  # a tag of chance
                datagram = datagram[:-32] + struct.pack("<4Q", *[number * 0x9E3779B97F4A7C15 % 2**64 + i for i in range(4)])
        machine.board.deliver(datagram)
        machine.board.run(1e-3)
        after = machine.board.view()
        assert (after.last_sequence, after.version) == (before.last_sequence, before.version)
        assert after.lease_us in (before.lease_us, 0)
        refused += after.refused - before.refused
        if number % 500 == 0 and kind == 0:
            machine.board.deliver(
                frames.seal(KEY, Frame([FrameType.ESTOP, FrameType.REARM][number // 500 % 2], 7, after.nonce, after.last_sequence + 1))
            )
            machine.board.run(1e-3)
    assert refused == 10_000
    assert machine.board.view().released
