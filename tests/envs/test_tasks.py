"""Each task rewards its own behaviour, with the same bits in every form."""

from __future__ import annotations

import functools
import math

import gymnasium as gym
import numpy as np
import numpy.typing as npt
import pettingzoo
import pytest

import swarm_envs
from swarm_envs import behaviours
from swarm_envs.envs import ENVIRONMENTS, SwarmVectorEnv
from swarm_envs.envs.tasks import TASKS, make_rewards

BEHAVIOUR = {
    "Aggregation": "aggregation",
    "CyclicPursuit": "cyclic pursuit",
    "Dispersal": "dispersal",
    "Milling": "milling",
    "WallFollowing": "wall following",
}
EXAMPLES = {  # found among uniform controllers of `unrefined`, the only world in which the paper saw all five; m/s and rad/s
    "aggregation": [-0.138, 1.796, 0.114, 0.822],
    "cyclic pursuit": [0.182, -1.116, 0.147, 0.569],
    "dispersal": [0.012, 2.195, -0.034, 1.717],
    "milling": [-0.123, -0.776, -0.027, -2.501],
    "wall following": [0.167, 0.14, -0.135, -1.693],
}
WORLD = swarm_envs.load_world("unrefined")
Array = npt.NDArray[np.float64]


def rewards_of(task: str, poses: Array, world: swarm_envs.WorldSpec = WORLD) -> Array:
    """Rewards (worlds, frames - 1) of trajectories (worlds, frames, robots, 3)."""
    reward = make_rewards(task, world)
    return np.stack(
        [
            reward(np.ascontiguousarray(a), np.ascontiguousarray(b))
            for a, b in zip(*(np.moveaxis(p, 1, 0) for p in (poses[:, :-1], poses[:, 1:])), strict=True)
        ],
        axis=1,
    )


@functools.cache
def random_runs() -> tuple[Array, npt.NDArray[np.str_]]:
    """Poses and labels of 200 uniform controllers."""
    limits = np.array([WORLD.limits.linear_speed, WORLD.limits.angular_speed] * 2)
    runs = swarm_envs.rollouts(WORLD, np.random.default_rng(4).uniform(-1, 1, (200, 4)) * limits)
    return runs.poses, np.array(behaviours.label(runs))


@functools.cache
def example_runs() -> dict[str, Array]:
    """Poses of each behaviour's controller from five starts."""
    return {name: swarm_envs.rollouts(WORLD, [controller] * 5, seed=2).poses for name, controller in EXAMPLES.items()}


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_controllers_show_their_behaviour(name: str) -> None:
    runs = swarm_envs.rollouts(WORLD, [EXAMPLES[name]] * 5, seed=2)
    assert behaviours.label(runs).count(name) >= 4


@pytest.mark.parametrize("task", TASKS)
def test_a_behaviour_scores_above_random_controllers_on_its_task(task: str) -> None:
    poses, labels = random_runs()
    returns, behaviour = rewards_of(task, poses).mean(axis=1), BEHAVIOUR[task]
    example = np.median(rewards_of(task, example_runs()[behaviour]).mean(axis=1))
    assert example > 1.5 * returns.mean(), "the mean of all, some of which show the behaviour too"
    assert example > np.quantile(returns[labels != behaviour], 0.95), "nearly every one that does not show it"


@pytest.mark.parametrize("task", TASKS)
def test_each_behaviour_is_the_highest_on_its_own_task(task: str) -> None:
    means = {name: rewards_of(task, poses).mean() for name, poses in example_runs().items()}
    assert max(means, key=lambda name: means[name]) == BEHAVIOUR[task], means


@pytest.mark.parametrize("task", TASKS)
def test_among_random_controllers_those_with_the_behaviour_score_highest(task: str) -> None:
    poses, labels = random_runs()
    returns = rewards_of(task, poses).mean(axis=1)
    means = {name: returns[labels == name].mean() for name in set(labels)}
    if BEHAVIOUR[task] in means:  # the rarest may be absent
        assert max(means, key=lambda name: means[name]) == BEHAVIOUR[task], means
    assert returns.max() < 1.0


@pytest.mark.parametrize("task", TASKS)
def test_rewards_lie_between_0_and_1_wherever_robots_are(task: str) -> None:
    generator = np.random.default_rng(0)
    for world in (WORLD, swarm_envs.load_world("hero_plus", num_robots=1), swarm_envs.load_world("hero_plus", num_robots=2)):
        width, height = world.size
        before = generator.uniform([0, 0, -9], [width, height, 9], (500, world.num_robots, 3))
        before[:50] = before[:50, :1]  # all in one place
        for after in (before, before + generator.normal(0, 0.02, before.shape), generator.permutation(before)):
            rewards = make_rewards(task, world)(before, after)
            assert rewards.shape == (500,)
            assert ((rewards >= 0) & (rewards <= 1)).all()


