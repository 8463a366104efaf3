"""What must hold of a fleet, as functions of a lab on simulated time: tests ask it of the fleet as it is, and of broken ones."""

from __future__ import annotations

import pytest

from hero_robot.fleet import frames
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.frames import Frame, FrameType
from tests.hero_robot.fleet.lab import CONTROLLER, RUN, Lab
from tests.hero_robot.fleet.lossy_network import CUT, LATENCY, NetworkConditions

HOLD, ESTOP = 1, 3
POLL = 0.002
"""A robot looks at its lease each millisecond, s; its clock and the lab's are read in whole ones."""

ESTOP_LIMIT = 0.050
STOP_LIMIT = 0.500

FALSE_FRAMES = 10_000


def all_stop_when_the_server_is_killed(lab: Lab) -> None:
    """However the network behaves, within the lease, and for good."""
    lab.start_all()
    lab.run(1.0)
    assert lab.all_drive(), "this network alone must not stop a run"
    lab.run(lab.rng.uniform(0, 0.1))
    killed = lab.now_us
    lab.kill_server()
    times = lab.stop_times(killed)
    assert max(times) < lab.fleet.lease + POLL < STOP_LIMIT
    assert min(times) > 0, "none had stopped before"


def an_emergency_stop_is_immediate(lab: Lab) -> None:
    """On an unimpaired network within 50 ms; each press, also right after a rearm."""
    for _ in range(3):
        lab.start_all()
        lab.run(lab.rng.uniform(0, 0.1))
        pressed = lab.now_us
        lab.estop()
        times = lab.stop_times(pressed)
        assert max(times) < LATENCY + lab.network.conditions.jitter + POLL < ESTOP_LIMIT
        assert lab.states() == {ESTOP}
        assert all(outcome.done for outcome in lab.rearm())


def an_emergency_stop_gets_through(lab: Lab) -> None:
    """On any network within the lease, and all are latched soon after."""
    lab.start_all()
    pressed = lab.now_us
    lab.estop()
    assert max(lab.stop_times(pressed)) < lab.fleet.lease + POLL < STOP_LIMIT
    lab.run_until(lambda: lab.states() == {ESTOP}, 2, "all to be in ESTOP")
    lab.run(1.0)
    assert lab.states() == {ESTOP}


def an_emergency_stop_does_not_wait_for_the_lease(lab: Lab) -> None:
    """It is repeated until each robot has it: where a third of all frames is lost, four tries suffice for most robots."""
    lab.start_all()
    pressed = lab.now_us
    lab.estop()
    late = [time for time in lab.stop_times(pressed) if time > LATENCY + lab.network.conditions.jitter + 3 * 0.020 + POLL]
    assert len(late) <= 1


def a_cut_link_stops_all_and_starts_none(lab: Lab) -> None:
    """All stop within the lease, and a link that comes back starts nothing."""
    lab.start_all()
    lab.run(lab.rng.uniform(0, 0.1))
    lab.network.conditions = CUT
    cut = lab.now_us
    assert max(lab.stop_times(cut)) < lab.fleet.lease + POLL < STOP_LIMIT
    lab.network.conditions = NetworkConditions()
    lab.run_until(lab.all_connected, 5, "the robots to come back")
    lab.run(0.5)
    assert lab.states() == {HOLD}, "a link that comes back starts nothing"
    assert not lab.any_drives()


def a_server_that_hangs_stops_all_and_starts_none(lab: Lab) -> None:
    """Its machine sleeps for a second, and goes on where it was: robots have stopped, and stay."""
    lab.start_all()
    asleep, hangs = lab.server, lab.now_us
    lab.kill_server()
    assert max(lab.stop_times(hangs)) < lab.fleet.lease + POLL < STOP_LIMIT
    lab.run(lab.rng.uniform(0.1, 1.0))
    lab.server = asleep
    lab.run(1.0)
    assert lab.all_connected()
    assert lab.states() == {HOLD}
    assert not lab.any_drives()


def a_rearm_that_overtakes_reports_leaves_all_in_hold(lab: Lab) -> None:
    """When it is asked for, the server has heard of no stop yet: its robots still report that they run."""
    lab.start_all()
    lab.network.change(delay=0.1)
    lab.estop()
    rearmed = lab.rearm()
    assert all(outcome.done for outcome in rearmed), rearmed
    assert len(rearmed) == len(lab.boards)
    lab.run(0.3)
    assert lab.states() == {HOLD}
    assert not lab.any_drives()


