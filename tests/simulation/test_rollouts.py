"""Rollouts: shapes, determinism, files and clear refusals."""

from __future__ import annotations

import hashlib
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from swarm_envs import Simulation, Trajectories, WorldError, load_world, rollouts

ENGINES = ["chipmunk", "disc"]


def controllers(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (count, 4)) * [0.09, 1.6, 0.09, 1.6]


def digest(trajectories: Trajectories) -> str:
    return hashlib.sha256(trajectories.poses.tobytes() + trajectories.detections.tobytes() + trajectories.commands.tobytes()).hexdigest()


def test_frame_zero_is_the_start_and_frames_come_as_often_as_asked() -> None:
    trajectories = rollouts("hero_plus", controllers(3), seed=4, steps=25, record_every=10)
    assert trajectories.poses.shape == (3, 3, 8, 3)
    assert trajectories.detections.shape == (3, 3, 8)
    assert trajectories.commands.shape == (3, 3, 8, 2)
    assert trajectories.time == pytest.approx([0.0, 1.0, 2.0])
    simulation = Simulation("hero_plus", 3)
    simulation.reset(4)
    assert (trajectories.poses[:, 0] == simulation.poses).all()


def test_commands_follow_the_detections() -> None:
    given = controllers(20)
    trajectories = rollouts("hero_plus", given, steps=100)
    seen = trajectories.detections.astype(bool)[..., None]
    assert (trajectories.commands == np.where(seen, given[:, None, None, 2:], given[:, None, None, :2])).all()
    assert seen.any()


@pytest.mark.parametrize("engine", ENGINES)
def test_no_thread_count_batch_or_subset_changes_a_bit(engine: str) -> None:
    given = controllers(150)
    whole = rollouts("hero_plus", given, seed=9, steps=200, threads=1, engine=engine)
    assert digest(rollouts("hero_plus", given, seed=9, steps=200, threads=3, engine=engine)) == digest(whole)
    assert digest(rollouts("hero_plus", given[:70], seed=9, steps=200, engine=engine)) == digest(whole[:70])
    assert digest(rollouts("hero_plus", given, seed=8, steps=200, engine=engine)) != digest(whole)


@pytest.mark.parametrize("engine", ENGINES)
def test_another_process_gives_the_same_bits(engine: str) -> None:
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from tests.simulation.test_rollouts import controllers, digest, rollouts\n"
        "print(digest(rollouts('hero_plus', controllers(40), seed=3, engine=sys.argv[2])))\n"
    )
    root = str(Path(__file__).parents[2])
    result = subprocess.run([sys.executable, "-c", program, root, engine], capture_output=True, text=True, check=True, cwd=root)
    assert result.stdout.strip() == digest(rollouts("hero_plus", controllers(40), seed=3, engine=engine))


@pytest.mark.parametrize("engine", ENGINES)
def test_stepping_by_hand_equals_a_rollout_to_the_last_bit(engine: str) -> None:
    given = controllers(5, seed=2)
    trajectories = rollouts("hero_plus", given, seed=1, steps=150, engine=engine)
    simulation = Simulation("hero_plus", 5, engine)
    simulation.reset(1)
    for k in range(150):
        simulation.step(np.where(simulation.detections[..., None] > 0, given[:, None, 2:], given[:, None, :2]))
        assert (simulation.poses == trajectories.poses[:, k + 1]).all()


def test_a_used_simulation_starts_again_like_a_new_one() -> None:
    for engine in ENGINES:
        simulation = Simulation("hero_plus", 2, engine)
        endings = []
        for _ in range(2):
            simulation.reset(7)
            for _ in range(200):
                simulation.step(np.tile([0.09, 0.2], (2, 8, 1)))
            endings.append(simulation.poses.copy())
        assert (endings[0] == endings[1]).all()


def test_a_pickled_simulation_goes_on_to_the_same_bits_with_the_disc_engine() -> None:
    simulation = Simulation(load_world("hero_plus").with_effects(motor_lag=0.1, missed_detections=0.2), 2, "disc")
    for _ in range(50):
        simulation.step(np.tile([0.09, 0.2], (2, 8, 1)))
    copy = pickle.loads(pickle.dumps(simulation))
    for each in (simulation, copy):
        for _ in range(100):
            each.step(np.tile([0.09, -0.2], (2, 8, 1)))
    assert (simulation.poses == copy.poses).all()
    assert (simulation.detections == copy.detections).all()


