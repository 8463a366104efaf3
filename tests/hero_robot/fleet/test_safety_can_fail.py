"""Each property of ``test_safety.py`` is lost when what it rests on is broken: in a copy of the firmware's core, or in the server."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from hero_robot.firmware import library
from hero_robot.firmware.sources import firmware_folder
from hero_robot.fleet.coordinator import FleetCoordinator
from hero_robot.fleet.robot_link import RobotLink
from tests.hero_robot.fleet import properties
from tests.hero_robot.fleet.lab import Lab
from tests.hero_robot.fleet.lossy_network import CONDITIONS

Property = Callable[[Lab], None]

SEED = 1
"""One of those of ``test_safety.py``, in which a lossy network swallows the first emergency stop of some robot."""


@dataclass(frozen=True)
class BrokenCore:
    """A fault in the firmware, and the properties that it takes, each with the network conditions that bring it to light."""

    file: str
    right: str
    wrong: str
    lost: list[tuple[Property, str]]


GRANT = "supervisor->lease_us = until_us < most ? until_us : most;"
LEASE_END = "if (supervisor->state == HERO_STATE_RUN || supervisor->start_pending) enter("
CORES = {
    "a lease of two seconds": BrokenCore(
        "hero_supervisor.c",
        GRANT,
        "supervisor->lease_us = most + 1500000u;",
        [
            (properties.all_stop_when_the_server_is_killed, "no impairment"),
            (properties.a_cut_link_stops_all_and_starts_none, "no impairment"),
            (properties.a_server_that_hangs_stops_all_and_starts_none, "no impairment"),
            (properties.held_back_frames_grant_no_motion, "no impairment"),
        ],
    ),
    "a lease that counts from its arrival": BrokenCore(
        "hero_supervisor.c",
        GRANT,
        "supervisor->lease_us = most - 150000u;",
        [(properties.all_stop_when_the_server_is_killed, "100 ms delay")],
    ),
    "a lease that pauses the run instead of ending it": BrokenCore(
        "hero_supervisor.c",
        LEASE_END,
        "if (supervisor->start_pending) enter(",
        [
            (properties.a_cut_link_stops_all_and_starts_none, "no impairment"),
            (properties.a_server_that_hangs_stops_all_and_starts_none, "no impairment"),
        ],
    ),
    "an emergency stop that is not latched": BrokenCore(
        "hero_supervisor.c",
        "enter(supervisor, HERO_STATE_ESTOP, HERO_BECAUSE_ESTOP);",
        "enter(supervisor, HERO_STATE_HOLD, HERO_BECAUSE_ESTOP);",
        [
            (properties.an_emergency_stop_is_immediate, "no impairment"),
            (properties.a_new_server_takes_over_a_stopped_fleet, "no impairment"),
            (properties.a_stop_in_the_middle_of_any_command_wins, "no impairment"),
        ],
    ),
    "an emergency stop that leaves it to the lease": BrokenCore(
        "hero_supervisor.c",
        "enter(supervisor, HERO_STATE_ESTOP, HERO_BECAUSE_ESTOP);",
        "",
        [
            (properties.an_emergency_stop_is_immediate, "no impairment"),
            (properties.an_emergency_stop_gets_through, "30 % loss"),
            (properties.an_emergency_stop_does_not_wait_for_the_lease, "30 % loss"),
        ],
    ),
    "replays that are taken": BrokenCore(
        "hero_link.c",
        "if (session && frame->sequence <= link->last_sequence) return HERO_REPLAYED;",
        "",
        [(properties.no_false_frame_is_taken, "no impairment")],
    ),
    "tags that are not looked at": BrokenCore(
        "hero_link.c",
        "if (!hero_frame_authentic(link->key, data, size)) return HERO_FORGED;",
        "(void)data, (void)size;",
        [(properties.no_false_frame_is_taken, "no impairment")],
    ),
    "a start that begins as it arrives": BrokenCore(
        "hero_supervisor.c",
        "supervisor->start_us = command->time_us;",
        "supervisor->start_us = now_us;",
        [
            (properties.robots_start_together, "30 % loss"),
            (properties.a_robot_that_is_lost_during_the_start_keeps_all_from_starting, "no impairment"),
        ],
    ),
    "a controller beyond the robot's limits": BrokenCore(
        "hero_supervisor.c",
        "if (!hero_controller_in_range(&command->controller)) return HERO_OUT_OF_RANGE;",
        "",
        [(properties.controllers_are_taken_in_hold_in_range_and_under_rising_versions, "no impairment")],
    ),
}


def break_core(fault: BrokenCore, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let boards run a copy of the firmware with this fault."""
    copy = folder / "firmware"
    for name in ("core", "hal/sim"):
        shutil.copytree(firmware_folder() / name, copy / name)
    path = copy / "core" / fault.file
    text = path.read_text()
    assert text.count(fault.right) == 1
    path.write_text(text.replace(fault.right, fault.wrong))
    monkeypatch.setattr(library, "firmware_folder", lambda: copy)
    broken = library.load.__wrapped__("hero_plus")
    monkeypatch.setattr("hero_robot.firmware.board.load", lambda robot_file: broken)