def a_stop_in_the_middle_of_any_command_wins(lab: Lab) -> None:
    """Whatever the server is busy with when it is pressed, all robots end latched and at rest."""
    assert lab.server is not None
    lab.run_until(lab.all_connected, 20, "the robots")
    lab.update()
    for begin in (
        lambda server: server.start(lab.now_us),
        lambda server: server.hold(lab.now_us),
        lambda server: server.rearm(lab.now_us),
        lambda server: server.update({robot.name: CONTROLLER for robot in lab.fleet.robots}, lab.now_us),
    ):
        begin(lab.server)
        lab.run(lab.rng.uniform(0, 0.05))
        lab.estop()
        lab.run_until(lambda: lab.states() == {ESTOP}, 3, "all to be in ESTOP")
        lab.run(1.6)
        assert lab.states() == {ESTOP}
        assert not lab.any_drives()
        assert lab.server.stopped
        assert all(outcome.done for outcome in lab.rearm())


def held_back_frames_grant_no_motion(lab: Lab) -> None:
    """Authentic, in order, never seen before, and two seconds old: a lease counts from when it was sent."""
    lab.start_all()
    lab.network.change(held=True)
    held = lab.now_us
    assert max(lab.stop_times(held)) < lab.fleet.lease + POLL < STOP_LIMIT
    lab.kill_server()
    lab.run(1.5)
    before = len(lab.events)
    lab.network.change(held=False)
    assert lab.network.release() > 100
    lab.run(0.5)
    assert len(lab.events) == before
    assert not lab.any_drives()


def no_false_frame_is_taken(lab: Lab) -> None:
    """Replays of this boot and of the one before, forgeries, old nonces, keys of other robots: all refused, and nothing moves."""
    lab.start_all()
    lab.run(0.5)
    lab.estop()
    for number in range(1, 5):  # these boot again: what was recorded is of an old boot
        lab.switch_off(number)
        lab.switch_on(number)
    lab.run(0.3)
    lab.run_until(lambda: lab.all_connected() and lab.states() == {ESTOP}, 10, "the latch to reach them")
    lab.rearm()
    lab.run_until(lambda: lab.states() == {HOLD}, 5, "HOLD")
    lab.network.conditions = CUT  # from now on only the attacker speaks
    lab.run(0.6)
    replays, before = [item for item in lab.network.recorded if is_replay(lab, *item)], len(lab.events)
    refused = sum(board.view().refused for board in lab.boards.values())
    attack(lab, replays)
    lab.run(0.3)
    assert len(lab.events) == before, lab.events[before:]
    assert sum(board.view().refused for board in lab.boards.values()) - refused == FALSE_FRAMES
    lab.network.conditions = NetworkConditions()
    lab.start_all()  # nothing was spoilt by it


def is_replay(lab: Lab, number: int, datagram: bytes) -> bool:
    """Whether the robot has taken this command, or one after it, or has booted since; what the cut has swallowed is no replay."""
    frame = frames.unseal(lab.fleet.robots[number - 1].key, datagram)
    assert frame is not None
    view = lab.boards[number].view()
    return frame.kind != FrameType.HELLO and (frame.nonce != view.nonce or frame.sequence <= view.last_sequence)


def attack(lab: Lab, recorded: list[tuple[int, bytes]]) -> None:
    """Ten thousand false frames straight to the robots, four each millisecond."""
    kinds = [kind for kind in FrameType if kind < 0x80 and kind != FrameType.HELLO]
    robots = lab.fleet.robots
    own = {robot.number: [data for number, data in recorded if number == robot.number][-500:] for robot in robots}
    for attempt in range(FALSE_FRAMES):
        robot = robots[attempt % len(robots)]
        if attempt // 8 % 2 == 0:
            datagram = bytearray(lab.rng.choice(own[robot.number]))
            if attempt // 16 % 2:  # forged: a higher sequence under the old tag
                datagram[16:20] = (2**31 + attempt).to_bytes(4, "little")
        else:
            other = robots[(attempt + 1) % len(robots)]
            genuine = frames.unseal(robot.key, own[robot.number][-1])
            assert genuine is not None
            kind = lab.rng.choice(kinds)
            key, nonce = (other.key, genuine.nonce) if attempt // 16 % 2 else (robot.key, lab.rng.getrandbits(64))
            payload = bytes({FrameType.HEARTBEAT: 8, FrameType.START: 12, FrameType.CONTROLLER: 20}.get(kind, 0))
            datagram = bytearray(frames.seal(key, Frame(kind, robot.number, nonce, 2**31 + attempt, payload)))
        lab.deliver(robot.number, bytes(datagram))
        if attempt % 4 == 3:
            lab.run(0.001)


