"""Limited communication: one bit, heard within a range."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env

import swarm_envs
from swarm_envs.worlds import Broadcast, WorldError
from swarm_envs.worlds.dump import world_from_text, world_to_text

WORLD = dataclasses.replace(swarm_envs.load_world("hero_plus", num_robots=4), broadcast=Broadcast(range=0.5))
POSES = np.array([[0.3, 0.3, np.pi], [0.7, 0.3, np.pi], [1.1, 0.3, np.pi], [1.55, 1.2, np.pi / 2]])
"""A row of three, 0.4 m apart and looking away from one another where they can, and one alone."""


def act(messages: list[int]) -> np.ndarray:
    return np.stack([np.zeros(4), np.zeros(4), np.array(messages, float)], axis=-1).astype(np.float32)


def test_robots_within_range_hear_and_others_do_not() -> None:
    env = gym.make("HeRo/Swarm-v0", world=WORLD)
    first, _ = env.reset(seed=0, options={"initial_poses": POSES})
    assert env.action_space.shape == (4, 3)
    assert env.observation_space == gym.spaces.MultiBinary([4, 2])
    assert first[:, 1].tolist() == [0, 0, 0, 0]
    assert env.step(act([1, 0, 0, 0]))[0][:, 1].tolist() == [0, 1, 0, 0]
    assert env.step(act([0, 1, 0, 0]))[0][:, 1].tolist() == [1, 0, 1, 0]
    assert env.step(act([1, 0, 1, 1]))[0][:, 1].tolist() == [0, 1, 0, 0]
    assert env.step(act([0, 0, 0, 0]))[0][:, 1].tolist() == [0, 0, 0, 0], "a message lasts one tick"


def test_hearing_changes_nothing_in_what_is_seen_or_how_robots_move() -> None:
    deaf = dataclasses.replace(WORLD, broadcast=None)
    one, other = gym.make("HeRo/Swarm-v0", world=WORLD), gym.make("HeRo/Swarm-v0", world=deaf)
    one.reset(seed=3)
    other.reset(seed=3)
    generator = np.random.default_rng(0)
    for _ in range(100):
        action = generator.uniform([-0.09, -1.6, 0], [0.09, 1.6, 1], (4, 3)).astype(np.float32)
        with_it, without_it = one.step(action), other.step(action[:, :2])
        assert with_it[0][:, 0].tolist() == without_it[0].tolist()
        assert with_it[4]["poses"].tolist() == without_it[4]["poses"].tolist()


def test_controllers_of_eight_numbers_act_on_what_robots_hear() -> None:
    stand = [0.0, 0.0]
    # nothing; sees; hears; both: robot 1 looks at robot 0, so robot 0 hears it and drives
    controller = [*stand, *stand, 0.05, 0.0, *stand]
    poses = POSES.copy()
    poses[0, 2] = np.pi / 2
    runs = swarm_envs.rollouts(WORLD, [controller], initial_poses=poses[None], steps=15)
    assert runs.detections.shape == (1, 16, 4, 2)
    assert runs.detections[0, 1:, 1, 0].all()
    assert runs.detections[0, 1:, 0, 1].all()
    assert runs.poses[0, -1, 0, 1] == pytest.approx(0.3 + 0.05 * 1.4, abs=1e-6), "one tick passes before the first message is heard"
    assert np.ptp(runs.poses[0, :, 3, :2]) == pytest.approx(np.ptp(poses[3, :2])), "out of range"
    four = swarm_envs.rollouts(WORLD, [[0.05, 0.1, 0.02, 0.3]], initial_poses=poses[None], steps=20)
    deaf = swarm_envs.rollouts(dataclasses.replace(WORLD, broadcast=None), [[0.05, 0.1, 0.02, 0.3]], initial_poses=poses[None], steps=20)
    assert (four.poses == deaf.poses).all(), "a controller of four numbers listens to nobody"


def test_every_form_of_environment_takes_it() -> None:
    check_env(gym.make("HeRo/Aggregation-v0", world=WORLD, render_mode="rgb_array").unwrapped)
    many = pettingzoo.make("parallel", "HeRo/Aggregation-v0", world=WORLD)
    many.reset(seed=0, options={"initial_poses": POSES})
    observations, *_ = many.step({f"robot_{i}": np.array([0, 0, i == 0], np.float32) for i in range(4)})
    assert [int(observations[f"robot_{i}"][1]) for i in range(4)] == [0, 1, 0, 0]
    native = gym.make_vec("HeRo/Swarm-v0", num_envs=2, vectorization_mode="vector_entry_point", world=WORLD)
    native.reset(options={"initial_poses": np.stack([POSES, POSES])})
    heard = native.step(np.stack([act([1, 0, 0, 0]), act([0, 0, 1, 0])]))[0][:, :, 1]
    assert heard.tolist() == [[0, 1, 0, 0], [0, 1, 0, 0]]


def test_a_world_file_may_have_one(tmp_path: Path) -> None:
    file = tmp_path / "talking.yaml"
    file.write_text("extends: hero_plus\nbroadcast: {range: {value: 0.5, unit: m, source: an assumption}}\n")
    world = swarm_envs.load_world(file)
    assert world.broadcast == Broadcast(range=0.5)
    assert world_from_text(world_to_text(world)) == world
    file.write_text("extends: hero_plus\nbroadcast: {range: {value: -1, unit: m}}\n")
    with pytest.raises(WorldError, match=r"talking\.yaml: broadcast\.range"):
        swarm_envs.load_world(file)


def test_messages_in_a_world_without_broadcast_are_refused() -> None:
    simulation = swarm_envs.Simulation("hero_plus", 1)
    with pytest.raises(WorldError, match="has no broadcast"):
        simulation.step(np.zeros((1, 8, 2)), messages=np.ones((1, 8)))
