"""Eight robots, each the firmware's host build, and the server: what stops them, and how soon."""

from __future__ import annotations

import random
import socket
import statistics
import time
from collections.abc import Callable

import pytest

from hero_robot.fleet import frames
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet
from hero_robot.fleet.frames import Frame, FrameType
from hero_robot.fleet.simulated import SimulatedFleet
from tests.hero_robot.fleet.network import BadNetwork, Weather
from tests.hero_robot.fleet.serving import CONTROLLER, RUN, Serving, all_drive, stop_times, wait_for

pytestmark = pytest.mark.real_time

ESTOP_LIMIT = 0.050
STOP_LIMIT = 0.500

WEATHERS = {
    "good weather": Weather(),
    "30 % loss": Weather(loss=0.3),
    "reordering": Weather(jitter=0.08),
    "100 ms delay": Weather(delay=0.1),
    "loss, delay and reordering": Weather(loss=0.3, delay=0.02, jitter=0.06),
}


@pytest.fixture
def report(record_property: Callable[[str, object], None]) -> Callable[[str, list[float]], None]:
    """Prints measured latencies, ms (seen with -s, and in the JUnit report)."""

    def tell(what: str, seconds: list[float]) -> None:
        text = f"{min(seconds) * 1e3:.1f} to {max(seconds) * 1e3:.1f} ms, median {statistics.median(seconds) * 1e3:.1f}"
        record_property(what, text)
        print(f"\n{what}: {text}")

    return tell


def test_an_emergency_stop_reaches_eight_robots_within_50_ms(
    serving: Serving, robots: SimulatedFleet, report: Callable[[str, list[float]], None]
) -> None:
    times: list[float] = []
    for _ in range(5):
        serving.start_all(robots)
        asked = time.monotonic_ns()
        serving.call("estop")
        times += stop_times(robots, asked)
        assert {event.state for event in robots.latest().values()} == {3}
        serving.call("rearm")
    report("emergency stop, from the request to released servos", times)
    assert max(times) < ESTOP_LIMIT


@pytest.mark.parametrize("weather", WEATHERS.values(), ids=WEATHERS.keys())
def test_when_the_server_is_killed_all_stop_within_500_ms(
    serving: Serving, robots: SimulatedFleet, network: BadNetwork, weather: Weather, report: Callable[[str, list[float]], None]
) -> None:
    network.weather = weather
    serving.start_all(robots)
    time.sleep(1.0)
    assert all_drive(robots), "this weather alone must not stop a run"
    killed = serving.kill()
    times = stop_times(robots, killed)
    report("server killed", times)
    assert max(times) < STOP_LIMIT


def test_when_the_link_is_cut_all_stop_within_500_ms_and_stay(
    serving: Serving, robots: SimulatedFleet, network: BadNetwork, report: Callable[[str, list[float]], None]
) -> None:
    serving.start_all(robots)
    network.weather = Weather(cut=True)
    cut = time.monotonic_ns()
    times = stop_times(robots, cut)
    report("link cut", times)
    assert max(times) < STOP_LIMIT
    network.weather = Weather()
    wait_for(serving.all_connected, 5, "the robots to come back")
    time.sleep(0.5)
    assert {event.state for event in robots.latest().values()} == {1}, "a link that comes back starts nothing"


@pytest.mark.parametrize("weather", [Weather(loss=0.3), Weather(jitter=0.08), Weather(delay=0.1)], ids=["loss", "reordering", "delay"])
def test_an_emergency_stop_gets_through_bad_weather(
    serving: Serving, robots: SimulatedFleet, network: BadNetwork, weather: Weather
) -> None:
    network.weather = weather
    serving.start_all(robots)
    asked = time.monotonic_ns()
    serving.call("estop")
    assert max(stop_times(robots, asked)) < STOP_LIMIT
    wait_for(lambda: {event.state for event in robots.latest().values()} == {3}, 2, "all to be in ESTOP")


