"""One import is enough."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_metrics_labels_and_pictures_are_there_after_import_swarm_envs_alone() -> None:
    program = (
        "import swarm_envs\n"
        "runs = swarm_envs.rollouts('hero_plus', [[0.07, -1.3, 0.06, 1.1]] * 2)\n"
        "print(swarm_envs.metrics.hand_crafted(runs).shape, swarm_envs.behaviours.label(runs), swarm_envs.rendering.Renderer.__name__)\n"
    )
    root = Path(__file__).parents[1]
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=root)
    assert result.stdout.split("\n")[0] == "(2, 5) ['cyclic pursuit', 'cyclic pursuit'] Renderer"


def test_each_module_can_be_imported_first() -> None:
    root = Path(__file__).parents[1]
    for name in ("metrics", "behaviours", "rendering", "worlds", "simulation", "envs"):
        subprocess.run([sys.executable, "-c", f"import swarm_envs.{name}"], check=True, cwd=root)