def test_each_robot_can_have_its_own_controller() -> None:
    alike = rollouts("hero_plus", np.repeat(controllers(2)[:, None], 8, axis=1), steps=50)
    assert (alike.poses == rollouts("hero_plus", controllers(2), steps=50).poses).all()
    own = np.zeros((1, 8, 4))
    own[0, 3] = [0.05, 0.0, 0.05, 0.0]
    moved = np.ptp(rollouts("hero_plus", own, steps=5).poses[0, :, :, 0], axis=0) + np.ptp(
        rollouts("hero_plus", own, steps=5).poses[0, :, :, 1], axis=0
    )
    assert (moved > 0).tolist() == [False, False, False, True, False, False, False, False]


def test_two_sensors_take_a_table_of_four_commands() -> None:
    import dataclasses

    from swarm_envs.worlds import Sensor

    world = load_world("hero_plus")
    robots = tuple(dataclasses.replace(r, sensors=(Sensor(0.12, 1.0), Sensor(0.12, 1.0, bearing=3.0))) for r in world.robots)
    world = dataclasses.replace(world, robots=robots)
    table = np.random.default_rng(1).uniform(-1, 1, (6, 8)) * ([0.09, 1.6] * 4)
    trajectories = rollouts(world, table, steps=100)
    pattern = trajectories.detections[..., 0] + 2 * trajectories.detections[..., 1]
    assert set(pattern.ravel()) == {0, 1, 2, 3}
    expected = table.reshape(6, 4, 2)[np.arange(6)[:, None, None], pattern]
    assert (trajectories.commands == expected).all()


def test_a_saved_batch_comes_back_whole_and_without_pickle(tmp_path: Path) -> None:
    trajectories = rollouts("hero_plus", controllers(3), steps=20)
    again = Trajectories.load(trajectories.save(tmp_path / "runs"))
    assert digest(again) == digest(trajectories)
    assert again.world == trajectories.world
    assert again.engine == "disc"
    with np.load(tmp_path / "runs.npz", allow_pickle=False) as file:
        assert "header" in file
        file["header"]


def test_a_batch_saved_by_an_earlier_version_is_read_and_runs_again_to_the_same_poses() -> None:
    """The file is version 0.1.0's of the run below; poses may differ in the last bits from one machine's library to the next."""
    saved = Trajectories.load(Path(__file__).parent / "data" / "saved_by_0_1_0.npz")
    assert saved.engine == "disc"
    again = rollouts(saved.world, [[0.07, -1.3, 0.06, 1.1]], seed=7, steps=20, record_every=10)
    np.testing.assert_allclose(again.poses, saved.poses, atol=1e-9)
    assert (again.detections == saved.detections).all()
    assert (again.commands == saved.commands).all()


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"nonsense" * 100])
def test_a_damaged_file_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "runs.npz").write_bytes(content)
    with pytest.raises(WorldError, match="not readable as trajectories") as error:
        Trajectories.load(tmp_path / "runs.npz")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"controllers": np.zeros((2, 3))}, r"shape is \(2, 3\), expected"),
        ({"controllers": np.zeros((2, 5, 4))}, r"expected \(worlds, 4\) or \(worlds, 8, 4\)"),
        ({"controllers": [[0.2, 0, 0, 0]]}, "v of 0.2 m/s is outside the limits of 'hero_plus', expected at most 0.09 m/s"),
        ({"controllers": [[0, 0, 0, -2]]}, "omega of 2 rad/s is outside the limits"),
        ({"controllers": [[np.nan, 0, 0, 0]]}, "not finite"),
        ({"engine": "bullet"}, "engine is 'bullet', expected one of chipmunk, disc"),
        ({"world": "heroplus"}, "did you mean 'hero_plus'"),
        ({"robots": 900}, "do not fit"),
        ({"record_every": 0}, "expected at least 0, 1 and 0"),
        ({"initial_poses": np.zeros((1, 8, 2))}, "expected .1, 8, 3."),
        ({"initial_poses": np.zeros((1, 8, 3))}, "does not fit"),
        ({"initial_poses": np.full((1, 8, 3), 0.7)}, "overlap by 120.0 mm"),
    ],
)
def test_wrong_arguments_are_refused_with_what_was_given_and_expected(change: dict[str, object], complaint: str) -> None:
    arguments: dict[str, object] = {"world": "hero_plus", "controllers": np.zeros((1, 4)), "steps": 5} | change
    with pytest.raises(WorldError, match=complaint) as error:
        rollouts(**arguments)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
