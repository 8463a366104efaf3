"""The same question has the same answer, whoever asks it, where and beside what."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt
import pytest

from swarm_envs import Simulation, behaviours, load_world, metrics, rollouts, world_names

ENGINES = ["chipmunk", "disc"]


def drive(simulation: Simulation, seed: int, ticks: int = 200) -> npt.NDArray[np.float64]:
    """Poses after ticks of random driving, the same for the same seed."""
    world, generator = simulation.world, np.random.default_rng(seed)
    simulation.reset(seed)
    for _ in range(ticks):
        limits = [world.limits.linear_speed, world.limits.angular_speed]
        simulation.step(generator.uniform(-0.2, 1, (simulation.num_worlds, world.num_robots, 2)) * limits)
    return simulation.poses.copy()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", world_names())
def test_a_world_that_was_pickled_runs_to_the_same_bits(name: str, engine: str) -> None:
    world = load_world(name)
    limits = [world.limits.linear_speed, world.limits.angular_speed] * 2
    controllers = np.random.default_rng(0).uniform(-1, 1, (6, 4)) * limits
    runs = [rollouts(each, controllers, seed=3, steps=150, engine=engine) for each in (world, pickle.loads(pickle.dumps(world)))]
    assert (runs[0].poses == runs[1].poses).all()
    assert (runs[0].detections == runs[1].detections).all()


def test_pickled_trajectories_hold_the_same_and_are_judged_the_same() -> None:
    runs = rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1], [-0.09, -1.2, 0.0, -1.6]], seed=1)
    again = pickle.loads(pickle.dumps(runs))
    assert (again.world, again.engine) == (runs.world, runs.engine)
    for field in ("time", "poses", "detections", "commands"):
        assert (getattr(again, field) == getattr(runs, field)).all()
    assert (metrics.hand_crafted(again) == metrics.hand_crafted(runs)).all()
    assert behaviours.label(again) == behaviours.label(runs)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pickled_simulation_that_starts_again_runs_to_the_same_bits(engine: str) -> None:
    used = Simulation("hero_plus", 2, engine)
    drive(used, seed=5, ticks=30)
    assert (drive(pickle.loads(pickle.dumps(used)), seed=6) == drive(Simulation("hero_plus", 2, engine), seed=6)).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_simulations_stepped_side_by_side_in_threads_do_not_disturb_one_another(engine: str) -> None:
    alone = [drive(Simulation("hero_plus", 2, engine), seed) for seed in range(8)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda seed: drive(Simulation("hero_plus", 2, engine), seed), range(8)))
    assert all((one == other).all() for one, other in zip(alone, together, strict=True))
