"""Any number of a shipped world may be damaged: the file is refused in one line that names it, or the world it describes can run."""

from __future__ import annotations

import copy
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_envs import Simulation, WorldError, load_world, world_names
from swarm_envs.worlds.load import WORLDS

pytestmark = pytest.mark.slow

JUNK: list[Any] = [None, "", "x", True, -1, 0, 1e-12, 1e9, math.nan, math.inf, [], [1], {}, {"value": 1}, [[0, 0]], "hero_plus"]


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything in a document but its root."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [found for key, item in items for found in [(*path, key), *places(item, (*path, key))]]


DOCUMENTS = {name: yaml.safe_load((WORLDS / f"{name}.yaml").read_text(encoding="utf-8")) for name in world_names()}
PLACES = [(name, place) for name, document in DOCUMENTS.items() for place in places(document)]


def damage(document: Any, place: tuple[Any, ...], how: Any) -> Any:
    """The document with one place removed, renamed or replaced by junk."""
    changed = copy.deepcopy(document)
    node = changed
    for key in place[:-1]:
        node = node[key]
    if how == "remove":
        del node[place[-1]]
    elif how == "rename" and isinstance(node, dict):
        node[f"{place[-1]}x"] = node.pop(place[-1])
    else:
        node[place[-1]] = how
    return changed


def load_and_run(document: Any) -> str | None:
    """The complaint about a world file, None when it loads; a world that loads must run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.yaml"
        path.write_text(yaml.safe_dump(document), encoding="utf-8")
        try:
            world = load_world(path)
        except WorldError as error:
            return str(error)
    simulation = Simulation(world)
    for _ in range(3):
        simulation.step(np.tile([world.limits.linear_speed, -world.limits.angular_speed], (1, world.num_robots, 1)))
    assert np.isfinite(simulation.poses).all()
    return None


@settings(max_examples=300, deadline=None, derandomize=True)
@given(where=st.sampled_from(PLACES), how=st.sampled_from([*JUNK, "remove", "rename"]))
def test_damage_is_refused_in_one_line_with_the_files_name_or_does_no_harm(where: tuple[str, tuple[Any, ...]], how: Any) -> None:
    name, place = where
    complaint = load_and_run(damage(DOCUMENTS[name], place, how))
    if complaint is not None:
        assert "\n" not in complaint
        assert "damaged.yaml" in complaint


@pytest.mark.parametrize(
    "place", [place for name, place in PLACES if name == "hero_plus" and place[-1] == "value"], ids=lambda place: ".".join(map(str, place))
)
@pytest.mark.parametrize("junk", [math.nan, math.inf, "x", None, -1e6, {}])
def test_no_number_of_hero_plus_can_be_nonsense_and_the_refusal_names_its_key(place: tuple[Any, ...], junk: Any) -> None:
    complaint = load_and_run(damage(DOCUMENTS["hero_plus"], place, junk))
    assert complaint is not None, "nonsense was accepted"
    assert ".".join(place[:-1]) in complaint
    assert "expected" in complaint or "not" in complaint
