"""The firmware's frames and Python's, written apart, read each other."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from hero_robot.firmware import SimulatedBoard
from hero_robot.fleet import frames
from hero_robot.fleet.frames import Frame, FrameType, RobotState

KEY = bytes(range(32))
FRAMES = st.builds(
    Frame, st.integers(0, 255), st.integers(0, 65535), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 1), st.binary(max_size=96)
)


@given(FRAMES)
def test_a_sealed_frame_reads_back(frame: Frame) -> None:
    assert frames.unseal(KEY, frames.seal(KEY, frame)) == frame


@given(FRAMES, st.integers(0, 10**6))
def test_no_bit_may_change(frame: Frame, place: int) -> None:
    sealed = bytearray(frames.seal(KEY, frame))
    sealed[place // 8 % len(sealed)] ^= 1 << place % 8
    assert frames.unseal(KEY, bytes(sealed)) is None


@settings(max_examples=500)
@given(st.binary(max_size=200))
def test_rubbish_is_no_frame(rubbish: bytes) -> None:
    assert frames.unseal(KEY, rubbish) is None
    frames.read_status(rubbish)


def test_the_firmware_reads_what_python_writes_and_the_other_way_round() -> None:
    board = SimulatedBoard(7, KEY, 1)
    board.boot()
    board.run(0.1)
    board.deliver(frames.seal(KEY, Frame(FrameType.HELLO, 7, 0, 0, frames.hello(0x1122334455667788))))
    board.run(0.001)
    welcome = frames.unseal(KEY, board.collect()[-1])
    assert welcome is not None
    assert (welcome.kind, welcome.robot, welcome.nonce) == (FrameType.WELCOME, 7, board.view().nonce)
    assert int.from_bytes(welcome.payload[:8], "little") == 0x1122334455667788
    for sequence, (kind, payload) in enumerate(
        [
            (FrameType.CONTROLLER, frames.controller(41, (0.08, 0.4, -0.05, -1.2))),
            (FrameType.HEARTBEAT, frames.heartbeat(board.view().now_us + 450_000)),
            (FrameType.START, frames.start(board.view().now_us + 20_000, 41)),
        ],
        start=1,
    ):
        board.deliver(frames.seal(KEY, Frame(kind, 7, welcome.nonce, sequence, payload)))
        board.run(0.001)
    board.set(distance=0.3, battery=3.45)
    board.run(0.4)
    last = frames.unseal(KEY, board.collect()[-1])
    assert last is not None
    status, view = frames.read_status(last.payload), board.view()
    assert status is not None
    assert (status.state, status.version, status.last_sequence) == (RobotState.RUN, 41, 3)
    assert (status.seen, status.leased, status.battery_low, status.range) == (True, True, True, 0.3)
    assert (status.v, status.omega) == view.command
    assert status.battery == 3.45
    assert abs(status.time_us - view.now_us) <= 50_000
    assert abs(status.x - view.x) < 0.01
    assert status.refused == 0
