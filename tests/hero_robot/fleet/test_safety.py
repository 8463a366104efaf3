"""Eight robots with their own firmware and the server's logic, on simulated time: what stops them, and how soon.

Seeds settle networks, clocks and the moments at which things happen. That these tests can fail, ``test_safety_can_fail.py`` shows; that
real processes behave alike, ``test_processes.py``.
"""

from __future__ import annotations

import pytest

from tests.hero_robot.fleet import properties
from tests.hero_robot.fleet.lab import Lab
from tests.hero_robot.fleet.lossy_network import CONDITIONS, NetworkConditions

SEEDS = range(10)
in_all_conditions = pytest.mark.parametrize("conditions", CONDITIONS.values(), ids=CONDITIONS.keys())
with_each_seed = pytest.mark.parametrize("seed", SEEDS)


def test_the_same_seed_gives_the_same_frames_and_events() -> None:
    labs = []
    for seed in (3, 3, 4):
        lab = Lab(seed, CONDITIONS["loss, delay and reordering"])
        lab.start_all()
        labs.append((lab.network.recorded, lab.events, lab.server.events if lab.server else None))
    assert labs[0] == labs[1]
    assert labs[0][0] != labs[2][0]


@with_each_seed
@in_all_conditions
def test_when_the_server_is_killed_all_stop_within_their_lease(conditions: NetworkConditions, seed: int) -> None:
    properties.all_stop_when_the_server_is_killed(Lab(seed, conditions))


@with_each_seed
def test_an_emergency_stop_reaches_eight_robots_within_50_ms(seed: int) -> None:
    properties.an_emergency_stop_is_immediate(Lab(seed))


@with_each_seed
@in_all_conditions
def test_an_emergency_stop_gets_through_a_bad_network(conditions: NetworkConditions, seed: int) -> None:
    properties.an_emergency_stop_gets_through(Lab(seed, conditions))


@with_each_seed
def test_an_emergency_stop_is_repeated_until_each_robot_has_it(seed: int) -> None:
    properties.an_emergency_stop_does_not_wait_for_the_lease(Lab(seed, CONDITIONS["30 % loss"]))


@with_each_seed
def test_when_the_link_is_cut_all_stop_and_stay(seed: int) -> None:
    properties.a_cut_link_stops_all_and_starts_none(Lab(seed))


@with_each_seed
def test_when_the_server_hangs_all_stop_and_stay(seed: int) -> None:
    properties.a_server_that_hangs_stops_all_and_starts_none(Lab(seed))


@with_each_seed
def test_a_rearm_that_overtakes_the_robots_reports_leaves_all_in_hold(seed: int) -> None:
    properties.a_rearm_that_overtakes_reports_leaves_all_in_hold(Lab(seed))


@with_each_seed
@pytest.mark.parametrize("conditions", [CONDITIONS["no impairment"], CONDITIONS["loss, delay and reordering"]], ids=["good", "bad"])
def test_a_stop_in_the_middle_of_any_command_wins(conditions: NetworkConditions, seed: int) -> None:
    properties.a_stop_in_the_middle_of_any_command_wins(Lab(seed, conditions))


@with_each_seed
def test_frames_held_back_by_the_network_grant_no_motion_later(seed: int) -> None:
    properties.held_back_frames_grant_no_motion(Lab(seed))


@pytest.mark.parametrize("seed", range(2))
def test_none_of_ten_thousand_false_frames_is_taken(seed: int) -> None:
    properties.no_false_frame_is_taken(Lab(seed))


@with_each_seed
@pytest.mark.parametrize("conditions", [CONDITIONS["no impairment"], CONDITIONS["30 % loss"]], ids=["good", "loss"])
def test_robots_start_together(conditions: NetworkConditions, seed: int) -> None:
    properties.robots_start_together(Lab(seed, conditions))


@with_each_seed
def test_one_missing_robot_keeps_all_from_starting(seed: int) -> None:
    properties.one_missing_robot_keeps_all_from_starting(Lab(seed))


@with_each_seed
def test_a_robot_lost_during_the_start_keeps_all_from_starting(seed: int) -> None:
    properties.a_robot_that_is_lost_during_the_start_keeps_all_from_starting(Lab(seed))


@with_each_seed
def test_a_robot_that_reboots_in_a_run_stays_in_hold(seed: int) -> None:
    properties.a_robot_that_reboots_in_a_run_stays_in_hold(Lab(seed))


@with_each_seed
def test_a_new_server_takes_over_a_stopped_fleet(seed: int) -> None:
    properties.a_new_server_takes_over_a_stopped_fleet(Lab(seed))


def test_controllers_are_taken_in_hold_in_range_and_under_rising_versions() -> None:
    properties.controllers_are_taken_in_hold_in_range_and_under_rising_versions(Lab(0))


def test_a_press_that_is_sent_three_times_is_told_once() -> None:
    lab = Lab(0)
    lab.start_all()
    assert lab.server is not None
    server = lab.server

    def told() -> int:
        return sum("EMERGENCY STOP" in event for event in server.events)

    for wait in (0.0, 0.06, 0.19):
        lab.run(wait)
        lab.estop("first press")
    assert told() == 1
    lab.estop("second press")
    assert told() == 2
    lab.estop()
    lab.estop()
    assert told() == 4, "a command line and a bridge give presses no name"
    lab.run(1.0)
    lab.rearm()
    lab.estop("first press")
    assert server.stopped, "a request that comes late stops all the same"
    assert told() == 5
