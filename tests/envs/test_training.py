"""What the training guide shows runs as shown, with the trainers that researchers use."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "guides" / "training.md"
SNIPPETS = dict(re.findall(r"## ([^\n]*)\n(?:(?!## ).)*?```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL))


def run(title: str) -> dict[str, object]:
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=DeprecationWarning)  # the trainers' own
        exec(compile(SNIPPETS[title], title, "exec"), names)
    return names


def test_the_guide_has_every_snippet() -> None:
    assert len(SNIPPETS) == 6, sorted(SNIPPETS)


@pytest.mark.trainers
@pytest.mark.parametrize(
    ("title", "steps"),
    [
        ("One agent for the whole swarm: Stable-Baselines3", 1024),
        ("One policy shared by all robots: SuperSuit and Stable-Baselines3", 2048),
    ],
)
def test_stable_baselines_updates_its_policy(title: str, steps: int) -> None:
    pytest.importorskip("stable_baselines3")
    model = run(title)["model"]
    assert model.num_timesteps == steps  # type: ignore[attr-defined]
    assert model._n_updates >= 10  # type: ignore[attr-defined]
    assert np.isfinite(model.logger.name_to_value["train/loss"])  # type: ignore[attr-defined]


@pytest.mark.trainers
def test_torchrl_finds_the_specs_right_and_rolls_out() -> None:
    pytest.importorskip("torchrl")
    names = run("TorchRL")
    rollout = names["rollout"]
    assert rollout["next", "robot", "reward"].shape == (100, 8, 1)  # type: ignore[index]
    assert rollout["next", "robot", "reward"].sum() > 0  # type: ignore[index]
    assert rollout["state"].shape == (100, 8, 3)  # type: ignore[index]
    assert names["env"].group_map == {"robot": [f"robot_{i}" for i in range(8)]}  # type: ignore[attr-defined]


@pytest.mark.parametrize("title", ["Many swarms at once", "A task of your own", "Robots that talk"])
def test_the_other_snippets_run(title: str) -> None:
    run(title)