def robots_start_together(lab: Lab) -> None:
    """Each start, to within what the two ways of a round trip differ by, and never more than 20 ms."""
    for _ in range(3):
        begun = len(lab.events)
        lab.start_all()
        starts = [event.ns / 1e9 for event in lab.events[begun:] if event.state == RUN and event.driven]
        assert len(starts) == len(lab.boards)
        assert max(starts) - min(starts) < lab.network.conditions.jitter + POLL < 0.020
        lab.hold()
        lab.run_until(lambda: not lab.any_drives(), 2, "HOLD")


def one_missing_robot_keeps_all_from_starting(lab: Lab) -> None:
    """One without a controller, one that is off."""
    lab.run_until(lab.all_connected, 20, "the robots")
    lab.update()
    lab.switch_off(5)
    lab.switch_on(5)
    assert lab.server is not None
    fifth = lab.server.links[5]
    lab.run_until(lambda: fifth.status is not None and fifth.status.version == 0 and lab.all_connected(), 5, "hero_5 to come back")
    with pytest.raises(FleetError, match="hero_5 has no controller; update first"):
        lab.start()
    lab.update()
    lab.switch_off(5)
    lab.run(0.8)
    with pytest.raises(FleetError, match="hero_5 is not connected"):
        lab.start()
    lab.run(1.0)
    assert not any(event.driven for event in lab.events)


def a_robot_that_is_lost_during_the_start_keeps_all_from_starting(lab: Lab) -> None:
    """The others have taken the start already when the last one is missed: they are stopped as the server gives up, and stay."""
    lab.run_until(lab.all_connected, 20, "the robots")
    lab.update()
    assert lab.server is not None
    lab.switch_off(5)  # the server has heard it a moment ago
    outcomes = lab.start()
    assert [outcome.robot for outcome in outcomes if not outcome.done] == ["hero_5"]
    assert lab.longest_drive() < LATENCY + lab.network.conditions.jitter + POLL, "as long as the stop is on its way"
    lab.run(0.1)
    assert lab.states() == {HOLD}
    assert not lab.any_drives()


def a_robot_that_reboots_in_a_run_stays_in_hold(lab: Lab) -> None:
    """Whatever its server goes on to send."""
    lab.start_all()
    lab.switch_off(2)
    lab.switch_on(2)
    assert lab.server is not None
    second = lab.server.links[2]
    lab.run_until(lambda: second.status is not None and second.status.version == 0 and lab.all_connected(), 5, "it to come back")
    lab.run(0.5)
    assert lab.latest()[2].state == HOLD
    assert lab.latest()[3].state == RUN
    assert not lab.boards[2].view().may_move


def a_new_server_takes_over_a_stopped_fleet(lab: Lab) -> None:
    """The latch is the robots' own, and the new server can release it."""
    lab.start_all()
    pressed = lab.now_us
    lab.estop()
    lab.stop_times(pressed)
    lab.kill_server()
    lab.start_server()
    lab.run_until(lab.all_connected, 10, "the robots")
    assert lab.server is not None
    assert {link.status.state for link in lab.server.links.values() if link.status} == {ESTOP}
    assert lab.states() == {ESTOP}
    lab.rearm()
    lab.start_all()


def controllers_are_taken_in_hold_in_range_and_under_rising_versions(lab: Lab) -> None:
    """What robots refuse is said in their words."""
    lab.run_until(lab.all_connected, 20, "the robots")
    refused = lab.update({"hero_1": (0.21, 0.0, 0.0, 0.0)})
    assert [(outcome.robot, outcome.done, outcome.reason) for outcome in refused] == [("hero_1", False, "refused: out of range, in HOLD")]
    lab.start_all()
    assert lab.update({"hero_1": CONTROLLER})[0].reason == "refused: wrong state, in RUN"
    with pytest.raises(FleetError, match="'hero_9' is not in the fleet"):
        lab.update({"hero_9": CONTROLLER})
    lab.hold()
    lab.update({"hero_1": CONTROLLER})
    versions = [board.view().version for board in lab.boards.values()]
    assert versions[0] == max(versions) == versions[1] + 1
