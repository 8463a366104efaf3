"""What the calibration guide shows runs as shown, and findings.json is as it says."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from swarm_envs.calibration import read_log
from tests.calibration.guide import GUIDE, SNIPPETS, bash, python, snippet

SCHEMA = dict(re.findall(r"^\| `([a-z_.*\[\]0-9]+)` \| ([a-z ]+) \| ", GUIDE.partition("## findings.json")[2], flags=re.MULTILINE))
TYPES: dict[str, tuple[type, ...]] = {
    "text": (str,), "number": (int, float), "number or null": (int, float, type(None)), "mapping or null": (dict, type(None)),
}  # fmt: skip


def test_the_guide_has_every_snippet() -> None:
    assert [kind for kind, _ in SNIPPETS] == ["python", "bash", "python", "yaml", "yaml", "bash"]


def test_the_example_names_the_effects_that_its_robots_have(place: Path) -> None:
    causes = {cause["effect"]: cause["parameters"] for cause in json.loads((place / "calibrated" / "findings.json").read_text())["causes"]}
    assert set(causes) == {"linear_gain", "dead_time"}
    assert causes["linear_gain"]["gain"]["estimate"] == pytest.approx(0.85, abs=0.005)
    assert causes["dead_time"]["delay"]["estimate"] == pytest.approx(0.12, abs=0.01)


def test_the_python_snippet_runs(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    names = python(1)
    assert names["env"].unwrapped.spec.id == "HeRo/Swarm-v0"
    assert "linear_gain" in {cause.effect for cause in names["findings"].causes}


def test_the_example_of_a_log_yaml_is_read(place: Path, tmp_path: Path) -> None:
    shutil.copytree(place / "my_log", tmp_path / "my_log")
    (tmp_path / "my_log" / "log.yaml").write_text(snippet("yaml", 0))
    log = read_log(tmp_path / "my_log")
    assert log.outline is not None
    assert not log.driver_units


def test_the_example_of_a_topic_map_reads_bags(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rosbags")
    from tests.calibration.test_bags import ONE, posed, ranged, twist, write_one, yaw

    monkeypatch.chdir(tmp_path)
    (tmp_path / "topics.yaml").write_text(snippet("yaml", 1))
    for name in ("run_1", "run_2"):
        messages = []
        for robot in ("hero_1", "hero_2"):
            messages += [(f"/{robot}/cmd_vel", "geometry_msgs/msg/Twist", 0.0, twist(ONE, 0.05, 0.0))]
            for k in range(30):
                t = 0.1 * k
                messages += [(f"/{robot}/pose", "geometry_msgs/msg/PoseStamped", t, posed(ONE, t, (0.05 * t, 0.0, 0.1), yaw(0.0)))]
                messages += [(f"/{robot}/range", "sensor_msgs/msg/Range", t, ranged(ONE, t, 0.4))]
        write_one(tmp_path / f"{name}.bag", messages)
    bash(1)


def test_the_findings_are_as_the_guide_says(place: Path) -> None:
    """Every path of the file is in the guide's table with its type, and every path of the table is in the file or in an empty list."""
    document = json.loads((place / "calibrated" / "findings.json").read_text())
    found = dict(leaves(document, ""))
    for path, value in found.items():
        assert path in SCHEMA, f"{path} is not in the guide"
        assert isinstance(value, TYPES[SCHEMA[path]]), f"{path} is {value!r}, the guide says {SCHEMA[path]}"
    empty = {"data.notes", "discrepancies", "indistinguishable", "rejected"}
    for path in SCHEMA:
        assert path in found or path.split("[")[0] in empty, f"{path} of the guide is not in the file"


def leaves(node: Any, path: str) -> list[tuple[str, Any]]:
    if path in ("unexplained", "unlisted"):
        return [(path, node)]
    if isinstance(node, list):
        return [leaf for item in node for leaf in leaves(item, f"{path}[]")]
    if isinstance(node, dict):
        star = path.endswith(".parameters")
        return [leaf for key, item in node.items() for leaf in leaves(item, f"{path}.{'*' if star else key}".lstrip("."))]
    return [(path, node)]
