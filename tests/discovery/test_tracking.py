"""Trackers show a run's progress, each step once, also after a resume."""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from discovery import tracking
from discovery.command import RunContext, run
from discovery.errors import DiscoveryError
from discovery.runs.run_folder import ENCODER, METRICS, RunFolder
from discovery.tracking import Tracker, make_tracker
from tests.discovery.stopping import run_until
from tests.discovery.tiny_run import tiny


def shown(path: Path, stage: str) -> EventAccumulator:
    """What TensorBoard reads; of a folder with one event file, every event is in that file."""
    files = list((path / "tensorboard" / stage).glob("events.out.tfevents.*"))
    assert len(files) == 1
    return EventAccumulator(str(files[0]), size_guidance={"scalars": 0, "images": 0}).Reload()


def assert_complete(path: Path) -> None:
    metrics = json.loads((path / METRICS).read_text())
    training, search = shown(path, "training"), shown(path, "search")
    loss = training.Scalars("loss")
    assert [event.step for event in loss] == [1, 2, 3, 4]
    assert [event.value for event in loss] == pytest.approx(metrics["loss"])
    rates = [event.value for event in training.Scalars("learning_rate")]
    assert len(rates) == 4
    assert rates[0] < rates[1] >= rates[2] > rates[3] >= 0, "after the warm-up it falls"
    assert [event.step for event in search.Scalars("novelty/mean")] == [0, 1, 2]
    assert [event.value for event in search.Scalars("novelty/mean")] == pytest.approx(metrics["novelty_by_generation"])
    assert all(event.value > 0 for event in search.Scalars("novelty/max"))
    assert sum(search.Scalars(tag)[-1].value for tag in search.Tags()["scalars"] if tag.startswith("labels/")) == 24
    assert len(shown(path, "medoids").Tags()["images"]) == 10


def test_tensorboard_shows_losses_rates_novelty_labels_and_medoids(finished: Path) -> None:
    assert_complete(finished)


def test_a_resumed_run_has_no_entry_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "stopped"
    for place in ("training/step-0000003", ENCODER, "search/00002", METRICS):
        run_until(place, tiny(f"resume={path}" if path.exists() else f"folder={path}"), monkeypatch)
    run(tiny(f"resume={path}"), given=False, context=RunContext())
    assert_complete(path)


def test_no_tracker_leaves_nothing_and_a_missing_one_is_told_before_a_folder_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = RunFolder(tmp_path, tiny("tracker=none"))
    tracker = make_tracker(folder.path, folder.settings)
    tracker.begin("search")
    tracker.log("search", 0, {"novelty/mean": 1.0})
    tracker.close()
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(tracking.importlib.util, "find_spec", lambda name: None)
    for name, package in (("wandb", "wandb"), ("mlflow", "mlflow"), ("tensorboard", "'swarm-envs[discovery]'")):
        with pytest.raises(DiscoveryError, match=rf"^tracker={name}: .*; pip install {re.escape(package)}, or take tracker=none$"):
            run(tiny(f"tracker={name}", f"folder={tmp_path / 'run'}"), given=True, context=RunContext())
    assert list(tmp_path.iterdir()) == []


class PretendedWandb(ModuleType):
    """As much of wandb as is used; runs stay on its server."""

    def __init__(self) -> None:
        super().__init__("wandb")
        self.server: dict[str, Any] = {}

    def init(self, **given: Any) -> Any:
        entries, _ = self.server.setdefault(given["id"], ([], {}))
        summary: dict[str, float] = {}  # as offline, where wandb knows nothing of earlier sessions

        def log(numbers: dict[str, float]) -> None:
            entries.append(numbers)
            summary.update(numbers)

        return SimpleNamespace(log=log, summary=summary, define_metric=lambda *_, **__: None, finish=lambda: None)

    def Image(self, image: Any) -> Any:  # noqa: N802 - wandb's name
        return image.shape

    def steps(self, stage: str) -> list[int]:
        ((entries, _),) = self.server.values()
        return [entry[f"{stage}/step"] for entry in entries if f"{stage}/step" in entry]


class PretendedMLflow(ModuleType):
    """As much of MLflow as is used."""

    def __init__(self) -> None:
        super().__init__("mlflow")
        self.history: list[tuple[str, str, int]] = []
        self.runs = 0

    def MlflowClient(self) -> Any:  # noqa: N802 - MLflow's name
        def create_run(*_: Any, **__: Any) -> Any:
            self.runs += 1
            return SimpleNamespace(info=SimpleNamespace(run_id=f"run {self.runs}"))

        return SimpleNamespace(
            get_experiment_by_name=lambda name: None,
            create_experiment=lambda name: "1",
            create_run=create_run,
            log_param=lambda *_: None,
            log_metric=lambda run, key, value, step: self.history.append((run, key, step)),
            get_metric_history=lambda run, key: [SimpleNamespace(step=step) for at, name, step in self.history if (at, name) == (run, key)],
            log_image=lambda *_: None,
            set_terminated=lambda run: None,
        )

    def steps(self, stage: str) -> list[int]:
        counts = Counter(run for run, _, _ in self.history)
        assert list(counts) == ["run 1"]
        return [step for _, key, step in self.history if key == f"{stage}/step"]


def test_a_service_that_fails_does_not_end_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    service: Any = PretendedWandb()
    monkeypatch.setitem(sys.modules, "wandb", service)
    tracker = make_tracker(tmp_path, tiny("tracker=wandb"))
    tracker.begin("search")

    def fail(image: Any) -> None:
        raise ConnectionError("no route\nto host")

    service.Image = fail
    for _ in range(3):
        tracker.picture("search", "1 milling", np.zeros((4, 4, 3), np.uint8))
    tracker.close()
    assert capsys.readouterr().err == "discovery: wandb: ConnectionError: no route to host; going on without it\n"
    monkeypatch.setattr(service, "init", fail)
    with pytest.raises(DiscoveryError, match=r"^tracker=wandb: .*; set it up, or take tracker=tensorboard$"):
        make_tracker(tmp_path, tiny("tracker=wandb"))


@pytest.mark.parametrize("service", [PretendedWandb(), PretendedMLflow()], ids=lambda service: service.__name__)
def test_a_resumed_run_goes_on_in_a_service_where_it_stopped(service: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, service.__name__, service)
    for steps in (3, 5):  # stopped after three steps, resumed
        tracker: Tracker = make_tracker(tmp_path, tiny(f"tracker={service.__name__}"))
        for stage in ("training", "search"):
            tracker.begin(stage)
            for step in range(steps):
                tracker.log(stage, step, {"loss": 1.0})
        tracker.picture("medoids", "1 milling", np.zeros((4, 4, 3), np.uint8))
        tracker.flush()
        tracker.close()
    assert service.steps("training") == [0, 1, 2, 3, 4]
    assert service.steps("search") == [0, 1, 2, 3, 4]


def test_the_tracker_that_shows_nothing_has_its_old_name_for_one_version() -> None:
    with pytest.warns(DeprecationWarning, match=r"discovery\.tracking\.Silent is now discovery\.tracking\.interface\.NullTracker"):
        assert tracking.Silent is tracking.NullTracker
