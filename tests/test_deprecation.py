"""Old names still work, and say what the new ones are."""

from __future__ import annotations

import importlib

import pytest

from swarm_envs import Simulation

OLD = {
    "discovery.dataset.Dataset": "discovery.rollouts.dataset.Dataset",
    "discovery.representations.judged.fit_triplet": "discovery.representations.triplet.fit_triplet",
    "discovery.run_folder.RunFolder": "discovery.runs.run_folder.RunFolder",
    "swarm_envs.behaviours.Demand": "swarm_envs.behaviours.Condition",
    "swarm_envs.metrics.Trajectories": "swarm_envs.metrics.PoseTrajectories",
    "swarm_envs.metrics.polygon_edges": "swarm_envs.simulation.segments.polygon_edges",
    "swarm_envs.metrics.segment_distance": "swarm_envs.simulation.segments.segment_distance",
}


@pytest.mark.parametrize("old", OLD)
def test_an_old_name_forwards_to_the_new_one_with_a_warning(old: str) -> None:
    module, _, name = old.rpartition(".")
    with pytest.warns(DeprecationWarning, match=rf"{old} is now {OLD[old]}; use that"):
        found = getattr(importlib.import_module(module), name)
    home, _, new = OLD[old].rpartition(".")
    assert found is getattr(importlib.import_module(home), new)


@pytest.mark.parametrize(
    ("old", "new"),
    [("held", "latched_commands"), ("history", "command_history"), ("motion", "drive_velocity"), ("readings", "reading_history")],
)
def test_an_old_name_of_a_running_state_gives_the_same_array_with_a_warning(old: str, new: str) -> None:
    state = Simulation("hero_plus").state
    with pytest.warns(DeprecationWarning, match=rf"Simulation\.state\.{old} is now {new}; use that"):
        assert getattr(state, old) is getattr(state, new)


def test_a_name_that_never_was_is_still_an_error() -> None:
    with pytest.raises(AttributeError, match=r"module 'swarm_envs\.metrics' has no attribute 'wall_distance'"):
        importlib.import_module("swarm_envs.metrics").wall_distance  # noqa: B018
