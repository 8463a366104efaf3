"""Free-running prediction of a log by a world."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from swarm_envs import Simulation, load_world
from swarm_envs.calibration import Log, Track, evaluate
from swarm_envs.calibration.command import main
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.parameters import drive_parameters

WIDE = [[-50, -50], [50, -50], [50, 50], [-50, 50]]
EFFECTS: list[dict[str, float]] = [
    {},
    {"linear_gain": 0.8, "angular_gain": 1.2},
    {"turn_bias": 0.7},
    {"dead_time": 0.24},
    {"motor_lag": 0.3},
    {"deadband": 0.05},
    {"saturation": 0.07},
    {"gain_drift": 0.02},
    {"floor_drift_x": 0.01, "floor_drift_y": -0.02},
    {"start_kick_mean": 0.2},
    {"turning_slows": 0.3},
    {"dead_time": 0.15, "motor_lag": 0.1, "turn_bias": -0.5, "deadband": 0.02, "saturation": 0.15, "linear_gain": 0.9},
]


def simulated(effects: dict[str, float]) -> Track:
    """Sixty commands, each held for half a second, in a hall without walls near."""
    world = load_world("hero_plus_unshielded", num_robots=1).with_effects(**effects)
    world = world.replace(arena=type(world.arena)(outline=tuple((float(x), float(y)) for x, y in WIDE)))
    simulation = Simulation(world)
    simulation.reset(1)
    generator = np.random.default_rng(2)
    commands = np.column_stack([generator.uniform(-0.1, 0.1, 60), generator.uniform(-1.5, 1.5, 60)])
    commands[::5] = 0.0
    poses = [simulation.poses[0, 0].copy()]
    for command in np.repeat(commands, 5, axis=0):
        simulation.step(command[None, None])
        poses.append(simulation.poses[0, 0].copy())
    path = np.array(poses)
    path[:, 2] = np.unwrap(path[:, 2])
    return Track("run", "robot", 0.1 * np.arange(301), path, 0.5 * np.arange(60), commands, np.empty(0), np.empty(0, bool))


@pytest.mark.parametrize("effects", EFFECTS, ids=lambda effects: "+".join(effects) or "ideal")
def test_the_drive_model_is_the_simulations(effects: dict[str, float]) -> None:
    track = simulated(effects)
    world = load_world("hero_plus_unshielded").with_effects(**effects)
    predicted = free_run(drive_parameters(world), track).from_pose(0, track.poses[0], slice(None))
    # the gains' drift is renewed each tick there, and followed here; a lag is cut into micro-steps in both
    tolerance = 2e-2 if "gain_drift" in effects else 2e-3 if "motor_lag" in effects else 1e-6
    assert np.abs(predicted - track.poses).max() < tolerance


def test_a_perfect_world_has_no_error_and_another_has() -> None:
    log = Log("it", (simulated({"linear_gain": 0.8}),))
    right = load_world("hero_plus").with_effects(linear_gain=0.8)
    assert evaluate(right, log)["10.0"]["position_m"] < 1e-9
    wrong = evaluate("hero_plus", log)
    assert wrong["1.0"]["position_m"] > 1e-3
    assert wrong["10.0"]["position_m"] > wrong["1.0"]["position_m"]
    assert wrong["10.0"]["windows"] == 41


def write(folder: Path, track: Track) -> Path:
    (folder / "log.yaml").write_text("name: it\n")
    poses = [f"a,r,{t},{x},{y},{h}" for t, (x, y, h) in zip(track.times, track.poses, strict=True)]
    commands = [f"a,r,{t},{v},{w}" for t, (v, w) in zip(track.command_times, track.commands, strict=True)]
    (folder / "poses.csv").write_text("\n".join(["run,robot,t,x,y,theta", *poses]) + "\n")
    (folder / "commands.csv").write_text("\n".join(["run,robot,t,v,omega", *commands]) + "\n")
    return folder


def test_the_command_prints_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--evaluate", "hero_plus", str(write(tmp_path, simulated({}))), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert set(result) == {"1.0", "5.0", "10.0"}
    assert set(result["1.0"]) == {"position_m", "heading_rad", "windows"}


def test_bad_input_is_one_line_and_a_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--evaluate", "hero_plus", str(tmp_path / "none"), "--json"]) != 0
    assert main(["--evaluate", "heros", str(tmp_path), "--json"]) != 0
    assert len(capsys.readouterr().err.splitlines()) == 2