def test_a_rearm_that_overtakes_the_robots_reports_leaves_all_in_hold(
    serving: Serving, robots: SimulatedFleet, network: BadNetwork
) -> None:
    """When it is asked for, the server has heard of no stop yet: its robots still report that they run."""
    serving.start_all(robots)
    network.weather = Weather(delay=0.1)
    serving.call("estop")
    rearmed = serving.call("rearm")
    assert all(outcome["done"] for outcome in rearmed["outcomes"]), rearmed
    assert len(rearmed["outcomes"]) == 8
    time.sleep(0.3)
    assert {event.state for event in robots.latest().values()} == {1}
    assert not any(event.driven for event in robots.latest().values())


def test_frames_held_back_by_the_network_grant_no_motion_later(serving: Serving, robots: SimulatedFleet, network: BadNetwork) -> None:
    """Authentic, in order, never seen before, and two seconds old: a lease counts from when it was sent."""
    serving.start_all(robots)
    network.weather = Weather(holding=True)
    held = time.monotonic_ns()
    assert max(stop_times(robots, held)) < STOP_LIMIT
    serving.kill()
    time.sleep(1.5)
    before = len(robots.events)
    network.weather = Weather()
    assert network.let_go() > 100
    time.sleep(0.5)
    assert len(robots.events) == before


def test_none_of_ten_thousand_false_frames_is_taken(serving: Serving, fleet: Fleet, robots: SimulatedFleet, network: BadNetwork) -> None:
    """Replays of this boot and of the one before, forgeries, old nonces, keys of other robots, against stopped and running robots."""
    serving.start_all(robots)
    serving.call("estop")
    for robot in fleet.robots[:4]:  # these boot again: what was recorded is of an old boot
        robots.switch_off(robot.number)
        robots.switch_on(robots.fleet.robots[robot.number - 1])
    wait_for(serving.all_connected, 10, "the robots")
    wait_for(lambda: all(event.state == 3 for event in robots.latest().values()), 5, "the latch to reach them")
    serving.call("rearm")
    wait_for(lambda: all(event.state == 1 for event in robots.latest().values()), 5, "HOLD")
    network.weather = Weather(cut=True)  # from now on only the attacker speaks
    time.sleep(0.6)
    recorded, before = list(network.recorded), len(robots.events)
    attack(fleet, robots, network, recorded)
    time.sleep(0.3)
    assert len(robots.events) == before, robots.events[before:]
    network.weather = Weather()
    wait_for(serving.all_connected, 5, "the robots")
    refused = sum(robot["refused"] for robot in serving.status()["robots"])
    assert refused >= 0.9 * 10_000, f"only {refused} arrived"
    serving.start_all(robots)  # nothing was spoilt by it


def attack(fleet: Fleet, robots: SimulatedFleet, network: BadNetwork, recorded: list[tuple[tuple[str, int], bytes]]) -> None:
    """10,000 false frames straight to the robots' ports, at a rate that their sockets take."""
    chance = random.Random(3)
    kinds = [kind for kind in FrameType if kind < 0x80 and kind != FrameType.HELLO]
    recorded = [item for item in recorded if item[1][3] != FrameType.HELLO]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as attacker:
        for attempt in range(10_000):
            robot = fleet.robots[attempt % len(fleet.robots)]
            port = network.ways[robot.port]
            if attempt // 8 % 2 == 0:
                own = [data for address, data in recorded[-4000:] if address[1] == port]
                datagram = bytearray(chance.choice(own))
                if attempt // 16 % 2:  # forged: a higher sequence under the old tag
                    datagram[16:20] = (2**31 + attempt).to_bytes(4, "little")
            else:
                other = fleet.robots[(attempt + 1) % len(fleet.robots)]
                genuine = frames.unseal(robot.key, next(data for address, data in reversed(recorded) if address[1] == port))
                assert genuine is not None
                kind = chance.choice(kinds)
                key, nonce = (other.key, genuine.nonce) if attempt // 16 % 2 else (robot.key, chance.getrandbits(64))
                payload = {8: bytes(8), 12: bytes(12), 20: bytes(20)}.get({2: 8, 3: 12, 7: 20}.get(kind, 0), b"")
                datagram = bytearray(frames.seal(key, Frame(kind, robot.number, nonce, 2**31 + attempt, payload)))
            attacker.sendto(bytes(datagram), ("127.0.0.1", port))
            if attempt % 40 == 39:
                time.sleep(0.004)


