"""The paper's behaviours emerge with the robot's own code in the loop."""

from __future__ import annotations

import numpy as np
import pytest

from hero_robot.firmware import FirmwareSwarm, State
from swarm_envs import Simulation, Trajectories, behaviours

SEEDS = 5
STEPS = 600


def drive(controller: tuple[float, float, float, float]) -> Trajectories:
    """The paper's run of 60 s from some starts, every robot driven by the firmware."""
    simulation = Simulation("hero_plus", SEEDS, "chipmunk")
    simulation.reset(11)
    swarms = [FirmwareSwarm("hero_plus", 8, controller, seed=seed) for seed in range(SEEDS)]
    for swarm in swarms:
        swarm.reset()
    tick = simulation.world.tick
    poses, detections, commands = [], [], []
    for _ in range(STEPS + 1):
        given = np.array([swarm.step(seen, tick) for swarm, seen in zip(swarms, simulation.detections, strict=True)])
        poses.append(simulation.poses.copy())
        detections.append(simulation.detections.copy())
        commands.append(given)
        simulation.step(given)
    assert all(board.view().state == State.RUN for swarm in swarms for board in swarm.boards)
    frames = [np.stack(frames, axis=1) for frames in (poses, detections, commands)]
    return Trajectories(simulation.world, "chipmunk", np.arange(STEPS + 1) * tick, *frames)


@pytest.mark.parametrize(
    ("controller", "expected"),
    [
        ((0.07, -1.3, 0.06, 1.1), "cyclic pursuit"),
        ((0.09, 0.8, 0.09, -0.8), "cyclic pursuit"),
        ((-0.09, -1.2, 0.0, -1.6), "aggregation"),
        ((0.07, 1.4, -0.07, 0.8), "dispersal"),
        ((0.06, 1.0, 0.06, 1.0), "random"),
    ],
)
def test_the_papers_behaviours_emerge_from_every_start(controller: tuple[float, float, float, float], expected: str) -> None:
    assert behaviours.label(drive(controller)) == [expected] * SEEDS