@pytest.mark.parametrize("fault", CORES.values(), ids=CORES.keys())
def test_a_fault_in_the_robot_is_found(fault: BrokenCore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    break_core(fault, tmp_path, monkeypatch)
    for holds, conditions in fault.lost:
        with pytest.raises(AssertionError):
            holds(Lab(SEED, CONDITIONS[conditions]))


# --- faults of the server -----------------------------------------------------------------------------------------------


def heartbeats_outlive_the_server(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Lab, "kill_server", lambda lab: None)


def the_stop_is_not_latched(monkeypatch: pytest.MonkeyPatch) -> None:
    estop = FleetCoordinator.estop

    def forget(server: FleetCoordinator, now_us: int, press: str | None = None) -> None:
        estop(server, now_us, press)
        server.stopped = False

    monkeypatch.setattr(FleetCoordinator, "estop", forget)


def old_reports_are_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    rearm = FleetCoordinator.rearm

    def at_once(server: FleetCoordinator, now_us: int) -> object:
        server.stopped = False
        return rearm(server, now_us)

    monkeypatch.setattr(FleetCoordinator, "rearm", at_once)


def leases_are_longer_than_the_fleet_file_says(monkeypatch: pytest.MonkeyPatch) -> None:
    heartbeat = RobotLink.heartbeat
    monkeypatch.setattr(RobotLink, "heartbeat", lambda link, now_us, lease: heartbeat(link, now_us, lease + 0.1))


def a_start_is_not_taken_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FleetCoordinator, "_hold", lambda server: iter(()))


def nobody_checks_who_may_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FleetCoordinator, "_loaded_versions", lambda server: dict.fromkeys(server.links, 1))


@pytest.mark.parametrize(
    ("break_server", "holds", "conditions"),
    [
        (heartbeats_outlive_the_server, properties.all_stop_when_the_server_is_killed, "no impairment"),
        (heartbeats_outlive_the_server, properties.all_stop_when_the_server_is_killed, "loss, delay and reordering"),
        (leases_are_longer_than_the_fleet_file_says, properties.all_stop_when_the_server_is_killed, "no impairment"),
        (the_stop_is_not_latched, properties.an_emergency_stop_gets_through, "30 % loss"),
        (the_stop_is_not_latched, properties.an_emergency_stop_does_not_wait_for_the_lease, "30 % loss"),
        (old_reports_are_believed, properties.a_rearm_that_overtakes_reports_leaves_all_in_hold, "no impairment"),
        (a_start_is_not_taken_back, properties.a_robot_that_is_lost_during_the_start_keeps_all_from_starting, "no impairment"),
    ],
)
def test_a_fault_in_the_server_is_found(
    break_server: Callable[[pytest.MonkeyPatch], None], holds: Property, conditions: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    break_server(monkeypatch)
    with pytest.raises(AssertionError):
        holds(Lab(SEED, CONDITIONS[conditions]))


def test_a_server_that_checks_nothing_before_a_start_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    nobody_checks_who_may_start(monkeypatch)
    with pytest.raises(pytest.fail.Exception, match="DID NOT RAISE"):
        properties.one_missing_robot_keeps_all_from_starting(Lab(SEED))
