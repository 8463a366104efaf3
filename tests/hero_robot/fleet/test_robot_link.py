"""The server's end of the link, beside the firmware's, without sockets: sessions, replays of reports, clocks."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hero_robot.firmware import SimulatedBoard
from hero_robot.fleet import frames
from hero_robot.fleet.fleet_file import RobotEntry
from hero_robot.fleet.frames import FrameType, RobotState
from hero_robot.fleet.robot_link import RobotLink

KEY = bytes(range(32))
ENTRY = RobotEntry("hero_7", 7, "127.0.0.1", 4210, KEY)
SERVER_AHEAD = 123_456_789
"""us: the server's clock has nothing to do with the robot's."""


def begin() -> tuple[SimulatedBoard, RobotLink]:
    board = SimulatedBoard(7, KEY, 1)
    board.boot()
    board.run(0.1)
    link = RobotLink(ENTRY)
    greet(board, link)
    return board, link


def now(board: SimulatedBoard) -> int:
    return board.view().now_us + SERVER_AHEAD


def greet(board: SimulatedBoard, link: RobotLink, there: float = 0.001, back: float = 0.0) -> list[bytes]:
    """A HELLO and its answer, each this long on its way, s."""
    asked = link.hello(now(board))
    board.run(there)
    board.deliver(asked)
    board.run(0.001)
    answers = board.collect()
    if back:
        board.run(back)
    for answer in answers:
        link.receive(answer, now(board))
    return answers


def test_a_session_begins_with_an_answer_to_our_own_challenge() -> None:
    board, link = begin()
    assert link.connected(now(board))
    assert link.nonce == board.view().nonce
    assert link.status is not None
    assert link.status.state == RobotState.HOLD


def test_recorded_answers_of_an_old_boot_do_not_come_back() -> None:
    board, link = begin()
    old = greet(board, link)
    board.deliver(link.heartbeat(now(board), 0.3))
    board.run(0.2)
    old += board.collect()
    board.boot()
    board.seed += 1
    board.run(0.1)
    greet(board, link)
    nonce = link.nonce
    for datagram in old:
        assert link.receive(datagram, now(board)) is None
    assert link.nonce == nonce == board.view().nonce


def test_a_report_is_taken_once() -> None:
    board, link = begin()
    board.deliver(link.heartbeat(now(board), 0.3))
    board.run(0.2)
    reports = board.collect()
    assert [link.receive(report, now(board)) is not None for report in reports] == [True] * len(reports)
    assert [link.receive(report, now(board)) for report in reports] == [None] * len(reports)


def test_the_session_goes_on_above_what_the_robot_has_accepted() -> None:
    board, link = begin()
    for _ in range(5):
        board.deliver(link.heartbeat(now(board), 0.3))
        board.run(0.01)
    another = RobotLink(ENTRY)
    greet(board, another)
    sequence, datagram = another.command(FrameType.ESTOP)
    board.deliver(datagram)
    board.run(0.002)
    assert sequence == 6
    assert board.view().state == 3


@settings(max_examples=60, deadline=None)
@given(st.floats(0, 0.3), st.floats(0, 0.3), st.floats(0, 0.6), st.floats(0.05, 0.5))
def test_no_delay_on_the_way_lengthens_a_lease(there: float, back: float, on_the_way: float, lease: float) -> None:
    board, link = begin()
    link.clock = type(link.clock)()
    greet(board, link, there, back)
    sent = board.view().now_us
    heartbeat = link.heartbeat(now(board), lease)
    board.run(on_the_way)
    board.deliver(heartbeat)
    board.run(0.001)
    assert board.view().lease_us <= sent + round(lease * 1e6) + 2


@pytest.mark.parametrize(("there", "back"), [(0.001, 0.0), (0.05, 0.05), (0.08, 0.02)])
def test_the_middle_of_a_round_trip_is_off_by_half_its_asymmetry(there: float, back: float) -> None:
    board, link = begin()
    link.clock = type(link.clock)()
    greet(board, link, there, back)
    assert abs(link.clock.offset_us + SERVER_AHEAD) <= abs(there - back) / 2 * 1e6 + 1_500


def test_the_quickest_round_trip_counts() -> None:
    board, link = begin()
    for there in (0.1, 0.002, 0.2):
        greet(board, link, there)
    assert link.clock.round_trip_us < 4_000


def test_a_wrong_key_is_counted_and_changes_nothing() -> None:
    board, link = begin()
    stranger = RobotLink(RobotEntry("hero_7", 7, "127.0.0.1", 4210, bytes(reversed(KEY))))
    before = link.status
    for datagram in (b"", b"HF", stranger.hello(0), frames.seal(stranger.entry.key, frames.Frame(0x82, 7, link.nonce, 99, bytes(63)))):
        assert link.receive(datagram, now(board)) is None
    assert link.refused == 4
    assert link.status == before