def test_robots_start_together(serving: Serving, robots: SimulatedFleet, report: Callable[[str, list[float]], None]) -> None:
    spreads = []
    for _ in range(3):
        begun = len(robots.events)
        serving.start_all(robots)
        starts = [event.ns for event in robots.events[begun:] if event.state == RUN and event.driven]
        assert len(starts) == 8
        spreads.append((max(starts) - min(starts)) / 1e9)
        serving.call("hold")
        wait_for(lambda: not any(event.driven for event in robots.latest().values()), 2, "HOLD")
    report("spread of a synchronised start", spreads)
    assert min(spreads) < 0.020


def test_one_missing_robot_keeps_all_from_starting(serving: Serving, robots: SimulatedFleet) -> None:
    robots.switch_off(5)
    robots.switch_on(robots.fleet.robots[4])
    wait_for(lambda: serving.all_connected() and serving.status()["robots"][4]["version"] == 0, 5, "hero_5 without a controller")
    with pytest.raises(FleetError, match=r"hero_\d has no controller; update first"):
        serving.call("start")
    serving.call("update", controllers={f"hero_{i + 1}": CONTROLLER for i in range(8)})
    robots.switch_off(5)
    time.sleep(0.8)
    with pytest.raises(FleetError, match="hero_5 is not connected"):
        serving.call("start")
    assert not any(event.driven for event in robots.latest().values())


def test_a_robot_that_reboots_in_a_run_stays_in_hold(serving: Serving, fleet: Fleet, robots: SimulatedFleet) -> None:
    serving.start_all(robots)
    robots.switch_off(2)
    robots.switch_on(fleet.robots[1])
    wait_for(lambda: serving.all_connected() and serving.status()["robots"][1]["version"] == 0, 5, "it to come back")
    time.sleep(0.5)
    assert robots.latest()[2].state == 1
    assert robots.latest()[3].state == RUN


def test_a_new_server_takes_over_a_stopped_fleet(serving: Serving, robots: SimulatedFleet) -> None:
    serving.start_all(robots)
    serving.call("estop")
    stop_times(robots, time.monotonic_ns())
    serving.kill()
    serving.__enter__()
    wait_for(serving.all_connected, 10, "the robots")
    assert {robot["state"] for robot in serving.status()["robots"]} == {"ESTOP"}, "the latch is the robots' own"
    serving.call("rearm")
    serving.start_all(robots)


def test_controllers_are_taken_in_hold_in_range_and_under_rising_versions(serving: Serving, robots: SimulatedFleet) -> None:
    wait_for(serving.all_connected, 20, "the robots")
    refused = serving.call("update", controllers={"hero_1": [0.21, 0, 0, 0]})["outcomes"][0]
    assert refused == {"robot": "hero_1", "done": False, "reason": "refused: out of range, in HOLD"}
    serving.start_all(robots)
    refused = serving.call("update", controllers={"hero_1": CONTROLLER})["outcomes"][0]
    assert refused["reason"] == "refused: wrong state, in RUN"
    with pytest.raises(FleetError, match="'hero_9' is not in the fleet"):
        serving.call("update", controllers={"hero_9": CONTROLLER})
    serving.call("hold")
    serving.call("update", controllers={"hero_1": CONTROLLER})
    versions = [robot["version"] for robot in serving.status()["robots"]]
    assert versions[0] == max(versions) == versions[1] + 1


def test_only_the_stop_is_open_to_a_stranger(serving: Serving, robots: SimulatedFleet) -> None:
    import json
    import urllib.error
    import urllib.request

    wait_for(serving.all_connected, 20, "the robots")
    url = serving.session["url"]
    for path, headers in [("start", {}), ("rearm", {"X-Fleet-Token": "guessed"}), ("update", {}), ("poses", {}), ("hold", {})]:
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(urllib.request.Request(f"{url}/{path}", b"{}", headers), timeout=5)
        assert refused.value.code == 403
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(urllib.request.Request(f"{url}/", headers={"Host": "evil.example"}), timeout=5)
    with urllib.request.urlopen(urllib.request.Request(f"{url}/estop", b""), timeout=5) as answer:
        assert json.load(answer) == {"outcomes": []}
    wait_for(lambda: all(event.state == 3 for event in robots.latest().values()), 2, "ESTOP")
    assert serving.status()["stopped"] is True
