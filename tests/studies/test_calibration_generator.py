"""The generator of measured-like logs does what the definitions of its effects say."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from docs.studies.calibration.generator import EFFECTS, UNLISTED, draw, generate_log, robot_gains
from docs.studies.calibration.generator.contact import RADIUS, resolve
from docs.studies.calibration.generator.motion import STEP, Scene, Track, simulate
from docs.studies.calibration.generator.sensor import in_view, read
from docs.studies.calibration.generator.swarms import ARENA, PUSHERS, pushes, swarms
from docs.studies.calibration.generator.tracker import Noise, observe
from docs.studies.calibration.generator.wheels import WHEEL_BASE

V, OMEGA = 0.1, 0.8


def acted(effects=None, messages=((1.0, V, OMEGA), (4.0, 0.0, 0.0)), *, copies=1, duration=5.0, extra=None, heading=0.3, seed=0) -> Track:
    start = np.zeros((copies, 1, 3))
    start[..., 2] = heading
    told = [(k, 0, *message) for k in range(copies) for message in messages]
    return simulate(Scene(start, duration, np.ones((copies, 1, 2)), told), effects or {}, np.random.default_rng(seed), extra)


def pose(track: Track, t: float, copy: int = 0) -> np.ndarray:
    return track.poses[round(t / STEP), copy, 0]


def straight(effects, v=V, seconds=3.0) -> np.ndarray:
    return pose(acted(effects, ((1.0, v, 0.0), (1.0 + seconds, 0.0, 0.0)), heading=0.0), 5.0)


def test_without_effects_the_robot_drives_the_exact_arc():
    x, y, theta = pose(acted(), 4.0)
    end = 0.3 + 3 * OMEGA
    assert theta == pytest.approx(end, abs=1e-9)
    assert x == pytest.approx(V / OMEGA * (math.sin(end) - math.sin(0.3)), abs=1e-7)
    assert y == pytest.approx(V / OMEGA * (math.cos(0.3) - math.cos(end)), abs=1e-7)


def test_the_tracker_adds_noise_of_the_stated_size_and_nothing_else():
    track = acted(duration=60.0)
    frames = observe(track, 0, 0, {}, Noise(0.001, 0.005), np.random.default_rng(1))
    true = np.stack([np.interp(frames[:, 0], np.arange(len(track.poses)) * STEP, track.poses[:, 0, 0, k]) for k in range(3)], axis=1)
    error = frames[:, 1:] - true
    error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
    assert error.std(axis=0) == pytest.approx([0.001, 0.001, 0.005], rel=0.05)
    assert np.all(np.abs(error.mean(axis=0)) < 4 * np.array([0.001, 0.001, 0.005]) / math.sqrt(len(error)))
    assert 1 / np.median(np.diff(frames[:, 0])) == pytest.approx(60, rel=0.01)


def test_gains_scale_what_is_commanded():
    assert straight({"linear_gain": {"gain": 0.8}})[0] == pytest.approx(0.8 * 3 * V)
    turned = pose(acted({"angular_gain": {"gain": 1.2}}, ((1.0, 0.0, OMEGA), (4.0, 0.0, 0.0))), 5.0)
    assert turned[2] - 0.3 == pytest.approx(1.2 * 3 * OMEGA)
    assert turned[:2] == pytest.approx([0, 0])


def test_turn_bias_bends_straight_lines_by_radians_per_metre():
    assert straight({"turn_bias": {"bias": 0.7}})[2] == pytest.approx(0.7 * 3 * V)
    assert straight({"turn_bias": {"bias": 0.7}}, v=-V)[2] == pytest.approx(-0.7 * 3 * V)


def test_dead_time_shifts_the_whole_response():
    ideal, late = acted(), acted({"dead_time": {"delay": 0.137}})
    assert late.poses[137:] == pytest.approx(ideal.poses[:-137], abs=1e-12)


def test_motor_lag_is_an_exponential_of_its_time_constant():
    lagging = acted({"motor_lag": {"time_constant": 0.25}}, ((1.0, V, 0.0),), heading=0.0)
    for t in (0.1, 0.25, 1.0, 3.0):
        assert pose(lagging, 1 + t)[0] == pytest.approx(V * (t - 0.25 * (1 - math.exp(-t / 0.25))), abs=1e-6)


def test_a_wheel_commanded_below_the_deadband_stands():
    effects = {"deadband": {"threshold": 0.03}}
    assert straight(effects, v=0.029)[0] == 0
    assert straight(effects, v=0.031)[0] == pytest.approx(3 * 0.031)
    # left rim 0.02 m/s, right rim 0.06 m/s: the left one stands
    turned = pose(acted(effects, ((1.0, 0.04, 0.04 / WHEEL_BASE), (2.0, 0.0, 0.0))), 5.0)
    assert turned[2] - 0.3 == pytest.approx(0.06 / WHEEL_BASE)


def test_saturation_clips_each_rim():
    effects = {"saturation": {"limit": 0.08}}
    assert straight(effects, v=0.15)[0] == pytest.approx(3 * 0.08)
    turned = pose(acted(effects, ((1.0, 0.07, 0.06 / WHEEL_BASE), (2.0, 0.0, 0.0))), 5.0)
    assert turned[2] - 0.3 == pytest.approx((0.08 - 0.04) / WHEEL_BASE)


def test_lost_commands_leave_the_previous_one_in_force_at_the_stated_rate():
    track = acted({"command_loss": {"probability": 0.3}}, ((1.0, V, 0.0),), copies=4000, duration=1.2)
    moved = track.poses[-1, :, 0, 0] != 0
    assert moved.mean() == pytest.approx(0.7, abs=0.03)
    stopped = acted({"command_loss": {"probability": 0.3}}, copies=400, duration=4.5)
    speeds = np.abs(stopped.poses[-1, :, 0, 2] - stopped.poses[-2, :, 0, 2]) / STEP
    assert set(np.round(speeds, 6)) == {0.0, OMEGA}
    assert len(stopped.messages) == 800


def test_gains_fall_through_the_run():
    track = acted({"gain_drift": {"rate": 0.02}}, ((0.0, V, 0.0),), duration=20.0, heading=0.0)
    assert pose(track, 20.0)[0] == pytest.approx(V * (20 - 0.02 * 20**2 / 2), rel=1e-6)


def test_the_floor_drifts_only_under_a_robot_that_moves():
    effects = {"floor_drift": {"vx": 0.01, "vy": -0.02}}
    turned = pose(acted(effects, ((1.0, 0.0, OMEGA), (4.0, 0.0, 0.0)), duration=9.0), 9.0)
    assert turned[:2] == pytest.approx([0.03, -0.06])


def test_each_start_from_rest_turns_the_robot_at_random():
    messages = ((1.0, V, 0.0), (2.0, 0.0, 0.0), (3.0, V, 0.0), (3.5, -V, 0.0))
    track = acted({"start_kick": {"mean": 0.05, "sd": 0.1}}, messages, copies=4000)
    first = track.poses[2000, :, 0, 2] - 0.3
    second = track.poses[-1, :, 0, 2] - track.poses[2000, :, 0, 2]
    for kicks in (first, second):
        assert kicks.mean() == pytest.approx(0.05, abs=0.008)
        assert kicks.std() == pytest.approx(0.1, abs=0.005)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.06


def test_turning_slows_the_forward_speed_by_the_commanded_turn():
    track = acted({"turning_slows": {"slip": 0.25}})
    length = np.hypot(*np.diff(track.poses[:, 0, 0, :2], axis=0).T).sum()
    assert length == pytest.approx(3 * V * (1 - 0.25 * OMEGA), rel=1e-6)


def test_robots_spread_about_one_and_keep_their_gains():
    many = np.concatenate([robot_gains({"robot_spread": {"sd": 0.1}}, seed) for seed in range(300)])
    assert many.mean(axis=0) == pytest.approx([1, 1], abs=0.01)
    assert many.std(axis=0) == pytest.approx([0.1, 0.1], abs=0.005)
    assert np.array_equal(robot_gains({"robot_spread": {"sd": 0.1}}, 5), robot_gains({"robot_spread": {"sd": 0.1}}, 5))
    assert np.all(robot_gains({}, 5) == 1)


def test_a_turned_marker_and_a_shifted_clock_are_faults_of_the_measurement():
    track, still = acted(), Noise(0.0, 0.0)
    plain, turned, late = (
        observe(track, 0, 0, effects, still, np.random.default_rng(2))
        for effects in ({}, {"marker_yaw": {"yaw": 0.2}}, {"clock_offset": {"offset": 0.15}})
    )
    assert turned[:, :3] == pytest.approx(plain[:, :3])
    assert (turned[:, 3] - plain[:, 3]) % (2 * np.pi) == pytest.approx(np.full(len(plain), 0.2))
    assert np.interp(2.15, late[:, 0], late[:, 1]) == pytest.approx(pose(track, 2.0)[0], abs=1e-4)


def pair(distance: float, bearing: float) -> np.ndarray:
    return np.array([[[0.0, 0.0, 0.0], [distance * math.cos(bearing), distance * math.sin(bearing), math.pi / 2]]])


@pytest.mark.parametrize(
    ("effects", "reach", "left", "right"),
    [
        ({}, 1.0, 0.12, -0.12),
        ({"detection_range": {"range": 0.6}}, 0.6, 0.12, -0.12),
        ({"field_of_view": {"half_angle": 0.3}}, 1.0, 0.3, -0.3),
        ({"sensor_yaw": {"yaw": 0.1}}, 1.0, 0.22, -0.02),
    ],
)
def test_the_sensor_sees_a_disc_that_meets_its_sector(effects, reach, left, right):
    assert in_view(pair(reach - 1e-6, (left + right) / 2), effects)[0].tolist() == [True, False]
    assert not in_view(pair(reach + 1e-6, (left + right) / 2), effects)[0, 0]
    appears = math.asin(0.04 / 0.5)
    for edge, out in ((left + appears, 1e-6), (right - appears, -1e-6)):
        assert in_view(pair(0.5, edge - out), effects)[0, 0]
        assert not in_view(pair(0.5, edge + out), effects)[0, 0]


def test_misses_and_false_detections_come_at_the_stated_rates():
    random = np.random.default_rng(3)
    seen, unseen = np.repeat(pair(0.5, 0.0), 5000, axis=0), np.repeat(pair(0.5, 1.5), 5000, axis=0)
    assert read(np.stack([seen, seen]), STEP, {"missed_detections": {"probability": 0.2}}, random)[:, 0].mean() == pytest.approx(
        0.8, abs=0.03
    )
    assert read(np.stack([unseen] * 2), STEP, {"false_detections": {"probability": 0.1}}, random)[:, 0].mean() == pytest.approx(
        0.1, abs=0.02
    )
    before = seen.copy()
    before[..., 2] -= 1.5 * STEP
    turning = read(np.stack([before, seen]), STEP, {"misses_when_turning": {"rate": 0.3}}, random)[:, 0].mean()
    assert turning == pytest.approx(1 - 0.3 * 1.5, abs=0.03)
    assert read(np.stack([seen, seen]), STEP, {"misses_when_turning": {"rate": 0.3}}, random)[:, 0].all()


def test_a_late_sensor_tells_the_past():
    past = np.concatenate([np.repeat(pair(0.5, 1.5)[None], 700, axis=0), np.repeat(pair(0.5, 0.0)[None], 301, axis=0)])
    random = np.random.default_rng(0)
    assert not read(past, STEP, {"sensor_delay": {"delay": 0.301}}, random)[0, 0]
    assert read(past, STEP, {"sensor_delay": {"delay": 0.3}}, random)[0, 0]


def pressed(angle: float, effects, robots=False) -> tuple[float, float, float]:
    """A disc driven at 0.1 m/s along -x, `angle` off the normal, into the wall x = 0 or into a standing robot."""
    vx, vy, spin = np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, 2))
    vx[0, 0], vy[0, 0] = -0.1 * math.cos(angle), 0.1 * math.sin(angle)
    x, y = np.array([[0.5 if robots else RADIUS, 0.5 - 2 * RADIUS]]), np.full((1, 2), 0.7)
    after = resolve(x, y, vx, vy, spin, ARENA, effects, STEP)
    return tuple(float(part[0, 0]) for part in after)  # type: ignore[return-value]


def test_friction_with_a_wall_is_coulombs_with_the_spin_included():
    slide = 0.1 * math.sin(1.0)
    push = 0.1 * math.cos(1.0)
    vx, vy, omega = pressed(1.0, {"wall_friction": {"coefficient": 0.2}})
    assert vx == pytest.approx(0, abs=1e-8)
    assert vy == pytest.approx(slide - 0.2 * push)
    assert omega * RADIUS == pytest.approx(2 * 0.2 * push)
    # a steep push sticks: the touching point stands, a third of the sliding impulse stops it
    _, vy, omega = pressed(0.2, {"wall_friction": {"coefficient": 1.0}})
    assert vy == pytest.approx(0.1 * math.sin(0.2) * 2 / 3)
    assert vy - omega * RADIUS == pytest.approx(0, abs=1e-8)


def test_robots_share_the_momentum_of_a_push():
    vx, vy, omega = pressed(0.5, {"robot_friction": {"coefficient": 0.1}}, robots=True)
    push = 0.05 * math.cos(0.5)
    assert vx == pytest.approx(-push, abs=1e-8)
    assert vy == pytest.approx(0.1 * math.sin(0.5) - 0.1 * push)
    assert omega * RADIUS == pytest.approx(2 * 0.1 * push)


@pytest.mark.parametrize("radius", [0.045, 0.06, 0.08])
def test_robots_touch_at_their_radius_and_never_pass_into_each_other_or_a_wall(radius):
    random = np.random.default_rng(4)
    nearest, room = [], []
    for scene in (swarms(random, 2, 8, np.ones((8, 2))), pushes(random, 4, np.ones((PUSHERS, 2)))):
        poses = simulate(scene, {"collision_radius": {"radius": radius}}, random).poses
        apart = np.hypot(*(poses[:, :, :, None, k] - poses[:, :, None, :, k] for k in (0, 1)))
        apart[..., np.eye(apart.shape[-1], dtype=bool)] = np.inf
        nearest.append(apart.min())
        room.append(np.minimum(poses[..., :2] - ARENA[:2], np.array(ARENA[2:]) - poses[..., :2]).min())
    assert min(nearest) == pytest.approx(2 * radius, abs=2e-4)
    assert min(room) == pytest.approx(radius, abs=2e-4)


def rows(file: Path) -> list[dict[str, str]]:
    with file.open() as lines:
        return list(csv.DictReader(lines))


def test_a_log_has_the_form_of_measured_ones(tmp_path):
    folder = generate_log(draw(["sensor_yaw", "motor_lag"], 1), tmp_path / "log", seed=1, runs=4)
    poses, commands, detections = (rows(folder / f"{name}.csv") for name in ("poses", "commands", "detections"))
    assert set(poses[0]) == {"run", "robot", "t", "x", "y", "theta"}
    assert set(commands[0]) == {"run", "robot", "t", "v", "omega"}
    assert {row["detected"] for row in detections} == {"0", "1"}
    assert len({row["run"] for row in poses}) == 4
    assert yaml.safe_load((folder / "log.yaml").read_text())["arena"]["outline"] == [[0, 0], [1.7, 0], [1.7, 1.42], [0, 1.42]]
    assert not (generate_log({}, tmp_path / "open", seed=1, runs=2, procedures=["drives"]) / "detections.csv").exists()


def test_one_seed_gives_one_log(tmp_path):
    effects = draw(["command_loss"], 7)
    first, again, other = (generate_log(effects, tmp_path / name, seed=seed, runs=2) for name, seed in (("a", 7), ("b", 7), ("c", 8)))
    assert (first / "poses.csv").read_bytes() == (again / "poses.csv").read_bytes()
    assert (first / "poses.csv").read_bytes() != (other / "poses.csv").read_bytes()


def test_sizes_are_drawn_within_their_bands():
    for seed in range(50):
        for name, parameters in draw(list(EFFECTS), seed).items():
            for parameter, value in parameters.items():
                assert any(low <= value <= high for low, high in EFFECTS[name].parameters[parameter][1])


@pytest.mark.parametrize("name", sorted(UNLISTED))
def test_drives_meet_an_unlisted_effect(name):
    extra = UNLISTED[name](np.random.default_rng(0))
    messages = ((1.0, V, 0.0), (9.0, 0.0, 0.0))
    scene = Scene(np.array([[[-0.4, 0.0, 0.0]]]), 10.0, np.ones((1, 1, 2)), [(0, 0, *message) for message in messages])
    end = simulate(scene, {}, np.random.default_rng(0), extra).poses[-1, 0, 0]
    assert np.hypot(*(end[:2] - [0.4, 0.0])) > 0.05
