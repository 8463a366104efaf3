"""A process that has imported what takes seconds and forks a run for each request: ``python -m tests.discovery.prepared``.

A request is a line of JSON, the overrides of a tiny run. Answers are lines too: the run's process id when it begins, its wait status
when it has ended. What a run prints goes to standard error.
"""

from __future__ import annotations

import json
import os
import sys

import numpy as np
import torch

import discovery.pipeline
from discovery.command import RunContext, run
from discovery.representations.encoder import make_network
from discovery.rollouts.simulator import Simulator
from swarm_envs.rendering import videos
from swarm_envs.worlds import load_world
from tests.discovery.tiny_run import tiny

assert discovery.pipeline


def warm_up() -> None:
    """Load compiled code; without threads, and without gradients, whose machinery no fork survives."""
    torch.set_num_threads(1)
    with torch.inference_mode():
        make_network(3, 0)(torch.zeros(2, 3, 64, 64))
    for engine in ("chipmunk", "disc"):
        videos(Simulator(load_world("hero_plus"), engine, 2, 1)(np.zeros((1, 4)), 0), threads=1)


def main() -> None:
    warm_up()
    for request in sys.stdin:
        settings = tiny(*json.loads(request))
        child = os.fork()
        if child == 0:
            os.dup2(2, 1)
            status = 1
            try:
                run(settings, given=settings.resume is None, context=RunContext())
                status = 0
            finally:
                os._exit(status)
        print(child, flush=True)
        print(os.waitpid(child, 0)[1], flush=True)


if __name__ == "__main__":
    main()
