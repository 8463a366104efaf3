"""The command: every mistake is one clear line and an exit status, never a traceback."""

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import discovery
from discovery.command import RunContext, run
from discovery.errors import DiscoveryError
from tests.discovery.tiny_run import TINY, tiny

pytestmark = pytest.mark.slow

Command = Callable[..., subprocess.CompletedProcess[str]]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("sed=3",), ["'sed'", "did you mean 'seed'"]),
        (("+colour=red",), ["colour"]),
        (("experiment=fast",), ["experiment: given 'fast'", "paper or quick"]),
        (("world=hero_pluss",), ["hero_pluss", "did you mean 'hero_plus'"]),
        (("search.population=many",), ["search.population", "many"]),
        (("search.crossover=1.5",), ["search.crossover", "1.5", "from 0 to 1"]),
        (("search.include=[[0.2,0,0,0]]",), ["v0 is 0.2", "at most 0.09 m/s"]),
        (("search.include=[[0.05,fast]]",), ["search.include", "[0.05, 'fast']", "four numbers"]),
        (("seed=",), ["seed"]),
        (("resume=nowhere",), ["resume=nowhere", "no such folder"]),
        (("--quick",), ["--quick", "key=value"]),
        (("experiment",), ["experiment"]),
    ],
)
def test_a_mistake_is_one_line_that_names_it(words: tuple[str, ...], expected: list[str], command: Command, tmp_path: Path) -> None:
    done = command(*words)
    assert done.returncode != 0
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("discovery: ")
    for part in expected:
        assert part in lines[0]
    assert list(tmp_path.iterdir()) == [], "a mistake left something behind"


def test_a_finished_run_is_never_overwritten(finished: Path, command: Command) -> None:
    before = {path: path.stat().st_mtime_ns for path in finished.rglob("*") if path.is_file() and path.name != ".lock"}
    for words in ((f"resume={finished}",), (*TINY, f"folder={finished}")):
        done = command(*words)
        assert done.returncode == 1
        assert len(done.stderr.strip().splitlines()) == 1
        assert "finished" in done.stderr
    assert before == {path: path.stat().st_mtime_ns for path in before}


def unfinished(finished: Path, tmp_path: Path) -> Path:
    """A copy of the tiny run from before its end."""
    path = tmp_path / "unfinished"
    shutil.copytree(finished, path)
    manifest = json.loads((path / "manifest.json").read_text())
    (path / "manifest.json").write_text(json.dumps(manifest | {"status": "running"}))
    return path


def test_resuming_with_other_settings_is_refused(finished: Path, tmp_path: Path) -> None:
    path = unfinished(finished, tmp_path)
    with pytest.raises(DiscoveryError, match=r"began with seed=0, this command says 1"):
        run(tiny(f"resume={path}", "seed=1"), given=True, context=RunContext())
    run(tiny(f"resume={path}"), given=True, context=RunContext())


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("config.yaml", "seed: [", "not readable"),
        ("config.yaml", "", "not readable"),
        ("config.yaml", None, "not a run folder"),
        ("manifest.json", "{", "not readable"),
        ("manifest.json", "[]", "not a manifest"),
    ],
)
def test_an_unreadable_folder_is_refused(name: str, content: str | None, expected: str, finished: Path, tmp_path: Path) -> None:
    path = unfinished(finished, tmp_path)
    if content is None:
        (path / name).unlink()
    else:
        (path / name).write_text(content)
    with pytest.raises(DiscoveryError, match=expected) as caught:
        run(tiny(f"resume={path}"), given=False, context=RunContext())
    assert "\n" not in str(caught.value)


def test_a_changed_config_is_noticed(finished: Path, tmp_path: Path, command: Command) -> None:
    path = unfinished(finished, tmp_path)
    (path / "config.yaml").write_text((path / "config.yaml").read_text().replace("seed: 0", "seed: 1"))
    done = command(f"resume={path}")
    assert done.returncode == 1
    assert done.stderr.strip().splitlines() == [
        f"discovery: {path / 'config.yaml'}: was changed since the run began; put it back, or start a new run"
    ]


def test_a_sweep_makes_one_run_for_each_value(command: Command, tmp_path: Path) -> None:
    done = command("-m", *TINY, "representation.epochs=0", "search.generations=2", "seed=0,1")
    assert done.returncode == 0, done.stderr
    reports = [line for line in done.stdout.splitlines() if line.endswith("report.html")]
    assert [json.loads((tmp_path / report).with_name("manifest.json").read_text())["seed"] for report in reports] == [0, 1]
    assert done.stdout.splitlines()[-1] == reports[-1]


def test_a_sweep_stops_with_one_line_too(command: Command) -> None:
    done = command("-m", "seed=0,1", "world=moon")
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert "moon" in done.stderr


def test_the_paper_experiment_holds_the_papers_numbers() -> None:
    from hydra import compose, initialize_config_dir

    from discovery.command import CONFIGS
    from discovery.settings import read_settings

    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        paper = read_settings(compose("config", ["experiment=paper"]))
    assert (paper.dataset.videos, paper.dataset.frames, paper.dataset.size, paper.steps) == (6000, 3, 64, 600)
    simclr = paper.representation
    assert (simclr.epochs, simclr.batch, simclr.weights, simclr.temperature) == (100, 1000, "imagenet", 0.5)
    assert simclr.learning_rate * simclr.batch / 256 == pytest.approx(1.17, abs=0.002)
    assert not simclr.normalise
    assert (simclr.weight_decay, simclr.crop_scale, simclr.flip) == (1.5e-7, [0.6, 1.0], 0.5)
    search = paper.search
    assert (search.population, search.generations, search.neighbours, search.crossover, search.mutation) == (50, 100, 15, 0.7, 0.15)
    assert (paper.clustering.medoids, paper.world) == (10, "hero_plus")


def test_a_run_is_read_back_in_three_lines(finished: Path) -> None:
    found = discovery.load_run(finished)
    assert found.embeddings.shape == (24, 512)
    assert len(found.medoids) == 10
    assert sum(medoid.share for medoid in found.medoids) == pytest.approx(1)
    assert [medoid.share for medoid in found.medoids] == sorted((medoid.share for medoid in found.medoids), reverse=True)


def test_the_encoder_read_back_gives_the_archives_embeddings(finished: Path) -> None:
    import numpy as np
    import torch

    from discovery.rollouts.simulator import Simulator
    from swarm_envs.rendering import videos
    from swarm_envs.worlds import load_world

    torch.set_num_threads(1)
    found = discovery.load_run(finished)
    first = found.archive.generation == 0
    rollouts = Simulator(load_world("hero_plus"), "chipmunk", 40, 1)(found.archive.controllers[first], int(found.archive.world_seed[0]))
    assert np.array_equal(found.encoder(videos(rollouts)), found.embeddings[first])


def test_the_manifest_says_what_made_the_run(finished: Path) -> None:
    manifest = json.loads((finished / "manifest.json").read_text())
    assert manifest["status"] == "finished"
    assert manifest["seed"] == 0
    assert {"torch", "ribs", "numpy", "lightly", "python"} <= manifest["versions"].keys()
    assert {"processor", "cores", "memory_gb"} <= manifest["machine"].keys()
    assert manifest["seconds"].keys() == {"dataset", "training", "search", "clusters", "agreement", "report"}