def ring(radius: float, phase: float, robots: int = 8) -> Array:
    angle = phase + 2 * math.pi * np.arange(robots) / robots
    return np.stack([0.85 + radius * np.cos(angle), 0.71 + radius * np.sin(angle), angle], axis=-1)[None]


def test_a_perfect_ring_of_pursuers_at_full_speed_scores_1() -> None:
    world = swarm_envs.load_world("hero_plus")
    turn = world.limits.linear_speed * world.tick / 0.3
    assert make_rewards("CyclicPursuit", world)(ring(0.3, 0.0), ring(0.3, turn))[0] == pytest.approx(1.0, abs=1e-3)
    assert make_rewards("CyclicPursuit", world)(ring(0.3, 0.0), ring(0.3, -turn / 2))[0] == pytest.approx(0.5, abs=1e-3)
    assert make_rewards("Milling", world)(ring(0.3, 0.0), ring(0.3, turn))[0] == pytest.approx(0.0, abs=1e-9)


def test_a_patrol_along_the_wall_scores_its_speed() -> None:
    world = swarm_envs.load_world("hero_plus")
    before = np.array([[[0.3 + 0.13 * i, 0.06, 0.0] for i in range(8)]])
    after, up = before + np.array([0.5 * world.limits.linear_speed * world.tick, 0.0, 0.0]), np.array([0, 0.5, 0])
    assert make_rewards("WallFollowing", world)(before, after)[0] == pytest.approx(0.5)
    assert make_rewards("WallFollowing", world)(before + up, after + up)[0] < 0.02, "in the middle of the floor"


@pytest.mark.parametrize("task", TASKS)
def test_turning_or_renumbering_the_swarm_changes_no_reward(task: str) -> None:
    world = swarm_envs.load_world("hero_plus")
    poses, _ = random_runs()
    before, after = np.ascontiguousarray(poses[:20, 300]), np.ascontiguousarray(poses[:20, 301])
    reward = make_rewards(task, world)
    order = np.random.default_rng(1).permutation(8)
    turned = [np.stack([1.7 - p[..., 0], 1.42 - p[..., 1], p[..., 2] + math.pi], axis=-1)[:, order] for p in (before, after)]
    assert reward(*turned) == pytest.approx(reward(before, after), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_every_form_gives_the_same_rewards_to_the_last_bit(name: str) -> None:
    task = ENVIRONMENTS[name]
    single = gym.make(name, engine="disc", disable_env_checker=True)
    many = pettingzoo.make("parallel", name, engine="disc")
    native = SwarmVectorEnv(3, engine="disc", task=task)
    single.reset(seed=6)
    many.reset(seed=6)
    native.reset(seed=5)
    generator, total = np.random.default_rng(0), 0.0
    for _ in range(50):
        actions = generator.uniform(-1, 1, (3, 8, 2)).astype(np.float32) * native.single_action_space.high
        _, reward, *_ = single.step(actions[1])
        _, rewards, *_ = many.step({f"robot_{i}": actions[1, i] for i in range(8)})
        assert set(rewards.values()) == {reward}
        assert native.step(actions)[1][1] == reward
        assert type(reward) is float
        total += reward
    assert (total > 0) == (task is not None)


def test_a_task_of_ones_own_is_a_function_of_the_world() -> None:
    def northwards(world: swarm_envs.WorldSpec):  # type: ignore[no-untyped-def]
        return lambda before, after: (after - before)[:, :, 1].sum(axis=1) / world.tick

    env = gym.make("HeRo/Swarm-v0", task=northwards, num_robots=2)
    poses = np.array([[0.5, 0.5, math.pi / 2], [0.9, 0.5, math.pi / 2]])
    env.reset(options={"initial_poses": poses})
    assert env.step(np.array([[0.05, 0.0], [0.03, 0.0]], np.float32))[1] == pytest.approx(0.08, abs=1e-6)


def test_an_unknown_task_is_refused_in_one_line() -> None:
    with pytest.raises(ValueError, match="task is 'Flocking', expected one of Aggregation, CyclicPursuit"):
        gym.make("HeRo/Swarm-v0", task="Flocking")
