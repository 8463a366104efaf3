"""A finished run's medoids, usable at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from PIL import Image

import discovery
from discovery import export
from hero_robot.fleet import FleetError, command
from hero_robot.fleet.controller_file import controller_document, read_controller


def test_each_medoid_becomes_a_film_and_a_file_that_robots_are_loaded_with(finished: Path, tmp_path: Path) -> None:
    assert export.main([str(finished), "--out", str(tmp_path / "medoids"), "--threads", "1"]) == 0
    assert sorted(path.name for path in (tmp_path / "medoids").iterdir()) == sorted(path.name for path in (finished / "medoids").iterdir())
    run = discovery.load_run(finished)
    for number, medoid in enumerate(run.medoids, start=1):
        (film,), (update,) = (list((tmp_path / "medoids").glob(f"{number:02d}-*.{kind}")) for kind in ("gif", "yaml"))
        assert film.stem == update.stem == f"{number:02d}-{medoid.label.replace(' ', '-')}"
        assert np.array_equal(read_controller(update), medoid.controller), "to the last bit"
        with Image.open(film) as image:
            assert image.n_frames > 3
    env = gym.make("HeRo/Swarm-v0", controller=run.medoids[0].controller)
    env.reset(seed=0)
    env.step(0)


def test_what_cannot_be_exported_is_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert export.main([str(tmp_path), "--out", str(tmp_path / "medoids")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("discovery.export: ")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, "cannot be read"),
        ("controller: [", "not valid YAML"),
        ("controller: [0.05, 1.0, 0.05]", "expected four numbers"),
        ("controller: [0.05, 1.0, .nan, 1.0]", "expected four numbers"),
        ("controller: [0.05, 1.0, fast, 1.0]", "expected four numbers"),
        ("- 1", "controller is None"),
    ],
)
def test_a_damaged_controller_file_is_refused_in_one_line(content: str | None, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "controller.yaml"
    if content is not None:
        path.write_text(content)
    with pytest.raises(FleetError, match=complaint) as caught:
        read_controller(path)
    assert "\n" not in str(caught.value)


def test_what_is_loaded_from_a_file_is_what_an_update_sends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sent: list[Any] = []

    def call(fleet_file: Path, path: str, body: Any = None) -> dict[str, Any]:
        sent.append((path, body))
        return {"outcomes": [{"robot": "hero_1", "done": True, "reason": "done"}]}

    monkeypatch.setattr(command, "_call", call)
    update = tmp_path / "controller.yaml"
    update.write_text(controller_document([0.07, -1.3, 0.06, 1.1], {"label": "milling"}))
    assert command.main(["load", "lab.yaml", str(update), "--robot", "hero_1"]) == 0
    assert command.main(["update", "lab.yaml", "0.07", "-1.3", "0.06", "1.1", "--robot", "hero_1"]) == 0
    assert sent[0] == sent[1] == ("update", {"controllers": {"hero_1": [0.07, -1.3, 0.06, 1.1]}})
    assert command.main(["load", "lab.yaml", str(tmp_path / "none.yaml"), "--robot", "hero_1"]) == 2
    assert "cannot be read" in capsys.readouterr().err
