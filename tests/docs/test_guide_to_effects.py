"""The effect that the guide adds works wherever effects do, with as few files changed as the guide claims."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.docs.test_guides import PAGES, run, snippets, tree_with_changes

PARTS = snippets(PAGES["guides/add_effect"])
DRIVES = """
import json
from tests.calibration.changed_law import call_chipmunk_from_python, ends
call_chipmunk_from_python()
print(json.dumps([ends({}), ends({"reverse_gain": 0.8})]))
"""
DOCUMENTED = """
from sphinx.pycode import ModuleAnalyzer
from docs.site.quantities import declared
print(*ModuleAnalyzer.for_module("swarm_envs.worlds.effects").find_attr_docs()["Effects", "reverse_gain"])
print(declared("swarm_envs.worlds.Effects.reverse_gain"))
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tree_with_changes(PARTS, tmp_path_factory.mktemp("effect"))


def test_it_takes_at_most_four_files() -> None:
    changed = {name for part in PARTS for name in re.findall(r"^\+\+\+ b/(\S+)", part.text, flags=re.MULTILINE)}
    assert 1 <= len(changed) <= 4, sorted(changed)


def test_it_acts_alike_in_both_engines_in_prediction_and_in_the_filter(tree: Path) -> None:
    program = [sys.executable, "-W", "ignore", "-c", DRIVES]
    without, found = json.loads(run(program, tree, tree, NUMBA_DISABLE_JIT="1"))
    assert set(found) == {"disc", "chipmunk", "prediction", "filter"}
    assert min(np.abs(np.subtract(found[way], without[way])).max() for way in found) > 1e-3, "it must act everywhere"
    assert np.ptp(list(found.values()), axis=0).max() < 1e-14, "and alike"


def test_a_world_file_knows_it_and_its_bounds(tree: Path) -> None:
    (tree / "mine.yaml").write_text("extends: hero_plus\neffects: {reverse_gain: 0.5}\n")
    (tree / "wrong.yaml").write_text("extends: hero_plus\neffects: {reverse_gain: -1}\n")
    program = "import swarm_envs; print(swarm_envs.load_world('mine.yaml').robots[0].effects.reverse_gain)"
    assert run([sys.executable, "-c", program], tree, tree) == "0.5\n"
    program = "import swarm_envs\ntry: swarm_envs.load_world('wrong.yaml')\nexcept swarm_envs.WorldError as error: print(error)"
    assert "reverse_gain: given -1, expected a number from 0 to 10" in run([sys.executable, "-c", program], tree, tree)


def test_the_reference_tells_what_it_does_its_unit_and_its_bounds(tree: Path) -> None:
    if importlib.util.find_spec("sphinx") is None:
        pytest.skip("sphinx is absent: it reads the sentence of a field")
    told = run([sys.executable, "-W", "ignore", "-c", DOCUMENTED], tree, tree)
    assert "Factor on the driven speed of a robot that reverses." in told
    assert "A pure number, from 0 to 10; neutral 1; acts on: drive." in told
