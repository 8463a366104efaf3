"""From controllers to rollouts: the one place where discovery asks the simulation."""

from __future__ import annotations

from dataclasses import dataclass

import swarm_envs
from discovery.controllers import FloatArray
from swarm_envs.simulation import Trajectories
from swarm_envs.worlds import WorldSpec


@dataclass(frozen=True)
class Simulator:
    """A world, an engine and a length of time."""

    world: WorldSpec
    engine: str
    steps: int
    threads: int

    def __call__(self, controllers: FloatArray, seed: int, first: int = 0) -> Trajectories:
        """Roll out each controller (W, 4) once; the start of rollout i is drawn from (seed, first + i)."""
        return swarm_envs.rollouts(
            self.world, controllers, seed=seed, first=first, steps=self.steps, record_every=1, threads=self.threads, engine=self.engine
        )

    def again(self, controller: FloatArray, seed: int, index: int) -> Trajectories:
        """Repeat rollout ``index`` of an earlier call with ``seed``, whose controller (4,) is given; one world, alone."""
        return self(controller[None], seed, first=index)
